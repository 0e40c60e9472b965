"""Divides a demanded generalized force among the thrusters, [Ruth] 4.4 and 6.3."""

from __future__ import annotations

import math
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray, finite_vector, positive_number
from thrust_allocator.phase import IDLE_SHARE, Phase, Plan, ThrusterLimits, plan_thruster
from thrust_allocator.polar import held_command, rotating_command
from thrust_allocator.problem import AllocationProblem, Weights
from thrust_allocator.result import AllocationResult, Status
from thrust_allocator.settings import AllocatorSettings, check_settings
from thrust_allocator.solution import Solution
from thrust_allocator.solver import Solver
from thrust_allocator.solvers import make_solver

# An answer is used when its residuals are below these shares: of the vessel's thrust for distances, of the gradient
# for stationarity. Commands are brought into their windows afterwards in any case, so that this only guards against
# answers that are wrong; first-order solvers are content with about 1e-7.
_ACCEPTED_FORCE = 1e-6
_ACCEPTED_STATIONARITY = 1e-5
# Share of a thruster's span, and angle in rad, within which a command counts as being on its limit.
_AT_LIMIT = 1e-7
# Demands beyond this multiple of all thrust and moment there is go to the solver along their direction at this size:
# everything is saturated either way, and the arithmetic keeps its precision.
_LARGEST_DEMAND = 10.0


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
        self._weights = Weights.of(vessel)
        self._approach = vessel.allocator.approach_fraction
        self._lever_x: list[float] = vessel.lever_x.tolist()
        self._lever_y: list[float] = vessel.lever_y.tolist()
        self._slack_weight: list[float] = self._weights.slack.tolist()
        self._thrust_weight: list[float] = self._weights.thrust.tolist()
        self._power_factor: list[float] = vessel.propellers.power_per_thrust_3_2.tolist()
        self._spans: list[float] = (vessel.thrust_max - vessel.thrust_min).tolist()
        strength = sum(self._spans)
        arm = max(np.abs(vessel.lever_x).max(), np.abs(vessel.lever_y).max())
        self._largest_force = _LARGEST_DEMAND * strength
        self._largest_moment = _LARGEST_DEMAND * strength * float(arm)
        self._accepted_force = _ACCEPTED_FORCE * strength
        self._problem: AllocationProblem | None = None
        self._layout: tuple[bool | None, ...] = ()
        self._pointed: list[float] = []
        self._limits: tuple[ThrusterLimits, ...] = ()
        self._solver: Solver = make_solver("daqp")
        self.apply(settings if settings is not None else AllocatorSettings())
        self.reset(thrust, azimuth)

    @property
    def settings(self) -> AllocatorSettings:
        """The settings in force."""
        return self._settings

    @property
    def problem(self) -> AllocationProblem | None:
        """Problem of the last step, overwritten by the next; None before the first or with all thrusters lost."""
        return self._problem

    @property
    def solution(self) -> Solution | None:
        """What the solver made of :attr:`problem`."""
        return self._solution

    def apply(self, settings: AllocatorSettings) -> None:
        """Swap the settings whole; they hold from the next step on.

        Raises
        ------
        InputError
            If they do not fit the vessel, or the solver is not there; the old ones stay in force.
        """
        check_settings(settings, self._vessel)
        if settings.solver != self._solver.name:
            self._solver = make_solver(settings.solver)
        self._settings = settings
        self._longest_step = settings.longest_step * self._vessel.measurement.sample_time
        n = self._n
        enabled = settings.thruster_enabled or (True,) * n
        turning = settings.azimuth_enabled or (True,) * n
        scale = settings.thrust_limit_scale or (1.0,) * n
        zero_region = self._vessel.allocator.zero_region
        vessel = self._vessel
        self._limits = tuple(
            ThrusterLimits(
                enabled=enabled[j],
                may_rotate=vessel.can_rotate[j] and turning[j],
                rotating=settings.azimuth_mode == "rotating",
                thrust_min=scale[j] * float(vessel.thrust_min[j]),
                thrust_max=scale[j] * float(vessel.thrust_max[j]),
                thrust_rate=float(vessel.thrust_rate[j]),
                azimuth_rate=float(vessel.azimuth_rate[j]),
                fixed_direction=wrap_angle(float(vessel.fixed_direction[j])),
                zero_thrust=zero_region * self._spans[j],
                span=self._spans[j],
            )
            for j in range(n)
        )

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
        thrusts = [0.0] * n if thrust is None else finite_vector("thrust", thrust, n).tolist()
        angles: list[float] = (
            self._vessel.fixed_direction if azimuth is None else finite_vector("azimuth", azimuth, n)
        ).tolist()
        can_rotate = self._vessel.can_rotate
        self._thrust: list[float] = thrusts
        self._azimuth: list[float] = [
            wrap_angle(angles[j] if can_rotate[j] else float(self._vessel.fixed_direction[j])) for j in range(n)
        ]
        self._demand = np.zeros(3)
        self._solution: Solution | None = None

    def step(self, tau_desired: ArrayLike, dt: float) -> AllocationResult:
        """Return thrusts and directions for a demand; always within the limits.

        Parameters
        ----------
        tau_desired
            Demanded generalized force, shape (3,), N, N, N m in the body frame.
        dt
            Time since the last step, s. What a step may change is limited to ``settings.longest_step``: the commands
            of the last step have been standing since, and what was not asked for then has not been begun.

        Raises
        ------
        InputError
            If the demand has the wrong shape or ``dt`` is not a number above 0; nothing is changed.
        """
        started = perf_counter()
        tau, status, message = self._accept(tau_desired)
        dt = min(positive_number("dt", dt), self._longest_step)
        approach = self._approach
        plans = [
            plan_thruster(limits, thrust, azimuth, dt, approach)
            for limits, thrust, azimuth in zip(self._limits, self._thrust, self._azimuth, strict=True)
        ]
        problem = self._pose(plans, tau)
        solution = None
        failed = False
        if problem is None:
            if status is Status.OPTIMAL:
                status, message = Status.NO_THRUSTER, "every thruster is lost"
        else:
            solution = self._solver.solve(problem)
            complaint = self._complaint(solution)
            if complaint:
                failed = True
                status, message = Status.HOLD, f"{message}; {complaint}" if message else complaint
        self._demand = tau
        self._solution = solution
        commands = self._commands(plans, None if failed else solution)
        return self._answer(started, tau, status, message, plans, commands, failed)

    def _accept(self, tau_desired: ArrayLike) -> tuple[FloatArray, Status, str]:
        """Return the demand to allocate, a copy."""
        try:
            tau = np.array(tau_desired, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"tau_desired: expected 3 numbers, found {tau_desired!r}") from error
        if tau.shape != (3,):
            raise InputError(f"tau_desired: expected shape (3,), found {tau.shape}")
        x, y, n = tau.tolist()
        if math.isfinite(x) and math.isfinite(y) and math.isfinite(n):
            return tau, Status.OPTIMAL, ""
        return (
            self._demand,
            Status.DEMAND_NOT_FINITE,
            f"tau_desired: expected finite numbers, found {[x, y, n]}; the last good demand stands",
        )

    def _pose(self, plans: list[Plan], tau: FloatArray) -> AllocationProblem | None:
        """Return the problem of this step; None when there is no thruster to allocate."""
        layout = tuple([None if plan.phase is Phase.LOST else plan.phase is Phase.ROTATING for plan in plans])
        problem = self._problem
        if layout != self._layout:
            fixed = [j for j, rotates in enumerate(layout) if rotates is False]
            rotating = [j for j, rotates in enumerate(layout) if rotates]
            problem = AllocationProblem(self._weights, fixed, rotating) if fixed or rotating else None
            self._layout = layout
            self._problem = problem
            self._pointed = [math.nan]
        if problem is None:
            return None
        directions = []
        for i, j in enumerate(problem.fixed):
            plan = plans[j]
            directions.append(plan.azimuth)
            problem.limit_fixed(i, plan.thrust_lower, plan.thrust_upper)
        for i, j in enumerate(problem.rotating):
            _, lower, upper, azimuth, low, high = plans[j]
            problem.limit_rotating(i, azimuth, low, high, lower, upper)
        if directions != self._pointed:
            problem.point(directions)
            self._pointed = directions
        x, y, n = tau.tolist()
        excess = max(abs(x) / self._largest_force, abs(y) / self._largest_force, abs(n) / self._largest_moment)
        problem.demand(tau if excess <= 1.0 else tau / excess)
        return problem

    def _complaint(self, solution: Solution | None) -> str:
        """Return what is wrong with a solution; empty when it can be used."""
        if solution is None:
            return f"{self._solver.name} gave no answer"
        residuals = solution.residuals
        if residuals.within(self._accepted_force, _ACCEPTED_STATIONARITY):
            return ""
        said = f" ({solution.message})" if solution.message else ""
        return (
            f"{self._solver.name} failed{said}: violation {residuals.violation:.3g} N, "
            f"stationarity {residuals.stationarity:.3g}, dual violation {residuals.dual_violation:.3g}, "
            f"complementarity {residuals.complementarity:.3g}"
        )

    def _commands(self, plans: list[Plan], solution: Solution | None) -> list[tuple[float, float]]:
        """Return thrust and direction of every thruster, within the plans."""
        problem = self._problem
        if solution is None or problem is None:
            return [held_command(plan, thrust) for plan, thrust in zip(plans, self._thrust, strict=True)]
        # Lost thrusters have no variable; their plan leaves no choice.
        commands = [(plan.thrust_lower, plan.azimuth) for plan in plans]
        z = solution.z.tolist()
        for i, j in enumerate(problem.fixed):
            plan = plans[j]
            commands[j] = min(max(z[i], plan.thrust_lower), plan.thrust_upper), plan.azimuth
        at = len(problem.fixed)
        for j in problem.rotating:
            commands[j] = rotating_command(plans[j], z[at], z[at + 1], IDLE_SHARE * self._spans[j])
            at += 2
        return commands

    def _answer(
        self,
        started: float,
        tau: FloatArray,
        status: Status,
        message: str,
        plans: list[Plan],
        commands: list[tuple[float, float]],
        failed: bool,
    ) -> AllocationResult:
        surge = sway = yaw = cost = power = 0.0
        thrust_saturated, azimuth_saturated = [], []
        for j, (thrust, azimuth) in enumerate(commands):
            plan = plans[j]
            phase, lower, upper, before, low, high = plan
            at_thrust = at_azimuth = False
            if phase is not Phase.LOST:
                force_x, force_y = thrust * math.cos(azimuth), thrust * math.sin(azimuth)
                surge += force_x
                sway += force_y
                yaw += self._lever_x[j] * force_y - self._lever_y[j] * force_x
                cost += self._thrust_weight[j] * thrust * thrust
                power += self._power_factor[j] * abs(thrust) ** 1.5
                near = _AT_LIMIT * self._spans[j]
                if phase is Phase.ROTATING:
                    turn = wrap_angle(azimuth - before)
                    at_azimuth = turn <= low + _AT_LIMIT or turn >= high - _AT_LIMIT
                    # The lines (4.41)-(4.42) lie below the arc except at the present direction.
                    ends = min(
                        upper * math.cos(low) / math.cos(turn - low),
                        upper * math.cos(high) / math.cos(turn - high),
                    )
                    at_thrust = thrust >= ends - near or (lower > 0.0 and thrust <= lower / math.cos(turn) + near)
                else:
                    at_thrust = thrust >= upper - near or thrust <= lower + near
                    at_azimuth = phase is Phase.TURNING
            thrust_saturated.append(at_thrust)
            azimuth_saturated.append(at_azimuth)
        self._thrust = [thrust for thrust, _ in commands]
        self._azimuth = [azimuth for _, azimuth in commands]
        achieved = np.array((surge, sway, yaw))
        slack = tau - achieved
        for weight, value in zip(self._slack_weight, slack.tolist(), strict=True):
            cost += weight * value * value
        phases = tuple([plan.phase for plan in plans])
        problem = self._problem
        return AllocationResult(
            thrust=np.array(self._thrust),
            azimuth=np.array(self._azimuth),
            tau_desired=tau.copy(),
            tau_achieved=achieved,
            slack=slack,
            cost=cost,
            solve_time=perf_counter() - started,
            status=status,
            message=message,
            azimuth_mode=self._settings.azimuth_mode,
            solver=self._solver.name,
            demanded_power=power,
            phase=phases,
            rotating=tuple([phase is Phase.ROTATING for phase in phases]),
            thrust_saturated=tuple(thrust_saturated),
            azimuth_saturated=tuple(azimuth_saturated),
            problem=problem.copy() if failed and problem is not None else None,
            solution=self._solution if failed else None,
        )
