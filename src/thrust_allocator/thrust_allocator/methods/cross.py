"""method = portioned: marching thrusters in a cross and a vertical bow thruster, [Kostenko]."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin

import numpy as np

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number
from thrust_allocator.feasible.directions import along_direction
from thrust_allocator.feasible.portioned import Cross, Portions, portion
from thrust_allocator.methods.method import Method, Wanted, both_ways, thrust_range
from thrust_allocator.methods.speed_limit import speed_limit_of
from thrust_allocator.plan.phase import Plan

AXES = ("surge", "heave", "pitch", "yaw")
# Directions and positions are written down to 12 digits.
_NEAR = 1e-6


@dataclass(frozen=True, slots=True)
class CrossThrusters:
    """The cross of a vessel.

    Attributes
    ----------
    order
        Which thrusters are U, D, L, R and B of (5).
    bow_sign
        +1 if positive thrust of the bow thruster pushes up, else -1.
    angle, stern_arm, bow_arm
        delta, rad; L_s and L_b, m.
    """

    order: tuple[int, ...]
    bow_sign: float
    angle: float
    stern_arm: float
    bow_arm: float


class PortionedMethod(Method):
    """Portions of surge, yaw and pitch; heave by the bow thruster.

    Parameters
    ----------
    vessel
        Geometry and limits.
    portions
        Shares of the channels.
    speed_limited
        Take T_max at the present speed, and not that of the vessel file, at rest.

    Raises
    ------
    InputError
        If the vessel has no such cross, or controls other axes, or its drives know nothing of speed.
    """

    def __init__(self, vessel: Vessel, portions: Portions, speed_limited: bool = False) -> None:
        self._cross = cross_of(vessel)
        self._order = np.array(self._cross.order)
        self._portions = portions
        self._limit_at = speed_limit_of(vessel, self._cross.order[:4]) if speed_limited else None
        if speed_limited and self._limit_at is None:
            raise InputError(
                "portions.speed_limited: expected false, because not every marching thruster has a drive with maps "
                "over speed, found true"
            )
        self._columns = vessel.columns
        self._speed = 0.0

    def measure_speed(self, speed: float) -> None:
        """Take the speed ahead, m/s; at rest until the first."""
        self._speed = finite_number("speed", speed)

    def want(self, plans: FloatArray, limits: FloatArray, tau: FloatArray) -> Wanted:
        """Divide a demand by portions of what the weakest marching thruster in use gives at this speed."""
        lower, upper = thrust_range(limits)
        cross, order = self._cross, self._order
        strength = both_ways(limits)[order[:4]]
        used = strength > 0.0
        most = float(strength[used].min()) if used.any() else 0.0
        if self._limit_at is not None:
            most = min(most, self._limit_at(self._speed))
        bow = sorted((cross.bow_sign * lower[order[4]], cross.bow_sign * upper[order[4]]))
        found = portion(
            tau[0],
            tau[1],
            tau[2],
            tau[3],
            Cross(cross.angle, cross.stern_arm, cross.bow_arm, *map(float, bow)),
            self._portions,
            most,
        )
        thrust = np.zeros(len(plans))
        thrust[order] = found.thrust
        thrust[order[4]] *= cross.bow_sign
        feasible = along_direction(self._columns, plans[:, Plan.AZIMUTH]).T @ thrust
        load = float(found.load)
        detail = f"{load:.3g} times what its portion allows demanded of a channel" if load > 1.0 else ""
        return Wanted(np.clip(thrust, lower, upper), feasible, load, detail)


def cross_of(vessel: Vessel) -> CrossThrusters:
    """Return the cross of a vessel.

    Raises
    ------
    InputError
        If its degrees of freedom are not surge, heave, pitch, yaw, or its thrusters not those of (5).
    """
    found = vessel.degrees_of_freedom
    if found != AXES:
        raise InputError(f"portioned: expected a vessel that controls {', '.join(AXES)}, found {', '.join(found)}")
    asked = "portioned: expected four marching thrusters in a cross and a vertical bow thruster"
    n = len(vessel.thrusters)
    if n != 5 or any(vessel.can_rotate):
        kind = " that do not turn" if n == 5 else ""
        raise InputError(f"{asked}{kind}, found {n} thrusters, {sum(vessel.can_rotate)} of which turn")
    forces = along_direction(vessel.columns6, vessel.fixed_direction)
    vertical = np.flatnonzero(np.abs(np.abs(forces[:, 2]) - 1.0) <= _NEAR)
    marching = [j for j in range(n) if j not in vertical]
    refused = InputError(f"{asked}, found {', '.join(vessel.thruster_names)} with other directions or places")
    if len(vertical) != 1:
        raise refused
    bow = int(vertical[0])
    # U pushes up, D down, L to port, R to starboard.
    order = [
        max(marching, key=lambda j: -forces[j, 2]),
        max(marching, key=lambda j: forces[j, 2]),
        max(marching, key=lambda j: -forces[j, 1]),
        max(marching, key=lambda j: forces[j, 1]),
    ]
    sign = -float(np.sign(forces[bow, 2]))
    across = float(forces[order[1], 2])
    if not 0.0 < across < 1.0 or len(set(order)) != 4:
        raise refused
    angle, bow_arm = asin(across), float(sign * forces[bow, 4])
    stern_arm = float(forces[order[1], 4] / across)
    c, s = float(np.cos(angle)), across
    expected = np.array(
        [
            [c, 0.0, -s, 0.0, -s * stern_arm, 0.0],
            [c, 0.0, s, 0.0, s * stern_arm, 0.0],
            [c, -s, 0.0, 0.0, 0.0, s * stern_arm],
            [c, s, 0.0, 0.0, 0.0, -s * stern_arm],
            [0.0, 0.0, -sign, 0.0, sign * bow_arm, 0.0],
        ]
    )
    near = _NEAR * max(1.0, stern_arm, bow_arm)
    if np.abs(forces[[*order, bow]] - expected).max() > near or stern_arm <= 0.0 or stern_arm + bow_arm <= 0.0:
        raise refused
    return CrossThrusters((*order, bow), sign, angle, stern_arm, bow_arm)
