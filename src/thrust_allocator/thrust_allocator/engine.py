"""Runs one step on a table of limits: the compiled step, and other solvers where they are asked for or needed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.plan.phase import Limit, Plan, plan_thrusters
from thrust_allocator.plan.polar import Command, commands
from thrust_allocator.plan.polygon import CORNERS
from thrust_allocator.program.active_set_solver import NAME, solution_of
from thrust_allocator.program.daqp_solver import DaqpSolver
from thrust_allocator.program.problem import AllocationProblem, Coupling, Weights
from thrust_allocator.program.solution import Solution
from thrust_allocator.program.solver import Solver
from thrust_allocator.program.solvers import make_solver
from thrust_allocator.step import Total, add_up, allocate

# An answer is used when its residuals are below these shares: of the vessel's thrust for distances, of the gradient
# for stationarity. Commands are brought into their windows afterwards in any case, so that this only guards against
# answers that are wrong; first-order solvers are content with about 1e-7.
_ACCEPTED_FORCE = 1e-6
_ACCEPTED_STATIONARITY = 1e-5
# The method of this package is held to more; beyond this daqp is asked.
_ACCURATE = 1e-9


@dataclass(slots=True)
class Answer:
    """What came out of one run.

    Attributes
    ----------
    tau
        Demand that was allocated, over the degrees of freedom, shape (m,).
    plans
        Table of plans, shape (n, 6).
    commands
        Table of commands, shape (n, 5), see :class:`polar.Command`.
    totals
        Sums, shape (m + 4,), see :class:`step.Total`; tau_achieved first.
    multiplier
        lambda, shape (m,): where a run on a problem like it starts.
    force
        Cartesian thrusts that the solver answered, shape (n, 2), N.
    weight
        Diagonal of W_u^2 that was used, shape (n,).
    compliance
        Diagonal of Q^-1 that was used, shape (m,).
    steps
        As the solver counts them.
    complaint
        What was wrong with every solver's answer; empty when one was used. Otherwise the commands hold still.
    solved
        Whether there was a problem to solve: not with thrusts that were imposed.
    problem, solution
        Where another solver than that of this package was asked: its problem, and what it made of it.
    """

    tau: FloatArray
    plans: FloatArray
    commands: FloatArray
    totals: FloatArray
    multiplier: FloatArray
    force: FloatArray
    weight: FloatArray
    compliance: FloatArray
    steps: int
    complaint: str = ""
    solved: bool = True
    problem: AllocationProblem | None = None
    solution: Solution | None = None


class Engine:
    """Everything that is the same in every step of one vessel.

    Parameters
    ----------
    vessel
        Geometry, limits and weights.
    """

    def __init__(self, vessel: Vessel) -> None:
        n, m = len(vessel.thrusters), len(vessel.degrees_of_freedom)
        self.weights = Weights.of(vessel)
        self.columns = self.weights.columns
        self.power_factor = vessel.propellers.power_per_thrust_3_2.copy()
        self.compliance = 1.0 / self.weights.slack
        self._approach = vessel.allocator.approach_fraction
        self._zero_region = vessel.allocator.zero_region
        self._accepted_force = _ACCEPTED_FORCE * float((vessel.thrust_max - vessel.thrust_min).sum())
        self._corners, self._count = np.zeros((n, CORNERS, 2)), np.zeros(n, dtype=np.int64)
        self._face, self._work = np.zeros(n, dtype=np.int64), np.zeros((m, m + 1))
        self._gradient = np.zeros((n, 2))
        self._shape = n, m
        self._is_yaw = np.array([axis == "yaw" for axis in vessel.degrees_of_freedom])
        self._solver: Solver = make_solver(NAME)
        self._second = DaqpSolver()

    def use(self, solver: str) -> None:
        """Choose the solver by name. Raises InputError."""
        if solver != self._solver.name:
            self._solver = make_solver(solver)

    def run(
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
        """Allocate ``tau`` in one step.

        Parameters
        ----------
        limits
            Table of limits, shape (n, 14).
        before
            Commands of the step before, shape (n, 5).
        multiplier
            lambda of a problem like it, shape (m,); not changed.
        weight
            Diagonal of W_u^2, shape (n,).
        tau
            Demanded generalized force, shape (m,), N or N m.
        dt
            Time step, s.
        coupling
            Limits shared by several thrusters, if any.
        yaw_factor
            Factor on the weight of the slack in yaw, W_v.
        """
        n, m = self._shape
        compliance = self.compliance
        if yaw_factor != 1.0:
            compliance = compliance / np.where(self._is_yaw, yaw_factor**2, 1.0)
        answer = Answer(
            tau,
            np.empty((n, 6)),
            np.empty((n, Command.COLUMNS)),
            np.empty(m + Total.COUNT),
            multiplier.copy(),
            np.zeros((n, 2)),
            weight,
            compliance,
            0,
        )
        if self._solver.name == NAME and coupling is None:
            steps = allocate(
                limits, before, self.columns, weight, compliance, self.power_factor, tau, dt, self._approach,
                self._zero_region, answer.multiplier, answer.plans, self._corners, self._count, answer.force,
                self._face, self._work, self._gradient, answer.commands, answer.totals,
            )  # fmt: skip
            answer.steps = steps
            if steps >= 0 and answer.totals[Total.STATIONARITY] <= _ACCURATE:
                return answer
        plan_thrusters(limits, before[:, 0], before[:, 1], dt, self._approach, answer.plans)
        answer.problem = self.problem(answer, coupling)
        self._ask(self._second if self._solver.name == NAME else self._solver, answer)
        held = answer.plans[:, Plan.AZIMUTH]
        if answer.complaint:
            answer.multiplier[:] = 0.0
            answer.force[:, 0], answer.force[:, 1] = before[:, 0] * np.cos(held), before[:, 0] * np.sin(held)
        commands(answer.plans, limits[:, Limit.SPAN], answer.force, answer.commands)
        if answer.complaint:
            # To the last bit, which the way through components would not keep.
            lower, upper = answer.plans[:, Plan.LOWER], answer.plans[:, Plan.UPPER]
            answer.commands[:, Command.THRUST] = np.minimum(np.maximum(before[:, 0], lower), upper)
            answer.commands[:, Command.AZIMUTH] = held
        self.add_up(answer)
        answer.totals[Total.STATIONARITY] = 0.0 if answer.solution is None else answer.solution.residuals.stationarity
        return answer

    def impose(
        self,
        limits: FloatArray,
        before: FloatArray,
        weight: FloatArray,
        tau: FloatArray,
        dt: float,
        want: Callable[[FloatArray], FloatArray],
    ) -> Answer:
        """Command thrusts that are known, brought into the windows of this step.

        Parameters
        ----------
        limits
            Table of limits, shape (n, 14), with no thruster that rotates.
        before, weight, tau, dt
            As in :meth:`run`.
        want
            From the table of plans, shape (n, 6), to the thrust of every thruster along its direction there, (n,), N.
        """
        n, m = self._shape
        plans, table = np.empty((n, 6)), np.empty((n, Command.COLUMNS))
        plan_thrusters(limits, before[:, 0], before[:, 1], dt, self._approach, plans)
        thrust = np.minimum(np.maximum(want(plans), plans[:, Plan.LOWER]), plans[:, Plan.UPPER])
        held = plans[:, Plan.AZIMUTH]
        force = np.column_stack((thrust * np.cos(held), thrust * np.sin(held)))
        commands(plans, limits[:, Limit.SPAN], force, table)
        # To the last bit, which the way through components would not keep; a lost one has its own in its plan.
        table[:, Command.THRUST] = thrust
        answer = Answer(
            tau, plans, table, np.zeros(m + Total.COUNT), np.zeros(m), force, weight, self.compliance, 0, solved=False
        )
        self.add_up(answer)
        return answer

    def add_up(self, answer: Answer) -> None:
        """Sum up the commands of ``answer`` anew, after they have been changed."""
        add_up(
            self.columns,
            answer.weight,
            answer.compliance,
            self.power_factor,
            answer.tau,
            answer.commands,
            answer.totals,
        )

    def problem(self, answer: Answer, coupling: Coupling | None = None) -> AllocationProblem:
        """Return the problem that a run solved, as an object."""
        weights = self.weights
        if answer.weight is not weights.thrust or answer.compliance is not self.compliance:
            weights = Weights(weights.columns, 1.0 / answer.compliance, answer.weight, weights.zero_region)
        return AllocationProblem(weights, answer.plans, answer.tau, coupling)

    def solver_of(self, answer: Answer) -> str:
        """Return the name of the solver that was asked last for ``answer``; empty if none was."""
        if not answer.solved:
            return ""
        if answer.problem is None:
            return NAME
        return self._second.name if self._solver.name == NAME else self._solver.name

    def solution(self, answer: Answer) -> Solution | None:
        """Return what the solver made of the problem of a run; None where it gave nothing."""
        if answer.problem is not None:
            return answer.solution
        return solution_of(self.problem(answer), answer.force, answer.multiplier, answer.steps)

    def _ask(self, solver: Solver, answer: Answer) -> None:
        problem = answer.problem
        if problem is None or not problem.variables:
            return
        solution = answer.solution = solver.solve(problem)
        if solution is None:
            answer.complaint = f"{solver.name} gave no answer"
            return
        residuals = solution.residuals
        if not residuals.within(self._accepted_force, _ACCEPTED_STATIONARITY):
            said = f" ({solution.message})" if solution.message else ""
            answer.complaint = (
                f"{solver.name} failed{said}: violation {residuals.violation:.3g} N, "
                f"stationarity {residuals.stationarity:.3g}, dual violation {residuals.dual_violation:.3g}, "
                f"complementarity {residuals.complementarity:.3g}"
            )
            return
        answer.steps = solution.iterations
        answer.force[:] = problem.forces(solution.z)
        answer.multiplier[:] = problem.weights.slack * problem.slack(solution.z)
