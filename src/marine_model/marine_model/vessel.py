"""A vessel: everything the nodes need to know about it, validated."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from marine_model.gains import AllocatorGains, ControllerGains, ObserverGains
from marine_model.guards import FloatArray
from marine_model.hull import Manoeuvring, Particulars, WaveForces
from marine_model.power_plant import PowerPlant
from marine_model.propulsion import Propulsion, frozen
from marine_model.schema import FieldError, Positive
from marine_model.sector import Sector
from marine_model.thruster import AzimuthThruster
from marine_model.thruster_configuration import cartesian_configuration
from marine_model.units import Unit
from marine_model.wave_response import WaveResponse, load_wave_response
from marine_model.wind import WindForces


class Vessel(Propulsion):
    """One vessel file. Arrays over thrusters have shape (n,) and the order of the file."""

    description: str
    scale: Annotated[Positive, Unit("")]  # length of the ship over length of what this file describes
    degrees_of_freedom: Annotated[tuple[Literal["surge"], Literal["sway"], Literal["yaw"]], Field(strict=False)]
    hull: Particulars
    manoeuvring: Manoeuvring
    wave_forces: WaveForces
    wind_forces: WindForces | None = None  # without, the wind does not blow
    observer: ObserverGains
    controller: ControllerGains
    allocator: AllocatorGains
    power: PowerPlant = PowerPlant()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = self.thruster_names
        n, weights = len(self.thrusters), len(self.allocator.thrust_weight)
        if weights != n:
            raise FieldError(("allocator", "thrust_weight"), f"expected {n} numbers, one a thruster, found {weights}")
        if self.allocator.sectors is None and any(self.sectors):
            name = next(name for name, sectors in zip(names, self.sectors, strict=True) if sectors)
            raise FieldError(("allocator",), f"expected a field 'sectors', because thruster '{name}' has sectors")
        if not np.any(self.lever_x) and not np.any(self.lever_y):
            raise FieldError(("thrusters",), "all lever arms are zero, so that no yaw moment is possible")
        if np.linalg.matrix_rank(self._attainable_directions()) < 3:
            raise FieldError(("thrusters",), "together they cannot produce surge, sway and yaw independently")
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
        """Columns of generalized force: both components of an azimuth thruster, one of a tunnel."""
        n = len(self.thrusters)
        cartesian = cartesian_configuration(self.lever_x, self.lever_y)
        columns = []
        for j, thruster in enumerate(self.thrusters):
            if isinstance(thruster, AzimuthThruster):
                columns += [cartesian[:, j], cartesian[:, n + j]]
            else:
                angle = thruster.direction
                columns.append(np.cos(angle) * cartesian[:, j] + np.sin(angle) * cartesian[:, n + j])
        return np.column_stack(columns)

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
        name = self.wave_forces.response
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
