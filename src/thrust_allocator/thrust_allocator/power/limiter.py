"""Keeps the commands within the power there is: total and by bus, [Ruth] 4.4.3."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.engine import Answer, Engine
from thrust_allocator.plan.phase import LOST, ROTATING, Plan
from thrust_allocator.plan.polar import Command
from thrust_allocator.power.bus import BusRowKind, bus_row
from thrust_allocator.power.priority import PowerStage, limit_total_power
from thrust_allocator.power.total import full_power, measured_correction, phase_back, total_power
from thrust_allocator.program.problem import Coupling
from thrust_allocator.settings import PowerSettings
from thrust_allocator.step import Total

# From demand, shared limits and factor on the yaw weight to an answer.
Run = Callable[[FloatArray, Coupling | None, float], Answer]

# A measurement is used for this many samples of the vessel.
_LONGEST_AGE = 5.0
# Power within which a limit counts as kept: rounding of a sum.
_ROUNDING = 1e-12


class PowerReport(NamedTuple):
    """What power had to do with one step.

    Attributes
    ----------
    demanded
        P_T: predicted power of the demand before any limit, W. This is what a power plant is to be told.
    commanded
        Predicted power of the commands, W.
    correction
        P_meas / P_c of (4.44) that both contain; 1 without a measurement.
    stage
        What the total limit did.
    bus
        Predicted power of the commands by bus, shape (b,), W.
    bus_limited
        Per bus: its limit had a say.
    """

    demanded: float
    commanded: float
    correction: float
    stage: PowerStage
    bus: FloatArray
    bus_limited: tuple[bool, ...]


class PowerLimiter:
    """Power limits of one vessel.

    Parameters
    ----------
    vessel
        Propellers and buses.
    engine
        That makes the answers.
    """

    def __init__(self, vessel: Vessel, engine: Engine) -> None:
        self._engine = engine
        self._factor = engine.power_factor
        self._members = vessel.bus_members
        self._all = np.ones(len(vessel.thrusters))
        self._approach = vessel.allocator.approach_fraction
        self._longest_age = _LONGEST_AGE * vessel.measurement.sample_time
        self._full = full_power(self._factor, vessel.thrust_min, vessel.thrust_max)
        self.reset()

    def reset(self) -> None:
        """Forget measurements and commands."""
        self._measured: float | None = None
        self._age = 0.0
        self._commanded = 0.0

    def apply(self, settings: PowerSettings) -> None:
        """Take the settings; they hold from the next step on."""
        self._total = settings.available if settings.limit in ("total", "both") else np.inf
        on = settings.limit in ("bus", "both")
        self._limits = np.array(settings.bus_limit) if on else np.full(len(self._members), np.inf)
        self._yaw_priority = settings.priority == "yaw"
        self._uses_measurement = settings.measured

    def measure(self, power: float) -> None:
        """Take the power (W) that all thrusters together were measured to use, the lost ones left out."""
        self._measured, self._age = power, 0.0

    def step(self, run: Run, before: FloatArray, tau: FloatArray, dt: float) -> tuple[Answer, PowerReport]:
        """Return the answer to ``tau``, shape (3,), within the power limits.

        Parameters
        ----------
        run
            Allocates without them.
        before
            Commands of the step before, shape (n, 5).
        tau
            Demanded generalized force, shape (3,).
        dt
            Time step, s.
        """
        self._age += dt
        correction = 1.0
        if self._uses_measurement:
            correction = measured_correction(
                self._measured, self._commanded, self._age, self._longest_age, self._full
            ).factor
        coefficient = correction * self._factor
        limited = [False] * len(self._members)

        def allocate(demand: FloatArray, yaw_factor: float) -> tuple[float, Answer]:
            answer = run(demand, None, yaw_factor)
            if not answer.complaint:
                answer = self._within_buses(run, answer, before, coefficient, yaw_factor, limited)
            return self._power(answer, coefficient), answer

        free = run(tau, None, 1.0)
        demanded = self._power(free, coefficient)
        if free.complaint or (demanded <= self._total and not self._exceeding(free, coefficient)):
            answer, stage = free, PowerStage.WITHIN
        else:
            found = limit_total_power(allocate, tau, self._total, yaw_priority=self._yaw_priority)
            answer, stage = found.commands, found.stage
            if stage is PowerStage.PHASE_BACK:
                self._scale(answer, coefficient, self._all, self._total)
        # Slack counts from the demand, whatever was allocated of it in the end.
        if answer.tau is not tau:
            answer.tau = tau
            self._engine.add_up(answer)
        self._commanded = float(answer.totals[Total.POWER])
        powers = self._bus_power(answer, coefficient)
        commanded = correction * self._commanded
        return answer, PowerReport(demanded, commanded, correction, stage, powers, tuple(limited))

    def _power(self, answer: Answer, coefficient: FloatArray) -> float:
        return float(total_power(coefficient, self._used(answer)))

    def _used(self, answer: Answer) -> FloatArray:
        """Return the thrusts that count, shape (n,): those that are not lost."""
        commands = answer.commands
        return np.where(commands[:, Command.PHASE] == LOST, 0.0, commands[:, Command.THRUST])

    def _bus_power(self, answer: Answer, coefficient: FloatArray) -> FloatArray:
        powers: FloatArray = self._members @ (coefficient * np.abs(self._used(answer)) ** 1.5)
        return powers

    def _exceeding(self, answer: Answer, coefficient: FloatArray) -> list[int]:
        powers = self._bus_power(answer, coefficient)
        return np.flatnonzero(powers > self._limits * (1.0 + _ROUNDING)).tolist()

    def _within_buses(
        self,
        run: Run,
        answer: Answer,
        before: FloatArray,
        coefficient: FloatArray,
        yaw_factor: float,
        limited: list[bool],
    ) -> Answer:
        """Return an answer within the bus limits: their rows first, and what these leave open by phase-back."""
        if not self._exceeding(answer, coefficient):
            return answer
        rows = np.flatnonzero(np.isfinite(self._limits)).tolist()
        n = len(self._all)
        plans = answer.plans
        rotating = (plans[:, Plan.PHASE] == ROTATING).astype(np.float64)
        lower, upper, low, high = (
            np.ascontiguousarray(plans[:, i]) for i in (Plan.LOWER, Plan.UPPER, Plan.TURN_LOW, Plan.TURN_HIGH)
        )
        thrust, azimuth = (np.ascontiguousarray(before[:, i]) for i in (Command.THRUST, Command.AZIMUTH))
        along = plans[:, Plan.AZIMUTH]
        a, b = np.zeros((len(rows), n, 2)), np.zeros(len(rows))
        for k, bus in enumerate(rows):
            row_x, row_y = np.zeros(n), np.zeros(n)
            member = self._members[bus] * (plans[:, Plan.PHASE] != LOST)
            b[k], kind = bus_row(
                coefficient,
                member,
                rotating,
                thrust,
                azimuth,
                lower,
                upper,
                low,
                high,
                self._engine.weights.zero_region,
                float(self._limits[bus]),
                self._approach,
                True,
                row_x,
                row_y,
            )
            if kind != BusRowKind.SAFE and not row_x.any() and not row_y.any():
                b[k] = np.inf
                continue
            # A fixed thruster's row is over its thrust; over components it acts along its direction.
            fixed = rotating == 0.0
            a[k, :, 0] = np.where(fixed, row_x * np.cos(along), row_x)
            a[k, :, 1] = np.where(fixed, row_x * np.sin(along), row_y)
        use = np.isfinite(b)
        constrained = run(answer.tau, Coupling(a[use], b[use]), yaw_factor) if use.any() else answer
        if not constrained.complaint:
            answer = constrained
        for bus in rows:
            limited[bus] = True
        for bus in self._exceeding(answer, coefficient):
            self._scale(answer, coefficient, self._members[bus], float(self._limits[bus]))
        return answer

    def _scale(self, answer: Answer, coefficient: FloatArray, member: FloatArray, available: float) -> None:
        """Scale thrusts back by one factor, within their windows, and sum up anew."""
        commands, plans = answer.commands, answer.plans
        counted = member * (commands[:, Command.PHASE] != LOST)
        thrust = np.ascontiguousarray(commands[:, Command.THRUST])
        lower, upper = np.ascontiguousarray(plans[:, Plan.LOWER]), np.ascontiguousarray(plans[:, Plan.UPPER])
        # A rotating thruster may be within its polygon at no thrust, and gives none astern.
        lower = np.where(plans[:, Plan.PHASE] == ROTATING, np.maximum(lower, 0.0), lower)
        phase_back(coefficient, counted, thrust, lower, upper, available, thrust)
        commands[:, Command.THRUST] = thrust
        self._engine.add_up(answer)
