"""What the allocator's node says of itself on /diagnostics: a pure function of what it has done."""

from __future__ import annotations

from dataclasses import dataclass, field

from dp_node import Alarm, Health, health_with, raised
from marine_model import Vessel
from thrust_allocator.power import PowerStage
from thrust_allocator.result import AllocationResult, Status
from thrust_allocator.settings import AllocatorSettings

_CODES = {
    Status.DEMAND_NOT_FINITE: "ALLOCATOR-DEMAND-NOT-FINITE",
    Status.NO_THRUSTER: "ALLOCATOR-NO-THRUSTER",
    Status.HOLD: "ALLOCATOR-SOLVER-FAILED",
}
# A demand on the boundary of the attainable set has a margin of 1 but for rounding, and so has a gain at its limit.
_ROUNDING = 1e-6
# Below, a hundredth of the thrust comes out as force in the weakest direction. Zero itself is not met: thrusters that
# answer one demand stop some thousandths of a radian from a common direction.
_SINGULAR = 0.01
# Reports before it: thrusters that turn pass through such configurations, and at rest they wander.
_STILL_SINGULAR = 2
# A thruster that is at a limit for so many samples of the measurement in a row is saturated for long: at its rate it
# passes through its whole range in 2 (CyberShip III) to 10 samples (drillship).
_LONG = 50


@dataclass(slots=True)
class Tally:
    """What the node has done since it was activated; where it says so, since the last report.

    Attributes
    ----------
    last
        Answer to the last demand.
    demands, steps
        Demands answered, and by which rule.
    other_solver
        Of them, answers of another solver than the settings name.
    fresh, fresh_hold, fresh_other
        Demands answered since the last report, those of them without a good answer of any solver, and those answered
        by another solver than the settings name.
    solve_time, longest
        Sum and largest of the times of these, s.
    saturated
        For how long every thruster has been at a limit without a break, s.
    singular
        Reports in a row at which the configuration was singular.
    """

    last: AllocationResult | None = None
    demands: int = 0
    steps: dict[Status, int] = field(default_factory=lambda: dict.fromkeys(Status, 0))
    other_solver: int = 0
    fresh: int = 0
    fresh_hold: int = 0
    fresh_other: int = 0
    solve_time: float = 0.0
    longest: float = 0.0
    saturated: tuple[float, ...] = ()
    singular: int = 0

    def add(self, result: AllocationResult, solver: str, dt: float) -> None:
        """Take note of an answer after ``dt`` (s); ``solver`` is the one that the settings name."""
        self.last = result
        self.demands += 1
        self.steps[result.status] += 1
        other = result.solver not in ("", solver)
        self.other_solver += other
        self.fresh_other += other
        at_limit = result.thrust_saturated
        before = self.saturated or (0.0,) * len(at_limit)
        self.saturated = tuple([time + dt if at else 0.0 for time, at in zip(before, at_limit, strict=True)])
        self.fresh += 1
        self.fresh_hold += result.status is Status.HOLD
        self.solve_time += result.solve_time
        self.longest = max(self.longest, result.solve_time)

    def reported(self) -> None:
        """Begin the next report."""
        self.fresh = self.fresh_hold = self.fresh_other = 0
        self.solve_time = self.longest = 0.0
        self.singular = self.singular + 1 if self.last is not None and is_singular(self.last) else 0


def is_singular(result: AllocationResult) -> bool:
    """Return whether the thrusters in use, as they point, give no force in some direction."""
    # Not known of a vessel that controls other axes: NaN is not less.
    return result.status is not Status.NO_THRUSTER and result.gain_both_ways.gain < _SINGULAR


def health_of(
    tally: Tally, settings: AllocatorSettings, vessel: Vessel, waiting: str = "", no_feedback: bool = False
) -> Health:
    """Return level, text, values and alarms.

    Parameters
    ----------
    tally
        What was done.
    settings, vessel
        Those in force.
    waiting
        Input that a demand waits for; empty if none.
    no_feedback
        Whether demands are refused until the first thruster_feedback.
    """
    last = tally.last
    count = max(tally.demands, 1)
    values: dict[str, object] = {
        "status": Status.OPTIMAL.value if last is None else last.status.value,
        "detail": "" if last is None else last.message,
        "demands": tally.demands,
        **{f"steps_{status.value}": number for status, number in tally.steps.items()},
        "solver": settings.solver,
        "disabled": " ".join(_named(vessel.thruster_names, tuple((~settings.enabled(vessel)).tolist()))),
        "share_of_other_solvers": tally.other_solver / count,
        "share_of_holds": tally.steps[Status.HOLD] / count,
        "solve_time_mean_us": 1e6 * tally.solve_time / tally.fresh if tally.fresh else 0.0,
        "solve_time_max_us": 1e6 * tally.longest,
    }
    alarms: list[Alarm] = []
    if no_feedback:
        alarms.append(raised("ALLOCATOR-NO-FEEDBACK"))
    elif waiting:
        alarms.append(raised("ALLOCATOR-WAITS", waiting))
    elif not tally.fresh:
        alarms.append(raised("ALLOCATOR-NO-DEMAND"))
    if last is not None:
        values |= _values(last, settings, vessel)
    # One that is deactivated is shown as that, and not for what it does not do.
    if last is not None and tally.fresh and last.status is not Status.DEACTIVATED:
        if last.status in _CODES:
            alarms.append(raised(_CODES[last.status], last.message))
        elif tally.fresh_hold:
            alarms.append(raised("ALLOCATOR-SOLVER-HELD", f"{tally.fresh_hold} of the last {tally.fresh}"))
        if tally.fresh_other and settings.power.limit not in ("bus", "both"):
            # Limits that thrusters share are daqp's by design.
            alarms.append(raised("ALLOCATOR-SOLVER-FELL-BACK", f"{tally.fresh_other} of the last {tally.fresh}"))
        alarms += _limits(last, settings, vessel)
        alarms += _thrusters(tally, last, settings, vessel)
        alarms += _singularity(tally, last)
    return health_with(alarms, values)


def _values(last: AllocationResult, settings: AllocatorSettings, vessel: Vessel) -> dict[str, object]:
    margin = last.margin
    found: dict[str, object] = {
        "method": last.method,
        "azimuth_mode": last.azimuth_mode,
        "margin": margin.fixed,
        "margin_turned": margin.turning,
        "demanded_power_W": last.demanded_power,
        "commanded_power_W": last.commanded_power,
        "power_limit": settings.power.limit,
    }
    if last.power is not None:
        if settings.power.limit in ("total", "both"):
            found["available_power_W"] = settings.power.available
        found["power_stage"] = last.power.stage.name.lower()
        found["power_correction"] = last.power.correction
    if last.sectors is not None:
        found["sub_problem"] = last.sectors.sub_problem
        found["crossing"] = " ".join(_named(vessel.thruster_names, last.sectors.crossing))
    if last.method_report is not None:
        found["feasible_load"] = last.feasible_load
        found["reduced"] = last.detail
    if last.antispin:
        spared = zip(vessel.thruster_names, last.torque_loss.tolist(), strict=True)
        found["spared"] = " ".join([f"{name} {loss:.2f}" for name, loss in spared if loss < 1.0])
    found["minimum_gain"] = last.gains.global_gain
    found["minimum_gain_both_ways"] = last.gain_both_ways.gain
    found["singularity_method"] = settings.singularity.method
    if last.avoidance is not None:
        found["gain_limit"] = last.avoidance.threshold
        found["avoidance_waiting"] = last.avoidance.waiting
        found["avoidance_locked"] = last.avoidance.locked
    return found


def _limits(last: AllocationResult, settings: AllocatorSettings, vessel: Vessel) -> list[Alarm]:
    """Return what of a demand cannot be had, and for want of what."""
    found = []
    margin = last.margin
    if margin.turning < 1.0 - _ROUNDING:
        found.append(raised("ALLOCATOR-DEMAND-OUT-OF-REACH", f"{margin.turning:.3g} of it is attainable"))
    elif margin.fixed < 1.0 - _ROUNDING:
        detail = f"{margin.fixed:.3g} of it is attainable, {margin.turning:.3g} once they have turned"
        found.append(raised("ALLOCATOR-DEMAND-WAITS-FOR-AZIMUTH", detail))
    power = last.power
    if power is not None:
        if power.stage is not PowerStage.WITHIN:
            code = "ALLOCATOR-POWER-PHASE-BACK" if power.stage is PowerStage.PHASE_BACK else "ALLOCATOR-POWER-LIMITED"
            detail = f"{power.demanded:.4g} W demanded, {settings.power.available:.4g} W available"
            found.append(raised(code, f"{detail} ({power.stage.name.lower()})"))
        for i, limited in enumerate(power.bus_limited):
            if limited:
                name, limit = vessel.power.buses[i].name, settings.power.bus_limit[i]
                found.append(raised("ALLOCATOR-BUS-LIMITED", f"{name}, {power.bus[i]:.4g} W of {limit:.4g} W"))
    if settings.antispin.enabled and last.antispin and not last.ventilation_known:
        found.append(raised("ALLOCATOR-VENTILATION-STALE", f"none in the last {settings.antispin.timeout:.3g} s"))
    return found


def _thrusters(tally: Tally, last: AllocationResult, settings: AllocatorSettings, vessel: Vessel) -> list[Alarm]:
    """Return which thrusters are not in use, or not what they should be."""
    found = []
    names = vessel.thruster_names
    lost = tuple((~settings.enabled(vessel)).tolist())
    if any(lost) and last.status is not Status.NO_THRUSTER:
        found.append(raised("ALLOCATOR-THRUSTERS-DISABLED", ", ".join(_named(names, lost))))
    limit = _LONG * vessel.measurement.sample_time
    for name, time in zip(names, tally.saturated, strict=False):
        if time >= limit * (1.0 - _ROUNDING):
            found.append(raised("ALLOCATOR-THRUST-SATURATED", f"{name} for {time:.0f} s"))
    return found


def _singularity(tally: Tally, last: AllocationResult) -> list[Alarm]:
    """Return which directions are short of force."""
    found = []
    if tally.singular >= _STILL_SINGULAR and is_singular(last):
        found.append(raised("ALLOCATOR-SINGULAR"))
    avoidance = last.avoidance
    # Without avoidance nobody asked: the optimum of many demands lies below any limit.
    if avoidance is not None and avoidance.minimum_gain < avoidance.threshold * (1.0 - _ROUNDING):
        crossing = ", on the way through" if avoidance.crossing else ""
        detail = f"{avoidance.minimum_gain:.3g} of {avoidance.threshold:.3g}{crossing}"
        found.append(raised("ALLOCATOR-GAIN-LOW", detail))
    if avoidance is not None and avoidance.locked:
        detail = f"angles of cost {avoidance.cost_free:.4g} are known, these cost {avoidance.cost_kept:.4g}"
        found.append(raised("ALLOCATOR-AVOIDANCE-LOCKED", detail))
    return found


def _named(names: tuple[str, ...], chosen: tuple[bool, ...]) -> list[str]:
    return [name for name, is_so in zip(names, chosen, strict=True) if is_so]
