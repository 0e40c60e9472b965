"""Divides a demanded generalized force among the thrusters, [Ruth] chapters 4 to 7."""

from __future__ import annotations

import math
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from marine_model import Vessel
from marine_model.axes import HORIZONTAL, axis_indices
from marine_model.errors import InputError
from marine_model.frames import wrap_angle
from marine_model.gains import FixedRotatingGains, SectorGains
from marine_model.guards import FloatArray, finite_number, finite_vector, positive_number
from thrust_allocator.antispin import POWER_TRUE, QUADRATIC, AntiSpin
from thrust_allocator.cost import propeller_weights, reweight, thrust_floor
from thrust_allocator.engine import Answer, Engine
from thrust_allocator.methods import Method, MethodReport, Wanted, make_method
from thrust_allocator.mode_supervisor import AzimuthMode, ModeState, next_mode
from thrust_allocator.monitoring import Monitoring
from thrust_allocator.plan.limits import Feathering, limit_table
from thrust_allocator.plan.phase import LOST, Limit
from thrust_allocator.plan.polar import Command
from thrust_allocator.power import PowerLimiter, PowerReport
from thrust_allocator.program.problem import AllocationProblem, Coupling
from thrust_allocator.program.solution import Solution
from thrust_allocator.proportional import attainable_share
from thrust_allocator.result import AllocationResult, Status
from thrust_allocator.sectors import SectorControl, SectorReport, switching_rule
from thrust_allocator.settings import AllocatorSettings, check_settings
from thrust_allocator.singularity.avoidance import Avoidance, AvoidanceReport

# Demands beyond this multiple of all thrust and moment there is go to the solver along their direction at this size:
# everything is saturated either way, and the arithmetic keeps its precision.
_LARGEST_DEMAND = 10.0
# Of the six degrees of freedom the first that is a rotation.
_FIRST_MOMENT = 3
# Slack, as a share of the demand in the norm of its weights, from which a demand counts as out of reach.
_OUT_OF_REACH = 1e-3


class Allocator:
    """Allocates one demand after another.

    Parameters
    ----------
    vessel
        Geometry, limits and weights.
    settings
        Operator-facing options; defaults when None.
    thrust, azimuth
        Operating point to start from, as in :meth:`reset`.

    Raises
    ------
    InputError
        If settings do not fit the vessel or the operating point has the wrong shape or is not finite.
    """

    def __init__(
        self,
        vessel: Vessel,
        settings: AllocatorSettings | None = None,
        thrust: ArrayLike | None = None,
        azimuth: ArrayLike | None = None,
    ) -> None:
        self._vessel = vessel
        self._n = len(vessel.thrusters)
        self._engine = Engine(vessel)
        self._span: FloatArray = vessel.thrust_max - vessel.thrust_min
        strength = float(self._span.sum())
        axes = vessel.degrees_of_freedom
        turns = axis_indices(axes) >= _FIRST_MOMENT
        arm = float(np.abs(vessel.columns[:, turns]).max(initial=0.0))
        self._m = len(axes)
        # Of every degree of freedom.
        self._largest: list[float] = [
            _LARGEST_DEMAND * strength * (arm if is_moment else 1.0) for is_moment in turns.tolist()
        ]
        # Where surge and sway stand, for who asks for their size.
        self._level = [axes.index(axis) if axis in axes else None for axis in ("surge", "sway")]
        self._floor = thrust_floor(vessel.thrust_min, vessel.thrust_max)
        self._no_factor = np.ones(self._n)
        self._antispin = AntiSpin(self._n)
        self._sectors = SectorControl(vessel, self._engine.columns, self._engine.compliance)
        self._power = PowerLimiter(vessel, self._engine)
        self._feathering = Feathering(self._n)
        self._avoidance: Avoidance | None = None
        self._speed = 0.0
        self.apply(settings if settings is not None else AllocatorSettings.for_vessel(vessel))
        self.reset(thrust, azimuth)

    @property
    def settings(self) -> AllocatorSettings:
        """The settings in force."""
        return self._settings

    @property
    def problem(self) -> AllocationProblem | None:
        """Problem of the last step, as an object; None before the first, with all thrusters lost or another method."""
        if self._answer is None or not self._answer.solved:
            return None
        problem = self._answer.problem or self._engine.problem(self._answer)
        return problem if problem.variables else None

    @property
    def solution(self) -> Solution | None:
        """What the solver made of :attr:`problem`."""
        if self._answer is None or not self._answer.solved:
            return None
        return self._engine.solution(self._answer)

    @property
    def answer(self) -> Answer | None:
        """Tables of the last step, before anything is made of them; None before the first."""
        return self._answer

    def sub_problems(self) -> list[AllocationProblem]:
        """Return the sub-problems of all combinations of windows for the last demand; none before the first step.

        See :mod:`sectors.pieces`; the supervisor has chosen the one of ``result.sectors.sub_problem``.
        """
        if self._answer is None:
            return []
        weights = replace(self._engine.weights, thrust=self._sector_weight())
        return self._sectors.problems(weights, self._answer.tau)

    def cheapest_windows(self, tau_desired: ArrayLike) -> tuple[float, tuple[int, ...]]:
        """Return the least cost of all sub-problems for a demand, and the window of every thruster there.

        For thrusters as they rotate or not since the last step with sectors. The supervisor may well stay elsewhere.

        Raises
        ------
        InputError
            If the demand has the wrong shape or is not finite, or the vessel controls other axes than surge, sway, yaw.
        """
        axes = self._vessel.degrees_of_freedom
        if axes != HORIZONTAL:
            raise InputError(f"sectors: expected a vessel that controls surge, sway, yaw, found {', '.join(axes)}")
        return self._sectors.optimum(self._sector_weight(), finite_vector("tau_desired", tau_desired, 3))

    def apply(self, settings: AllocatorSettings) -> None:
        """Swap the settings whole; they hold from the next step on.

        Raises
        ------
        InputError
            If they do not fit the vessel, or the solver is not there; the old ones stay in force.
        """
        check_settings(settings, self._vessel)
        if settings.singularity.method == "none":
            self._avoidance = None
        elif self._avoidance is None:
            self._avoidance = Avoidance(self._vessel, self._engine, settings.singularity)
        else:
            self._avoidance.apply(settings.singularity)
        self._engine.use(settings.solver)
        self._settings = settings
        self._longest_step = settings.longest_step * self._vessel.measurement.sample_time
        self._mode = AzimuthMode.parse(settings.azimuth_mode)
        self._auto = FixedRotatingGains(**settings.auto.model_dump())
        self._limits = limit_table(self._vessel, settings)
        self._feathering.apply(self._limits, settings.feather_time)
        rule = switching_rule(SectorGains(**settings.sectors.model_dump(exclude={"enabled"})))
        self._sectors.apply(rule)
        self._power.apply(settings.power)
        self._antispin.apply(settings.antispin)
        self._stuck = np.flatnonzero(np.array(self._vessel.can_rotate) & (self._limits[:, Limit.MAY_ROTATE] == 0.0))
        if not len(self._stuck):
            self._direction: FloatArray | None = None
        weight = self._engine.weights.thrust
        if settings.thrust_weight == "propeller":
            weight = propeller_weights(self._engine.power_factor)
        self._weight = weight
        self._method = make_method(self._vessel, settings)
        if self._method is not None:
            self._method.measure_speed(self._speed)
        self._monitoring = Monitoring(self._vessel, settings, self._limits)
        self._changing = settings.sectors.enabled or self._mode is AzimuthMode.AUTO
        self._rehearse()

    def reset(self, thrust: ArrayLike | None = None, azimuth: ArrayLike | None = None) -> None:
        """Start from the given operating point, as if it had been commanded; a new allocator does the same.

        Parameters
        ----------
        thrust
            Shape (n,), N; zero when None. May lie outside the limits: it is led back at the rates allowed.
        azimuth
            Shape (n,), rad; the fixed directions when None. A tunnel thruster keeps its own.

        Raises
        ------
        InputError
            If a shape is wrong or an element is not finite; nothing is changed.
        """
        n = self._n
        thrusts = np.zeros(n) if thrust is None else finite_vector("thrust", thrust, n)
        angles = self._vessel.fixed_direction if azimuth is None else finite_vector("azimuth", azimuth, n)
        angles = np.where(self._vessel.can_rotate, angles, self._vessel.fixed_direction)
        before = np.zeros((n, Command.COLUMNS))
        before[:, Command.THRUST] = thrusts
        before[:, Command.AZIMUTH] = [wrap_angle(angle) for angle in angles.tolist()]
        self._before = before
        self._multiplier = np.zeros(self._m)
        self._demand = np.zeros(self._m)
        self._answer: Answer | None = None
        self._direction = None
        self._mode_state = ModeState()
        self._sectors.reset()
        self._power.reset()
        self._antispin.reset()
        self._feathering.reset()
        if self._avoidance is not None:
            self._avoidance.reset()

    def measure_speed(self, speed: float) -> None:
        """Take the speed ahead through the water (m/s), for methods whose limits go with it.

        It holds until the next; before the first it is 0.

        Raises
        ------
        InputError
            If it is not a finite number; nothing is changed.
        """
        self._speed = finite_number("speed", speed)
        if self._method is not None:
            self._method.measure_speed(self._speed)

    def measure_power(self, power: float) -> None:
        """Take the measured power of all thrusters together (W): it corrects the prediction, [Ruth] (4.44)."""
        self._power.measure(power)

    def measure_azimuth(self, azimuth: ArrayLike) -> None:
        """Take where the thrusters point: one whose azimuth drive is lost is allocated there, [Ruth] 6.3.

        While its failure was not known it has been commanded elsewhere. Without a measurement it counts as pointing
        where it was last commanded to.

        Parameters
        ----------
        azimuth
            Measured, shape (n,), rad; those of thrusters that turn have no say.

        Raises
        ------
        InputError
            If the shape is wrong or an element is not finite; nothing is changed.
        """
        self._direction = finite_vector("azimuth", azimuth, self._n)

    def measure_ventilation(self, torque_loss: ArrayLike, age: float = 0.0) -> None:
        """Take what air has left of the propellers' torque: it raises their cost, [Ruth] (5.18), if ``antispin`` is on.

        Parameters
        ----------
        torque_loss
            beta_Q2 of (5.17) for every thruster, shape (n,), from 0 to 1, which is without loss. The least since the
            step before will do for whoever has no memory of losses.
        age
            How old that is at the next step, s. It holds until it is older than ``antispin.timeout``.

        Raises
        ------
        InputError
            If the shape is wrong, a number is not within 0 and 1, or ``age`` is not 0 or more; nothing is changed.
        """
        self._antispin.measure(torque_loss, age)

    def step(self, tau_desired: ArrayLike, dt: float) -> AllocationResult:
        """Return thrusts and directions for a demand; always within the limits.

        Parameters
        ----------
        tau_desired
            Demanded generalized force over the degrees of freedom, shape (m,), N or N m in the body frame: N, N, N m
            in surge, sway, yaw on the surface.
        dt
            Time since the last step, s. What a step may change is limited to ``settings.longest_step``: the commands
            of the last step have been standing since, and what was not asked for then has not been begun.
            See :meth:`fade` for drivers that have ramped them to zero meanwhile.

        Raises
        ------
        InputError
            If the demand has the wrong shape or ``dt`` is not a number above 0; nothing is changed.
        """
        started = perf_counter()
        tau, status, message = self._accept(tau_desired)
        elapsed = positive_number("dt", dt)
        dt = min(elapsed, self._longest_step)
        if self._changing or self._feathering.active:
            # The results of steps before keep theirs.
            self._limits = self._limits.copy()
        settings, limits, before = self._settings, self._limits, self._where_they_point(dt)
        if self._feathering.active:
            self._feathering.step(limits, dt)
        tamed = self._tamed(tau)
        rotating = self._choose_mode(tamed, elapsed)
        self._antispin.step(elapsed)
        weight = self._weight_now()
        sectors: SectorReport | None = None
        if settings.sectors.enabled:
            sectors = self._sectors.step(limits, before, self._sector_weight(), tamed, elapsed)
        power: PowerReport | None = None
        avoidance: AvoidanceReport | None = None

        def run(table: FloatArray, last: FloatArray, multiplier: FloatArray, demand: FloatArray) -> Answer:
            nonlocal power
            if settings.power.limit == "none":
                return self._run(table, last, multiplier, weight, demand, dt)
            found, power = self._power.step(
                lambda tau, coupling, yaw: self._run(table, last, multiplier, weight, tau, dt, coupling, yaw),
                last,
                demand,
                dt,
            )
            return found

        report: MethodReport | None = None
        if self._method is not None:
            answer, report = self._by_method(self._method, limits, before, weight, tamed, dt)
            rotating = False
        elif self._avoidance is None:
            answer = run(limits, before, self._multiplier, tamed)
        elif not rotating:
            self._avoidance.reset()
            answer = run(limits, before, self._multiplier, tamed)
        else:
            answer, avoidance = self._avoidance.step(run, limits, before, tamed, dt)
        if answer.complaint:
            status = Status.HOLD
            message = f"{message}; {answer.complaint}" if message else answer.complaint
        elif status is Status.OPTIMAL and not (answer.plans[:, 0] != LOST).any():
            status, message = Status.NO_THRUSTER, "every thruster is lost"
        self._demand = tau
        self._answer = answer
        self._before = answer.commands
        if answer.solved:
            self._multiplier = answer.multiplier
        failed = bool(answer.complaint)
        return AllocationResult(
            commands=answer.commands,
            totals=answer.totals,
            tau_desired=tau,
            solve_time=perf_counter() - started,
            status=status,
            message=message,
            azimuth_mode="rotating" if rotating else "fixed",
            mean_force=self._mode_state.mean_force if self._mode is AzimuthMode.AUTO else math.nan,
            solver=self._engine.solver_of(answer),
            sectors=sectors,
            power=power,
            avoidance=avoidance,
            antispin=self._antispin.on,
            ventilation_known=self._antispin.known,
            torque_loss=self._antispin.torque_loss,
            limits=limits,
            monitoring=self._monitoring,
            problem=answer.problem if failed else None,
            solution=answer.solution if failed else None,
            method=settings.method,
            method_report=report,
        )

    def fade(self, time: float) -> None:
        """Let thrusts go towards zero at their rates for ``time`` (s), as drivers do that get no commands.

        Raises
        ------
        InputError
            If ``time`` is not a number above 0.
        """
        time = positive_number("time", time)
        self._before = self._before.copy()
        thrust = self._before[:, Command.THRUST]
        self._before[:, Command.THRUST] = np.sign(thrust) * np.maximum(
            np.abs(thrust) - self._vessel.thrust_rate * time, 0.0
        )

    def _rehearse(self) -> None:
        """Go through a step of a twin, so that no step of this one waits for machine code to be loaded or compiled."""
        tau = self._vessel.thrust_max.sum() * np.ones(self._m)
        _Twin(self._vessel, self._settings).step(tau, self._longest_step)

    def _by_method(
        self, method: Method, limits: FloatArray, before: FloatArray, weight: FloatArray, tau: FloatArray, dt: float
    ) -> tuple[Answer, MethodReport]:
        """Allocate without a program, and solve it beside: both start from the same commands, in the same windows."""
        achieved = np.full(self._m, np.nan)
        if self._settings.compare_qp:
            program = self._run(limits, before, self._multiplier, weight, tau, dt)
            self._multiplier = program.multiplier
            if not program.complaint:
                achieved = program.totals[: self._m].copy()
        table = limits.copy()
        table[:, Limit.ROTATING] = 0.0
        method.aim(table, before[:, Command.AZIMUTH], tau)
        wanted: list[Wanted] = []

        def want(plans: FloatArray) -> FloatArray:
            wanted.append(method.want(plans, table, tau))
            return wanted[0].thrust

        answer = self._engine.impose(table, before, weight, tau, dt, want)
        found = wanted[0]
        return answer, MethodReport(found.tau_feasible, found.load, found.detail, achieved)

    def _where_they_point(self, dt: float) -> FloatArray:
        """Return the commands of the step before, with lost azimuth drives where they were measured.

        The command goes there no faster than the drive could turn, so that it keeps to the limits of every command.
        Within the threshold of (B.38), below which a drive may be off or its sensor noisy, it stays: a sound drive
        that is held would follow the noise else.
        """
        if self._direction is None or not len(self._stuck):
            return self._before
        before = self._before.copy()
        for j in self._stuck.tolist():
            reach = float(self._vessel.azimuth_rate[j]) * dt
            commanded = float(before[j, Command.AZIMUTH])
            rest = wrap_angle(float(self._direction[j]) - commanded)
            if abs(rest) <= self._vessel.drivers.azimuth.threshold:
                continue
            before[j, Command.AZIMUTH] = wrap_angle(commanded + min(max(rest, -reach), reach))
        return before

    def _choose_mode(self, tau: FloatArray, elapsed: float) -> bool:
        """Return whether azimuth thrusters rotate in this step, and write it into the limits.

        The filter of the demand goes on in every mode, so that auto begins from what the demand has been.
        """
        surge, sway = (0.0 if i is None else float(tau[i]) for i in self._level)
        state = next_mode(self._mode_state, self._mode, self._auto, surge, sway, elapsed)
        self._mode_state = state
        if self._mode is AzimuthMode.AUTO:
            self._limits[:, Limit.ROTATING] = state.rotating
        return state.rotating

    def _weight_now(self) -> FloatArray:
        """Return the diagonal of W_u^2 for this step, shape (n,)."""
        antispin = self._antispin
        if self._settings.cost == "quadratic":
            return self._weight * antispin.factor(QUADRATIC) if antispin.acts else self._weight
        weight = np.empty(self._n)
        thrust = np.ascontiguousarray(self._before[:, Command.THRUST])
        factor = antispin.factor(POWER_TRUE) if antispin.acts else self._no_factor
        reweight(self._weight, factor, thrust, self._floor, weight)
        return weight

    def _sector_weight(self) -> FloatArray:
        """Return the diagonal of W_u^2 by which windows are compared, shape (n,): of the quadratic cost in any case.

        A window that is reached in some seconds is no matter of the present thrusts.
        """
        return self._weight * self._antispin.factor(QUADRATIC) if self._antispin.acts else self._weight

    def _run(
        self,
        limits: FloatArray,
        before: FloatArray,
        multiplier: FloatArray,
        weight: FloatArray,
        tau: FloatArray,
        dt: float,
        coupling: Coupling | None = None,
        yaw_factor: float = 1.0,
    ) -> Answer:
        """Allocate without power limits; what is out of reach is given up as the settings say."""
        answer = self._engine.run(limits, before, multiplier, weight, tau, dt, coupling, yaw_factor)
        if self._settings.over_demand == "slack" or answer.complaint:
            return answer
        scale = 1.0 / np.sqrt(answer.compliance)
        missed, size = (
            float(np.linalg.norm(scale * (tau - answer.totals[: self._m]))),
            float(np.linalg.norm(scale * tau)),
        )
        if missed <= _OUT_OF_REACH * size:
            return answer
        share = attainable_share(self._engine, answer, self._span)
        reduced = self._engine.run(limits, before, answer.multiplier, weight, share * tau, dt, coupling, yaw_factor)
        if reduced.complaint:
            return answer
        reduced.tau = tau
        self._engine.add_up(reduced)
        return reduced

    def _accept(self, tau_desired: ArrayLike) -> tuple[FloatArray, Status, str]:
        """Return the demand to allocate, a copy."""
        try:
            tau = np.array(tau_desired, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"tau_desired: expected {self._m} numbers, found {tau_desired!r}") from error
        if tau.shape != (self._m,):
            raise InputError(f"tau_desired: expected shape ({self._m},), found {tau.shape}")
        numbers = tau.tolist()
        if all(map(math.isfinite, numbers)):
            return tau, Status.OPTIMAL, ""
        return (
            self._demand,
            Status.DEMAND_NOT_FINITE,
            f"tau_desired: expected finite numbers, found {numbers}; the last good demand stands",
        )

    def _tamed(self, tau: FloatArray) -> FloatArray:
        """Return the demand, brought down along its direction where it is far beyond the vessel."""
        excess = max([abs(part) / largest for part, largest in zip(tau.tolist(), self._largest, strict=True)])
        return tau if excess <= 1.0 else tau / excess


class _Twin(Allocator):
    """An allocator that is stepped once and thrown away."""

    def _rehearse(self) -> None:
        """Have none of its own."""
