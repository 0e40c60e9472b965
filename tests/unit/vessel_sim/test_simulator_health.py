"""What the simulator's node says of itself, from how time goes."""

from __future__ import annotations

from dataclasses import replace

from dp_node import Health, Level
from vessel_sim.node_health import SimulatorState, health_of

WELL = SimulatorState(
    now=12.0,
    phase="waiting for its time",
    rate=2.0,
    achieved=2.0,
    paced=True,
    held=False,
    overdue="",
    forgiven=0.0,
    poses=60,
    poses_lost=0,
    fresh_poses=10,
    fresh_lost=0,
    setpoint_age=0.02,
    setpoint_limit=1.0,
)


def codes(health: Health) -> list[str]:
    return [alarm.kind.code for alarm in health.alarms]


def test_all_is_well() -> None:
    health = health_of(WELL)
    assert (health.level, health.message, health.alarms) == (Level.OK, "nominal", ())
    assert (health.values["simulated_time"], health.values["rate_achieved"]) == ("12.000", 2.0)
    assert "time_not_kept_up_with" not in health.values
    assert "rate_achieved" not in health_of(replace(WELL, achieved=None)).values
    assert health_of(replace(WELL, held=True, phase="held")).message == "held"


def test_a_rate_below_the_asked_one_is_told_while_the_clock_sets_the_pace() -> None:
    assert codes(health_of(replace(WELL, achieved=1.91))) == []
    health = health_of(replace(WELL, achieved=1.89, forgiven=0.7))
    assert (codes(health), health.level) == (["SIMULATOR-CANNOT-KEEP-UP"], Level.WARN)
    assert health.message == "cannot keep up: 1.89 simulated seconds a second, asked 2"
    assert health.values["time_not_kept_up_with"] == 0.7
    assert codes(health_of(replace(WELL, achieved=0.1, paced=False))) == []


def test_lockstep_that_waits_too_long_is_an_error() -> None:
    health = health_of(replace(WELL, overdue="nobody publishes odometry", paced=False))
    assert (codes(health), health.level) == (["SIMULATOR-LOCKSTEP-OVERDUE"], Level.ERROR)
    assert health.message == "lockstep stands still: nobody publishes odometry"


def test_a_set_point_that_is_old_is_told() -> None:
    assert codes(health_of(replace(WELL, setpoint_age=1.0))) == []
    assert codes(health_of(replace(WELL, setpoint_age=1.5))) == ["SIMULATOR-NO-SETPOINT"]


def test_lost_measurements_are_told() -> None:
    health = health_of(replace(WELL, poses_lost=9, fresh_lost=2))
    assert codes(health) == ["SIMULATOR-POSES-LOST"]
    assert health.message.endswith("2 of the last 10")
    assert codes(health_of(replace(WELL, poses_lost=9))) == []
