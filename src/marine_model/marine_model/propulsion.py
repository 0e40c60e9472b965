"""Thrusters and what drives them: what a vessel and a test rig in open water have in common."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from marine_model.gains import DriverGains, Measurement, Simulation
from marine_model.guards import FloatArray
from marine_model.propellers import BollardPropellers, PropellerModel
from marine_model.schema import FieldError, Positive, Section
from marine_model.shaft_limits import check_shaft_limits
from marine_model.thruster import Thruster
from marine_model.units import Unit
from marine_model.ventilation.data import VentilationData


def frozen(values: list[float]) -> FloatArray:
    """Return a read-only array."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


class Propulsion(Section):
    """Thrusters with water, gains, sensors and time step. Arrays have shape (n,) and the order of ``thrusters``."""

    name: str = Field(min_length=1)
    density: Annotated[Positive, Unit("kg/m^3")]
    thrusters: Annotated[tuple[Thruster, ...], Field(strict=False, min_length=1)]
    drivers: DriverGains
    measurement: Measurement
    simulation: Simulation
    ventilation: VentilationData | None = None  # without it propellers lose nothing to air

    @model_validator(mode="after")
    def _thrusters_and_gains_agree(self) -> Self:
        names, n = self.thruster_names, len(self.thrusters)
        for i, name in enumerate(names):
            if name in names[:i]:
                raise FieldError(("thrusters", i, "name"), f"every name must be unique, found '{name}' twice")
        for field, values in self.drivers.by_thruster().items():
            if len(values) not in (1, n):
                raise FieldError(
                    ("drivers", *field), f"expected one number, or {n}, one a thruster, found {len(values)}"
                )
        return self

    @model_validator(mode="after")
    def _motors_reach_their_thrust(self) -> Self:
        check_shaft_limits(self.thrusters, self.propeller_models, self.density)
        return self

    @model_validator(mode="after")
    def _samples_are_whole_steps(self) -> Self:
        steps = self.measurement.sample_time / self.simulation.time_step
        if abs(steps - round(steps)) > 1e-9 or round(steps) < 1:
            raise FieldError(
                ("measurement", "sample_time"),
                "expected a whole multiple of simulation.time_step, found "
                f"{self.measurement.sample_time} and {self.simulation.time_step}",
            )
        # Stamps count whole nanoseconds. Decimal fractions are not exact: up to 1e3 s, by 1e-4 ns at most.
        nanoseconds = self.simulation.time_step * 1e9
        if abs(nanoseconds - round(nanoseconds)) > 1e-3 or round(nanoseconds) < 1:
            raise FieldError(
                ("simulation", "time_step"),
                f"expected a whole number of nanoseconds, found {self.simulation.time_step!r} s",
            )
        return self

    @cached_property
    def thruster_names(self) -> tuple[str, ...]:
        """Names in file order."""
        return tuple(thruster.name for thruster in self.thrusters)

    @cached_property
    def thrust_min(self) -> FloatArray:
        """T_min, N."""
        return frozen([thruster.thrust.min for thruster in self.thrusters])

    @cached_property
    def thrust_max(self) -> FloatArray:
        """T_max, N."""
        return frozen([thruster.thrust.max for thruster in self.thrusters])

    @cached_property
    def thrust_rate(self) -> FloatArray:
        """Largest rate of change of thrust, N/s."""
        return frozen([thruster.thrust.rate for thruster in self.thrusters])

    @cached_property
    def fixed_direction(self) -> FloatArray:
        """Direction of every thruster when none may rotate, rad."""
        return frozen([thruster.fixed_direction for thruster in self.thrusters])

    @cached_property
    def propellers(self) -> BollardPropellers:
        """Propellers of all thrusters at zero advance speed and design pitch ratio."""
        at_rest = [model.coefficients(0.0) for model in self.propeller_models]
        return BollardPropellers(
            diameter=frozen([model.diameter for model in self.propeller_models]),
            thrust_coefficient=frozen([float(thrust) for thrust, _ in at_rest]),
            torque_coefficient=frozen([float(torque) for _, torque in at_rest]),
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
        return frozen([model.pitch_ratio for model in self.propeller_models])

    @cached_property
    def ventilation_row(self) -> FloatArray | None:
        """Packed parameters of ventilation (``marine_model.ventilation.table``); None without ventilation."""
        return None if self.ventilation is None else self.ventilation.row()
