"""A vessel: everything the nodes need to know about it, validated."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from marine_model.axes import AXES, HORIZONTAL, Axis, axis_indices
from marine_model.errors import InputError
from marine_model.gains import AllocatorGains, ControllerGains, ObserverGains
from marine_model.guards import FloatArray
from marine_model.hull import Manoeuvring, Particulars, WaveForces
from marine_model.power_plant import PowerPlant
from marine_model.propulsion import Propulsion, frozen
from marine_model.schema import FieldError, Positive
from marine_model.sector import Sector
from marine_model.thruster import AzimuthThruster
from marine_model.thruster_configuration import thruster_columns
from marine_model.underwater import UnderwaterBody, check_body
from marine_model.units import Unit
from marine_model.vertical import VerticalGains
from marine_model.wave_response import WaveResponse, load_wave_response
from marine_model.wind import WindForces


class Vessel(Propulsion):
    """One vessel file. Arrays over thrusters have shape (n,) and the order of the file."""

    description: str
    scale: Annotated[Positive, Unit("")]  # length of the ship over length of what this file describes
    # The axes that are controlled: a demanded generalized force has one element for each, in this order.
    degrees_of_freedom: Annotated[tuple[Axis, ...], Field(strict=False, min_length=1)]
    hull: Particulars
    # A vessel on the surface has these two, a submerged one has the sections underwater and vertical.
    manoeuvring: Manoeuvring | None = None
    wave_forces: WaveForces | None = None
    underwater: UnderwaterBody | None = None
    vertical: VerticalGains | None = None
    wind_forces: WindForces | None = None  # without, the wind does not blow
    observer: ObserverGains
    controller: ControllerGains
    allocator: AllocatorGains
    power: PowerPlant = PowerPlant()

    @model_validator(mode="after")
    def _axes_in_order(self) -> Self:
        axes = self.degrees_of_freedom
        if list(axes) != [axis for axis in AXES if axis in axes]:
            raise FieldError(
                ("degrees_of_freedom",), f"expected each once, in the order {', '.join(AXES)}, found {', '.join(axes)}"
            )
        if self.underwater is None and axes != HORIZONTAL:
            raise FieldError(
                ("degrees_of_freedom",),
                f"expected {', '.join(HORIZONTAL)} without a section underwater, found {', '.join(axes)}",
            )
        return self

    @model_validator(mode="after")
    def _on_the_surface_or_below(self) -> Self:
        surface: dict[str, Any] = {"manoeuvring": self.manoeuvring, "wave_forces": self.wave_forces}
        below: dict[str, Any] = {"underwater": self.underwater, "vertical": self.vertical}
        submerged = any(section is not None for section in below.values())
        needed, excluded = (below, surface) if submerged else (surface, below)
        kind = "a submerged vehicle" if submerged else "a vessel on the surface"
        for name, section in needed.items():
            if section is None:
                raise FieldError((name,), f"expected this section, which {kind} needs, found none")
        for name, section in (excluded | {"wind_forces": self.wind_forces if submerged else None}).items():
            if section is not None:
                raise FieldError((name,), f"expected no such section for {kind}, found one")
        if self.underwater is not None:
            check_body(self.underwater, self.hull.mass, self.degrees_of_freedom)
        return self

    @model_validator(mode="after")
    def _thrusters_serve_every_axis(self) -> Self:
        axes = self.degrees_of_freedom
        if "yaw" in axes and not self.columns[:, axes.index("yaw")].any():
            raise FieldError(("thrusters",), "all lever arms are zero, so that no yaw moment is possible")
        if np.linalg.matrix_rank(self._attainable_directions()) < len(axes):
            names = f"{', '.join(axes[:-1])} and {axes[-1]}" if len(axes) > 1 else axes[0]
            raise FieldError(("thrusters",), f"together they cannot produce {names} independently")
        return self

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = self.thruster_names
        n, weights = len(self.thrusters), len(self.allocator.thrust_weight)
        if weights != n:
            raise FieldError(("allocator", "thrust_weight"), f"expected {n} numbers, one a thruster, found {weights}")
        m, weights = len(self.degrees_of_freedom), len(self.allocator.slack_weight)
        if weights != m:
            raise FieldError(
                ("allocator", "slack_weight"),
                f"expected {m} numbers, one for each of {', '.join(self.degrees_of_freedom)}, found {weights}",
            )
        if self.allocator.sectors is None and any(self.sectors):
            name = next(name for name, sectors in zip(names, self.sectors, strict=True) if sectors)
            raise FieldError(("allocator",), f"expected a field 'sectors', because thruster '{name}' has sectors")
        if self.manoeuvring is None:
            return self
        masses = [self.manoeuvring.rigid_body_mass[i][i] for i in (0, 1)]
        # Both are written down, to the digits of their sources.
        if any(abs(mass - self.hull.mass) > 0.01 * self.hull.mass for mass in masses):
            raise FieldError(
                ("manoeuvring", "rigid_body_mass"),
                f"expected hull.mass for surge and sway within 1 %, found {masses} and {self.hull.mass}",
            )
        return self

    @model_validator(mode="after")
    def _buses_feed_what_is_there(self) -> Self:
        names: set[str] = set()
        bus_of: dict[str, str] = {}
        for i, bus in enumerate(self.power.buses):
            at = ("power", "buses", i)
            if bus.name in names:
                raise FieldError((*at, "name"), f"every name must be unique, found '{bus.name}' twice")
            names.add(bus.name)
            for k, thruster in enumerate(bus.thrusters):
                if thruster not in self.thruster_names:
                    known = ", ".join(self.thruster_names)
                    raise FieldError((*at, "thrusters", k), f"expected one of {known}, found '{thruster}'")
                if thruster in bus_of:
                    raise FieldError((*at, "thrusters", k), f"'{thruster}' is on '{bus_of[thruster]}' already")
                bus_of[thruster] = bus.name
        return self

    def _attainable_directions(self) -> FloatArray:
        """Columns of generalized force over the axes: both components of an azimuth thruster, one of any other."""
        columns = []
        for j, thruster in enumerate(self.thrusters):
            if isinstance(thruster, AzimuthThruster):
                columns += [self.columns[j, :, 0], self.columns[j, :, 1]]
            else:
                angle = thruster.fixed_direction
                columns.append(np.cos(angle) * self.columns[j, :, 0] + np.sin(angle) * self.columns[j, :, 1])
        return np.column_stack(columns)

    @cached_property
    def is_submerged(self) -> bool:
        """Whether it moves in six degrees of freedom below the surface."""
        return self.underwater is not None

    def on_surface(self) -> tuple[Manoeuvring, WaveForces]:
        """Return the sections that only a vessel on the surface has.

        Raises
        ------
        InputError
            If this one is submerged.
        """
        if self.manoeuvring is None or self.wave_forces is None:
            raise InputError(f"vessel: expected one on the surface, found '{self.name}', which is submerged")
        return self.manoeuvring, self.wave_forces

    @cached_property
    def axis_indices(self) -> NDArray[np.intp]:
        """Where ``degrees_of_freedom`` stand among all six, shape (m,)."""
        return axis_indices(self.degrees_of_freedom)

    @cached_property
    def columns6(self) -> FloatArray:
        """Generalized force in all six degrees of freedom per newton along n_1 and n_2, shape (n, 6, 2): (4.3)."""
        columns = thruster_columns(
            np.array([thruster.position for thruster in self.thrusters]),
            np.array([thruster.plane for thruster in self.thrusters]),
        )
        columns.setflags(write=False)
        return columns

    @cached_property
    def columns(self) -> FloatArray:
        """The same over ``degrees_of_freedom`` only, shape (n, m, 2)."""
        columns = np.ascontiguousarray(self.columns6[:, self.axis_indices])
        columns.setflags(write=False)
        return columns

    @cached_property
    def lever_x(self) -> FloatArray:
        """L_x, m ahead of the origin."""
        return frozen([thruster.position[0] for thruster in self.thrusters])

    @cached_property
    def lever_y(self) -> FloatArray:
        """L_y, m to starboard of the origin."""
        return frozen([thruster.position[1] for thruster in self.thrusters])

    @cached_property
    def can_rotate(self) -> tuple[bool, ...]:
        """True where the thruster is an azimuth thruster."""
        return tuple(isinstance(thruster, AzimuthThruster) for thruster in self.thrusters)

    @cached_property
    def azimuth_rate(self) -> FloatArray:
        """Largest commanded turning rate, rad/s; 0 for a tunnel thruster."""
        return frozen([t.azimuth.rate if isinstance(t, AzimuthThruster) else 0.0 for t in self.thrusters])

    @cached_property
    def sectors(self) -> tuple[tuple[Sector, ...], ...]:
        """Forbidden and reduced sectors of every thruster; none for a tunnel thruster."""
        return tuple(t.azimuth.sectors if isinstance(t, AzimuthThruster) else () for t in self.thrusters)

    @cached_property
    def wave_response(self) -> WaveResponse | None:
        """Response of the hull to waves, read when first asked for; None where ``wave_forces`` describes a box.

        Raises
        ------
        DocumentError
            If the data file is missing or is not one.
        """
        name = None if self.wave_forces is None else self.wave_forces.response
        return None if name is None else load_wave_response(name)

    @cached_property
    def shaft_depth(self) -> FloatArray:
        """Depth of every shaft below the calm waterline, m: z + x trim, for small angles of trim."""
        return frozen([t.position[2] + t.position[0] * self.hull.trim for t in self.thrusters])

    @cached_property
    def bus_members(self) -> FloatArray:
        """Which thruster is on which bus, shape (number of buses, n): 1 where it is, 0 elsewhere."""
        rows = [[float(name in bus.thrusters) for name in self.thruster_names] for bus in self.power.buses]
        members = np.array(rows, dtype=np.float64).reshape(len(rows), len(self.thrusters))
        members.setflags(write=False)
        return members

    @cached_property
    def bus_limit(self) -> FloatArray:
        """P_bus of every bus, W; infinite where none is given."""
        return frozen([np.inf if bus.limit is None else bus.limit for bus in self.power.buses])

    @cached_property
    def power_available(self) -> float:
        """P_AV, W; infinite when none is given."""
        return np.inf if self.power.available is None else self.power.available
