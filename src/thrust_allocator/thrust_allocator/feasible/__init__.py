"""What thrusters may be asked for before they are asked: methods of underwater vehicles, on plain arrays."""

from thrust_allocator.feasible.garus_azimuth import AzimuthSquare, next_angle
from thrust_allocator.feasible.octahedron import (
    axis_limits,
    coupled_axes,
    octahedron_load,
    octahedron_volume,
    reduce_proportionally,
    served_limits,
)
from thrust_allocator.feasible.portioned import Cross, PortionedThrust, Portions, portion
from thrust_allocator.feasible.priority import reduce_by_priority
from thrust_allocator.feasible.pseudo_inverse import pseudo_inverse, share_within

__all__ = [
    "AzimuthSquare",
    "Cross",
    "PortionedThrust",
    "Portions",
    "axis_limits",
    "coupled_axes",
    "next_angle",
    "octahedron_load",
    "octahedron_volume",
    "portion",
    "pseudo_inverse",
    "reduce_by_priority",
    "reduce_proportionally",
    "served_limits",
    "share_within",
]
