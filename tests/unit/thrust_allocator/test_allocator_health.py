"""What the allocator's node says of itself, from answers of the core."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from dp_node import Health, Level
from marine_model import load_vessel
from marine_model.settings import with_parameters
from marine_model.thruster import TunnelThruster
from thrust_allocator import AllocationResult, Allocator, AllocatorSettings, Status
from thrust_allocator.node_health import Tally, health_of
from thrust_allocator.power import PowerStage

VESSEL = load_vessel("cybership3")
TAU = (3.0, 1.0, 0.5)


def settings_with(**changes: Any) -> AllocatorSettings:
    named = {name.replace("__", "."): value for name, value in changes.items()}
    return with_parameters(AllocatorSettings.for_vessel(VESSEL), named)


def run(tau: tuple[float, float, float] = TAU, steps: int = 1, **changes: Any) -> tuple[Tally, AllocatorSettings]:
    settings = settings_with(**changes)
    allocator, tally = Allocator(VESSEL, settings), Tally()
    for _ in range(steps):
        tally.add(allocator.step(tau, 0.2), settings.solver, 0.2)
    return tally, settings


def said(tau: tuple[float, float, float] = TAU, steps: int = 1, **changes: Any) -> Health:
    return health_of(*run(tau, steps, **changes), VESSEL)


def codes(health: Health) -> list[str]:
    return [alarm.kind.code for alarm in health.alarms]


def last(tally: Tally) -> AllocationResult:
    assert tally.last is not None
    return tally.last


def test_good_answers_are_nominal_with_values() -> None:
    tally, settings = run(steps=3, azimuth_mode="auto")
    health = health_of(tally, settings, VESSEL)
    result = last(tally)
    assert (health.level, health.message) == (Level.OK, "nominal")
    values = health.values
    assert (values["status"], values["demands"], values["steps_optimal"]) == ("optimal", 3, 3)
    assert (values["share_of_other_solvers"], values["share_of_holds"]) == (0.0, 0.0)
    assert values["azimuth_mode"] == result.azimuth_mode
    assert values["margin"] == result.margin.fixed > 1.0
    assert values["demanded_power_W"] == result.demanded_power
    assert values["minimum_gain_both_ways"] == result.gain_both_ways.gain
    assert {"sub_problem", "power_stage", "gain_limit"} & set(values) == set()  # nothing of what is off


def test_no_demand_since_the_last_report_is_a_warning() -> None:
    tally, settings = run()
    tally.reported()
    health = health_of(tally, settings, VESSEL)
    assert (health.level, health.message) == (Level.WARN, "no tau_desired: no thruster_command")
    assert health_of(Tally(), settings, VESSEL).message == "no tau_desired: no thruster_command"
    assert codes(health) == ["ALLOCATOR-NO-DEMAND"]
    health = health_of(Tally(), settings, VESSEL, no_feedback=True)
    assert (health.level, codes(health)) == (Level.WARN, ["ALLOCATOR-NO-FEEDBACK"])
    assert health.message == "no thruster_feedback yet: demands are refused"
    health = health_of(Tally(), settings, VESSEL, "ventilation")
    assert (health.message, codes(health)) == ("tau_desired waits for an input: ventilation", ["ALLOCATOR-WAITS"])


def test_answers_of_another_solver_are_counted() -> None:
    """Shared limits are daqp's; of four answers, those with a bus at its limit."""
    tally, settings = run((7.0, -3.0, 2.0), 4, azimuth_mode="rotating", power__limit="bus", power__bus_limit=[0.3, 0.3])
    assert last(tally).solver == "daqp"
    share = health_of(tally, settings, VESSEL).values["share_of_other_solvers"]
    assert share == tally.other_solver / 4 > 0.0


def test_a_hold_is_an_error_while_it_lasts_and_then_a_warning_for_one_report() -> None:
    tally, settings = run()
    good = last(tally)
    held = replace(good, status=Status.HOLD, message="daqp gave no answer")
    tally.add(held, settings.solver, 0.2)
    health = health_of(tally, settings, VESSEL)
    assert (health.level, health.message) == (
        Level.ERROR,
        "hold: no solver has a good answer, the last command stands: daqp gave no answer",
    )
    assert codes(health) == ["ALLOCATOR-SOLVER-FAILED"]
    assert health.values["share_of_holds"] == 0.5
    tally.add(good, settings.solver, 0.2)
    health = health_of(tally, settings, VESSEL)
    assert (health.level, health.message) == (
        Level.WARN,
        "hold: demands without a good answer: 1 of the last 3",
    )
    assert codes(health) == ["ALLOCATOR-SOLVER-HELD"]
    tally.reported()
    tally.add(good, settings.solver, 0.2)
    assert health_of(tally, settings, VESSEL).level is Level.OK


def test_lost_thrusters_and_bad_demands() -> None:
    health = said(thruster_enabled=[False] * 4)
    assert health.level is Level.ERROR
    assert health.message.startswith("no_thruster: every thruster is lost; demand out of reach: 0 of it")
    assert codes(health) == ["ALLOCATOR-NO-THRUSTER", "ALLOCATOR-DEMAND-OUT-OF-REACH"]
    health = said((math.nan, 0.0, 0.0))
    assert health.level is Level.WARN
    assert health.message.startswith("demand_not_finite: tau_desired: expected finite numbers")
    assert codes(health) == ["ALLOCATOR-DEMAND-NOT-FINITE"]
    health = said(thruster_enabled=[False, True, True, True])
    assert (health.level, codes(health)) == (Level.WARN, ["ALLOCATOR-THRUSTERS-DISABLED"])
    assert health.message == f"thrusters are not in use: {VESSEL.thruster_names[0]}"


def test_a_demand_out_of_reach_says_how_much_is_attainable_now_and_once_turned() -> None:
    tally, settings = run((60.0, 0.0, 0.0), azimuth_mode="rotating")
    share = last(tally).margin.turning
    assert share < 1.0
    health = health_of(tally, settings, VESSEL)
    assert (health.level, health.message) == (
        Level.WARN,
        f"demand out of reach: {share:.3g} of it is attainable",
    )
    # Ahead, 26 N: more than the aft thrusters have at 45 deg, less than they have once all point ahead.
    tally, settings = run((26.0, 0.0, 0.0))
    now, turned = last(tally).margin
    assert now < 1.0 < turned
    health = health_of(tally, settings, VESSEL)
    assert health.level is Level.WARN
    assert health.message == (
        f"demand out of reach as the thrusters point: {now:.3g} of it is attainable, {turned:.3g} once they have turned"
    )
    assert codes(health) == ["ALLOCATOR-DEMAND-WAITS-FOR-AZIMUTH"]


def test_a_demand_on_the_boundary_is_within_reach() -> None:
    """Beyond it by 1e-9 is rounding."""
    x, y, n = TAU
    scale = last(run()[0]).margin.fixed * (1.0 + 1e-9)
    tally, settings = run((scale * x, scale * y, scale * n))
    assert last(tally).margin.fixed < 1.0
    assert health_of(tally, settings, VESSEL).level is Level.OK


def test_limited_power_is_a_warning() -> None:
    tally, settings = run((7.0, -3.0, 2.0), power__limit="total", power__available=1.0)
    health = health_of(tally, settings, VESSEL)
    power = last(tally).power
    assert power is not None
    assert health.level is Level.WARN
    assert codes(health) == ["ALLOCATOR-POWER-PHASE-BACK"]
    assert health.message == (
        f"all thrust phased back for want of power: {power.demanded:.4g} W demanded, 1 W available (phase_back)"
    )
    for stage in PowerStage:  # whatever the demand came to, each stage is told by its code
        told = Tally()
        told.add(replace(last(tally), power=power._replace(stage=stage)), settings.solver, 0.2)
        expected: dict[PowerStage, list[str]] = {
            PowerStage.WITHIN: [],
            PowerStage.PHASE_BACK: ["ALLOCATOR-POWER-PHASE-BACK"],
        }
        assert codes(health_of(told, settings, VESSEL)) == expected.get(stage, ["ALLOCATOR-POWER-LIMITED"])
    assert health.values["available_power_W"] == 1.0
    assert health.values["power_stage"] == power.stage.name.lower()

    tally, settings = run((7.0, -3.0, 2.0), 4, power__limit="bus", power__bus_limit=[0.5, 1e9])
    power = last(tally).power
    assert power is not None
    assert power.bus_limited[0]
    health = health_of(tally, settings, VESSEL)
    assert f"power of a bus limited: bus_a, {power.bus[0]:.4g} W of 0.5 W" in health.message
    assert set(codes(health)) == {"ALLOCATOR-BUS-LIMITED"}, "daqp's answers are by design there"


def test_sectors_say_which_windows_and_who_is_on_the_way() -> None:
    tally, settings = run((8.0, -4.0, 2.0), azimuth_mode="rotating", sectors__enabled=True)
    sectors = last(tally).sectors
    assert sectors is not None
    assert any(sectors.crossing)
    values = health_of(tally, settings, VESSEL).values
    assert values["sub_problem"] == sectors.sub_problem
    crossing = [name for name, way in zip(VESSEL.thruster_names, sectors.crossing, strict=True) if way]
    assert str(values["crossing"]).split() == crossing


def test_avoidance_says_insufficient_gain_and_locking() -> None:
    tally, settings = run((6.0, 0.0, 0.0), 12, azimuth_mode="rotating", singularity__method="three_step")
    report = last(tally).avoidance
    assert report is not None
    health = health_of(tally, settings, VESSEL)
    assert health.level is Level.OK
    assert (health.values["gain_limit"], health.values["avoidance_locked"]) == (report.threshold, False)

    def told(**changes: Any) -> Health:
        other = Tally()
        assert report is not None
        other.add(replace(last(tally), avoidance=report._replace(**changes)), settings.solver, 0.2)
        return health_of(other, settings, VESSEL)

    assert told(minimum_gain=report.threshold).level is Level.OK
    health = told(minimum_gain=0.2)
    assert (health.level, health.message) == (Level.WARN, "minimum gain below the limit: 0.2 of 0.5")
    assert codes(health) == ["ALLOCATOR-GAIN-LOW"]
    assert told(minimum_gain=0.2, crossing=True).message.endswith("below the limit: 0.2 of 0.5, on the way through")
    health = told(locked=True, cost_free=10.0, cost_kept=500.0)
    assert (health.level, health.message) == (
        Level.WARN,
        "singularity avoidance is locked: angles of cost 10 are known, these cost 500",
    )
    assert codes(health) == ["ALLOCATOR-AVOIDANCE-LOCKED"]
    # Where no thruster can turn there is no gain to speak of.
    assert told(method="none", minimum_gain=math.nan, threshold=0.0).level is Level.OK


def test_without_avoidance_a_small_gain_is_no_warning() -> None:
    """The optimum of a demand ahead has all thrusters ahead."""
    tally, settings = run((6.0, 0.0, 0.0), 20, azimuth_mode="rotating")
    assert last(tally).gain_both_ways.gain < 0.5
    assert health_of(tally, settings, VESSEL).level is Level.OK


def test_a_configuration_without_force_in_a_direction_is_singular() -> None:
    """Without the tunnel thruster, and all others ahead, nothing pushes sideways."""
    tunnel = [not isinstance(thruster, TunnelThruster) for thruster in VESSEL.thrusters]
    tally, settings = run((6.0, 0.0, 0.0), 60, azimuth_mode="rotating", thruster_enabled=tunnel)
    for expected in ([], [], ["ALLOCATOR-SINGULAR"], ["ALLOCATOR-SINGULAR"]):  # from the third report on
        assert codes(health_of(tally, settings, VESSEL)) == ["ALLOCATOR-THRUSTERS-DISABLED", *expected]
        tally.reported()
        tally.add(last(tally), settings.solver, 0.2)
    tally.add(last(run((0.0, 4.0, 0.0), 60, azimuth_mode="rotating", thruster_enabled=tunnel)[0]), settings.solver, 0.2)
    assert codes(health_of(tally, settings, VESSEL)) == ["ALLOCATOR-THRUSTERS-DISABLED"]


def test_an_answer_of_another_solver_without_shared_limits_is_a_fall_back() -> None:
    tally, settings = run()
    tally.add(replace(last(tally), solver="daqp"), settings.solver, 0.2)
    health = health_of(tally, settings, VESSEL)
    assert (codes(health), health.level) == (["ALLOCATOR-SOLVER-FELL-BACK"], Level.WARN)
    assert health.message.endswith("1 of the last 2")
    tally.reported()
    tally.add(last(run()[0]), settings.solver, 0.2)
    assert codes(health_of(tally, settings, VESSEL)) == []


def test_thrust_at_its_limit_is_told_once_it_has_lasted() -> None:
    """50 samples: the thrusters have come to their limits by then, and one sample inside begins the count anew."""
    sample = VESSEL.measurement.sample_time
    tally, settings = run()
    at_limit = replace(last(run((60.0, 0.0, 0.0), 60)[0]))
    assert any(at_limit.thrust_saturated)
    names = [name for name, at in zip(VESSEL.thruster_names, at_limit.thrust_saturated, strict=True) if at]
    for _ in range(49):
        tally.add(at_limit, settings.solver, sample)
    assert "ALLOCATOR-THRUST-SATURATED" not in codes(health_of(tally, settings, VESSEL))
    tally.add(at_limit, settings.solver, sample)
    health = health_of(tally, settings, VESSEL)
    told = [a.detail for a in health.alarms if a.kind.code == "ALLOCATOR-THRUST-SATURATED"]
    assert told == [f"{name} for {50 * sample:.0f} s" for name in names]
    tally.add(last(run()[0]), settings.solver, sample)
    assert "ALLOCATOR-THRUST-SATURATED" not in codes(health_of(tally, settings, VESSEL))


def test_stale_ventilation_with_antispin_is_told() -> None:
    tally, settings = run(antispin__enabled=True)
    assert not last(tally).ventilation_known
    health = health_of(tally, settings, VESSEL)
    assert codes(health) == ["ALLOCATOR-VENTILATION-STALE"]
    assert health.message == "no ventilation: torque losses are being forgotten: none in the last 1 s"
