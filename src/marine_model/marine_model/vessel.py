"""A vessel: everything the nodes need to know about it, validated."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from marine_model.gains import (
    AllocatorGains,
    ControllerGains,
    DriverGains,
    Measurement,
    ObserverGains,
    Simulation,
)
from marine_model.guards import FloatArray
from marine_model.hull import Manoeuvring, Particulars, WaveForces
from marine_model.power_plant import PowerPlant
from marine_model.propellers import BollardPropellers, PropellerModel
from marine_model.schema import FieldError, Positive, Section
from marine_model.sector import Sector
from marine_model.shaft_limits import check_shaft_limits
from marine_model.thruster import AzimuthThruster, Thruster
from marine_model.thruster_configuration import cartesian_configuration
from marine_model.ventilation.data import VentilationData


def _frozen(values: list[float]) -> FloatArray:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


class Vessel(Section):
    """One vessel file. Arrays over thrusters have shape (n,) and the order of the file."""

    name: str = Field(min_length=1)
    description: str
    scale: Positive  # length of the ship over length of what this file describes
    degrees_of_freedom: Annotated[tuple[Literal["surge"], Literal["sway"], Literal["yaw"]], Field(strict=False)]
    density: Positive  # kg/m^3
    hull: Particulars
    manoeuvring: Manoeuvring
    wave_forces: WaveForces
    thrusters: Annotated[tuple[Thruster, ...], Field(strict=False, min_length=1)]
    observer: ObserverGains
    controller: ControllerGains
    allocator: AllocatorGains
    drivers: DriverGains
    measurement: Measurement
    simulation: Simulation
    power: PowerPlant = PowerPlant()
    ventilation: VentilationData | None = None  # without it propellers lose nothing to air

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = self.thruster_names
        for i, name in enumerate(names):
            if name in names[:i]:
                raise FieldError(("thrusters", i, "name"), f"every name must be unique, found '{name}' twice")
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
        steps = self.measurement.sample_time / self.simulation.time_step
        if abs(steps - round(steps)) > 1e-9 or round(steps) < 1:
            raise FieldError(
                ("measurement", "sample_time"),
                "expected a whole multiple of simulation.time_step, found "
                f"{self.measurement.sample_time} and {self.simulation.time_step}",
            )
        return self

    @model_validator(mode="after")
    def _motors_reach_their_thrust(self) -> Self:
        check_shaft_limits(self.thrusters, self.propeller_models, self.density)
        return self

    @model_validator(mode="after")
    def _drivers_fit(self) -> Self:
        n = len(self.thrusters)
        for field, values in self.drivers.by_thruster().items():
            if len(values) not in (1, n):
                raise FieldError(
                    ("drivers", *field), f"expected one number, or {n}, one a thruster, found {len(values)}"
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
    def thruster_names(self) -> tuple[str, ...]:
        """Names in file order."""
        return tuple(thruster.name for thruster in self.thrusters)

    @cached_property
    def lever_x(self) -> FloatArray:
        """L_x, m ahead of the origin."""
        return _frozen([thruster.position[0] for thruster in self.thrusters])

    @cached_property
    def lever_y(self) -> FloatArray:
        """L_y, m to starboard of the origin."""
        return _frozen([thruster.position[1] for thruster in self.thrusters])

    @cached_property
    def thrust_min(self) -> FloatArray:
        """T_min, N."""
        return _frozen([thruster.thrust.min for thruster in self.thrusters])

    @cached_property
    def thrust_max(self) -> FloatArray:
        """T_max, N."""
        return _frozen([thruster.thrust.max for thruster in self.thrusters])

    @cached_property
    def thrust_rate(self) -> FloatArray:
        """Largest rate of change of thrust, N/s."""
        return _frozen([thruster.thrust.rate for thruster in self.thrusters])

    @cached_property
    def fixed_direction(self) -> FloatArray:
        """Direction of every thruster when none may rotate, rad."""
        return _frozen([thruster.fixed_direction for thruster in self.thrusters])

    @cached_property
    def can_rotate(self) -> tuple[bool, ...]:
        """True where the thruster is an azimuth thruster."""
        return tuple(isinstance(thruster, AzimuthThruster) for thruster in self.thrusters)

    @cached_property
    def azimuth_rate(self) -> FloatArray:
        """Largest commanded turning rate, rad/s; 0 for a tunnel thruster."""
        return _frozen([t.azimuth.rate if isinstance(t, AzimuthThruster) else 0.0 for t in self.thrusters])

    @cached_property
    def sectors(self) -> tuple[tuple[Sector, ...], ...]:
        """Forbidden and reduced sectors of every thruster; none for a tunnel thruster."""
        return tuple(t.azimuth.sectors if isinstance(t, AzimuthThruster) else () for t in self.thrusters)

    @cached_property
    def propellers(self) -> BollardPropellers:
        """Propellers of all thrusters at zero advance speed and design pitch ratio."""
        at_rest = [model.coefficients(0.0) for model in self.propeller_models]
        return BollardPropellers(
            diameter=_frozen([model.diameter for model in self.propeller_models]),
            thrust_coefficient=_frozen([float(thrust) for thrust, _ in at_rest]),
            torque_coefficient=_frozen([float(torque) for _, torque in at_rest]),
            density=self.density,
        )

    @cached_property
    def propeller_models(self) -> tuple[PropellerModel, ...]:
        """Propeller model of every thruster."""
        return tuple(thruster.propeller.build() for thruster in self.thrusters)

    @cached_property
    def propeller_table(self) -> FloatArray:
        """Rows of ``propeller_models`` for their kernel, shape (n, longest row), with zeros behind shorter ones."""
        rows = [model.row() for model in self.propeller_models]
        table = np.zeros((len(rows), max(map(len, rows))))
        for line, row in zip(table, rows, strict=True):
            line[: len(row)] = row
        table.setflags(write=False)
        return table

    @cached_property
    def pitch_ratio(self) -> FloatArray:
        """Design pitch ratio P/D."""
        return _frozen([model.pitch_ratio for model in self.propeller_models])

    @cached_property
    def shaft_depth(self) -> FloatArray:
        """Depth of every shaft below the calm waterline, m: z + x trim, for small angles of trim."""
        return _frozen([t.position[2] + t.position[0] * self.hull.trim for t in self.thrusters])

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
        return _frozen([np.inf if bus.limit is None else bus.limit for bus in self.power.buses])

    @cached_property
    def power_available(self) -> float:
        """P_AV, W; infinite when none is given."""
        return np.inf if self.power.available is None else self.power.available

    @cached_property
    def ventilation_row(self) -> FloatArray | None:
        """Packed parameters of ventilation (``marine_model.ventilation.table``); None without ventilation."""
        return None if self.ventilation is None else self.ventilation.row()
