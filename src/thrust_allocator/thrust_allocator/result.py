"""How one demand was answered."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import nan

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.attainable import Margin
from thrust_allocator.methods import MethodReport
from thrust_allocator.monitoring import Monitoring
from thrust_allocator.plan.phase import Phase
from thrust_allocator.plan.polar import Command
from thrust_allocator.power.limiter import PowerReport
from thrust_allocator.program.problem import AllocationProblem
from thrust_allocator.program.solution import Solution
from thrust_allocator.sectors.control import SectorReport
from thrust_allocator.singularity import MinimumGain, MonitorReading
from thrust_allocator.singularity.avoidance import AvoidanceReport
from thrust_allocator.step import Total

_PHASES = tuple(Phase)


class Status(StrEnum):
    """Which rule gave the answer."""

    OPTIMAL = "optimal"
    # Every thruster is lost: there is nothing to allocate.
    NO_THRUSTER = "no_thruster"
    # The demand was not finite: the last good one was allocated, or zero before the first.
    DEMAND_NOT_FINITE = "demand_not_finite"
    # The solver gave no good answer: thrusts and directions stay, as far as their windows allow.
    HOLD = "hold"
    # The node is deactivated: every thruster is ramped to zero, whatever is asked.
    DEACTIVATED = "deactivated"


@dataclass(frozen=True, slots=True)
class AllocationResult:
    """Answer of :meth:`Allocator.step`. Arrays over thrusters have shape (n,) and the order of the vessel file.

    Attributes
    ----------
    commands
        Table of commands, shape (n, 5), see :class:`polar.Command`.
    totals
        Sums over the thrusters, shape (m + 4,), see :class:`step.Total`.
    tau_desired
        The demand that was allocated, over the vessel's degrees of freedom, shape (m,), N or N m; differs from the
        argument where that was not finite.
    solve_time
        Time this step took from demand to answer, s.
    status
        Which rule gave the answer.
    message
        Why it was not the usual one; empty otherwise.
    azimuth_mode
        Mode in force: fixed or rotating.
    mean_force
        Performance measure of (6.3): low-pass filtered surge-sway demand, N; NaN unless the operator asks for auto.
    solver
        Name of the solver that answered: that of the settings, or daqp in place of the package's own; empty with a
        method that solves nothing.
    sectors
        What the supervisor of sectors decided; None without sectors.
    power
        What power had to do with it; None without a limit of power.
    avoidance
        What singularity avoidance did; None without it.
    antispin
        Whether ventilation has a say in the cost: ``antispin.enabled``, or losses that are not forgotten yet.
    ventilation_known
        Whether it is on and was told of ventilation within ``antispin.timeout``.
    torque_loss
        beta_Q2 in use, shape (n,), 1 without loss.
    limits
        Table of limits of this step, shape (n, 14), see :class:`phase.Limit`.
    monitoring
        Answers :attr:`gains` and :attr:`margin`.
    problem, solution
        On a failure the problem and what the solver made of it, for debugging; None otherwise.
    method
        That divided the demand: qp or another.
    method_report
        What another one did; None with qp.
    """

    commands: FloatArray
    totals: FloatArray
    tau_desired: FloatArray
    solve_time: float
    status: Status
    message: str
    azimuth_mode: str
    mean_force: float
    solver: str
    sectors: SectorReport | None
    power: PowerReport | None
    avoidance: AvoidanceReport | None
    antispin: bool
    ventilation_known: bool
    torque_loss: FloatArray
    limits: FloatArray
    monitoring: Monitoring
    problem: AllocationProblem | None
    solution: Solution | None
    method: str = "qp"
    method_report: MethodReport | None = None

    @property
    def thrust(self) -> FloatArray:
        """Commanded thrust along the direction, shape (n,), N."""
        return self.commands[:, Command.THRUST].copy()

    @property
    def azimuth(self) -> FloatArray:
        """Commanded direction, shape (n,), rad in [-pi, pi), body frame."""
        return self.commands[:, Command.AZIMUTH].copy()

    @property
    def tau_achieved(self) -> FloatArray:
        """B(azimuth) thrust over the thrusters that are not lost, shape (m,), N or N m."""
        return self.totals[: Total.COST].copy()

    @property
    def wrench(self) -> FloatArray:
        """The same in all six degrees of freedom with by-products, shape (6,); on the surface zero in the others."""
        return self.monitoring.wrench(self.commands, self.totals[: Total.COST])

    @property
    def slack(self) -> FloatArray:
        """tau_desired - tau_achieved, shape (m,), N or N m."""
        return self.tau_desired - self.totals[: Total.COST]

    @property
    def feasible_load(self) -> float:
        """The demand over the edge of the method's own region, which reduces it above 1; NaN with qp."""
        return nan if self.method_report is None else self.method_report.load

    @property
    def tau_feasible(self) -> FloatArray:
        """What the method reduced the demand to, shape (m,), N or N m; NaN with qp, which reduces nothing."""
        report = self.method_report
        return np.full(len(self.tau_desired), nan) if report is None else report.tau_feasible

    @property
    def tau_qp(self) -> FloatArray:
        """What qp would have achieved from the same operating point, shape (m,); NaN with qp or if it was not asked."""
        report = self.method_report
        return np.full(len(self.tau_desired), nan) if report is None else report.tau_qp

    @property
    def detail(self) -> str:
        """What the method reduced, and why; empty if nothing."""
        return "" if self.method_report is None else self.method_report.detail

    @property
    def cost(self) -> float:
        """Value of the cost function at the commands, thrusters that are not lost."""
        return float(self.totals[Total.COST])

    @property
    def demanded_power(self) -> float:
        """Predicted power of the demand before any limit of power, W: what a power plant is to be told."""
        return float(self.totals[Total.POWER]) if self.power is None else self.power.demanded

    @property
    def commanded_power(self) -> float:
        """Predicted power of the commands, W, thrusters that are not lost; (3.11), corrected by (4.44) if measured."""
        return float(self.totals[Total.POWER]) if self.power is None else self.power.commanded

    @property
    def phase(self) -> tuple[Phase, ...]:
        """What every thruster was doing."""
        return tuple([_PHASES[int(phase)] for phase in self.commands[:, Command.PHASE].tolist()])

    @property
    def rotating(self) -> tuple[bool, ...]:
        """Allocated as rotating."""
        return tuple([phase == Phase.ROTATING for phase in self.commands[:, Command.PHASE].tolist()])

    @property
    def thrust_saturated(self) -> tuple[bool, ...]:
        """Thrust at a magnitude or rate limit; a rotating thruster at rest is not."""
        return tuple([at != 0.0 for at in self.commands[:, Command.THRUST_SATURATED].tolist()])

    @property
    def azimuth_saturated(self) -> tuple[bool, ...]:
        """Direction at an end of its window."""
        return tuple([at != 0.0 for at in self.commands[:, Command.AZIMUTH_SATURATED].tolist()])

    @property
    def gains(self) -> MonitorReading:
        """Minimum gains as ``singularity.monitor`` asks for them, computed when read."""
        return self.monitoring.read(self.commands, self.limits)

    @property
    def gain_both_ways(self) -> MinimumGain:
        """Minimum gain at the commanded angles if every thruster could reverse, [Ruth] 7.3, computed when read."""
        return self.monitoring.both_ways(self.commands)

    @property
    def margin(self) -> Margin:
        """How many times the demand is attainable: at the commanded angles, and once turned; computed when read."""
        return self.monitoring.margin(self.commands, self.tau_desired)
