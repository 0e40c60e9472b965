"""What the allocator's node says of itself on /diagnostics: a pure function of what it has done."""

from __future__ import annotations

from dataclasses import dataclass, field

from dp_node import Health, Level
from marine_model import Vessel
from thrust_allocator.power import PowerStage
from thrust_allocator.result import AllocationResult, Status
from thrust_allocator.settings import AllocatorSettings

_MEANING = {
    Status.OPTIMAL: Level.OK,
    Status.DEMAND_NOT_FINITE: Level.WARN,
    Status.NO_THRUSTER: Level.ERROR,
    Status.HOLD: Level.ERROR,
    Status.DEACTIVATED: Level.WARN,
}
# A demand on the boundary of the attainable set has a margin of 1 but for rounding, and so has a gain at its limit.
_ROUNDING = 1e-6


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
    fresh, fresh_hold
        Demands answered since the last report, and those of them without a good answer of any solver.
    solve_time, longest
        Sum and largest of the times of these, s.
    """

    last: AllocationResult | None = None
    demands: int = 0
    steps: dict[Status, int] = field(default_factory=lambda: dict.fromkeys(Status, 0))
    other_solver: int = 0
    fresh: int = 0
    fresh_hold: int = 0
    solve_time: float = 0.0
    longest: float = 0.0

    def add(self, result: AllocationResult, solver: str) -> None:
        """Take note of an answer; ``solver`` is the one that the settings name."""
        self.last = result
        self.demands += 1
        self.steps[result.status] += 1
        self.other_solver += result.solver != solver
        self.fresh += 1
        self.fresh_hold += result.status is Status.HOLD
        self.solve_time += result.solve_time
        self.longest = max(self.longest, result.solve_time)

    def reported(self) -> None:
        """Begin the next report."""
        self.fresh = self.fresh_hold = 0
        self.solve_time = self.longest = 0.0


def health_of(tally: Tally, settings: AllocatorSettings, vessel: Vessel, waiting: str = "") -> Health:
    """Return level, text and values.

    Parameters
    ----------
    tally
        What was done.
    settings, vessel
        Those in force.
    waiting
        What the node waits for before it answers; empty if nothing.
    """
    last = tally.last
    count = max(tally.demands, 1)
    values: dict[str, object] = {
        "status": Status.OPTIMAL.value if last is None else last.status.value,
        "detail": "" if last is None else last.message,
        "demands": tally.demands,
        **{f"steps_{status.value}": number for status, number in tally.steps.items()},
        "solver": settings.solver,
        "share_of_other_solvers": tally.other_solver / count,
        "share_of_holds": tally.steps[Status.HOLD] / count,
        "solve_time_mean_us": 1e6 * tally.solve_time / tally.fresh if tally.fresh else 0.0,
        "solve_time_max_us": 1e6 * tally.longest,
    }
    found: list[tuple[Level, str]] = []
    if waiting:
        found.append((Level.WARN, waiting))
    elif not tally.fresh:
        found.append((Level.WARN, "no tau_desired: no thruster_command"))
    if last is not None:
        values |= _values(last, settings, vessel)
    if last is not None and tally.fresh:
        level = _MEANING[last.status]
        if level is not Level.OK:
            found.append((level, f"{last.status.value}: {last.message}"))
        elif tally.fresh_hold:
            found.append((Level.WARN, f"hold: {tally.fresh_hold} of the last {tally.fresh} demands had no good answer"))
        found += [(Level.WARN, text) for text in _warnings(last, settings, vessel)]
    worst = max((level for level, _ in found), default=Level.OK)
    return Health(worst, "; ".join(text for _, text in found) or "nominal", values)


def _values(last: AllocationResult, settings: AllocatorSettings, vessel: Vessel) -> dict[str, object]:
    margin = last.margin
    found: dict[str, object] = {
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


def _warnings(last: AllocationResult, settings: AllocatorSettings, vessel: Vessel) -> list[str]:
    """Return what an operator has to know of an answer that is as good as it can be."""
    found = []
    margin = last.margin
    if margin.turning < 1.0 - _ROUNDING:
        found.append(f"demand out of reach: {margin.turning:.3g} of it is attainable")
    elif margin.fixed < 1.0 - _ROUNDING:
        found.append(
            f"demand out of reach as the thrusters point: {margin.fixed:.3g} of it is attainable, "
            f"{margin.turning:.3g} once they have turned"
        )
    power = last.power
    if power is not None:
        if power.stage is not PowerStage.WITHIN:
            found.append(
                f"power limited ({power.stage.name.lower()}): {power.demanded:.4g} W demanded, "
                f"{settings.power.available:.4g} W available"
            )
        for i, limited in enumerate(power.bus_limited):
            if limited:
                found.append(
                    f"power of {vessel.power.buses[i].name} limited: {power.bus[i]:.4g} W of "
                    f"{settings.power.bus_limit[i]:.4g} W"
                )
    if settings.antispin.enabled and last.antispin and not last.ventilation_known:
        found.append(f"no ventilation in the last {settings.antispin.timeout:.3g} s: torque losses are being forgotten")
    avoidance = last.avoidance
    # Without avoidance nobody asked: the optimum of many demands lies below any limit.
    if avoidance is not None and avoidance.minimum_gain < avoidance.threshold * (1.0 - _ROUNDING):
        crossing = ", on the way through" if avoidance.crossing else ""
        found.append(
            f"minimum gain {avoidance.minimum_gain:.3g} is below the limit {avoidance.threshold:.3g}{crossing}"
        )
    if avoidance is not None and avoidance.locked:
        found.append(
            f"singularity avoidance is locked: angles of cost {avoidance.cost_free:.4g} are known, "
            f"these cost {avoidance.cost_kept:.4g}"
        )
    return found


def _named(names: tuple[str, ...], chosen: tuple[bool, ...]) -> list[str]:
    return [name for name, is_so in zip(names, chosen, strict=True) if is_so]
