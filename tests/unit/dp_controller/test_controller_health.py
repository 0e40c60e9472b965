"""What the controller's node says of itself, from what it has done."""

from __future__ import annotations

import pytest

from dp_controller.node_health import Tally, health_of
from dp_controller.settings import ControllerSettings
from dp_node import Health, Level

SETTINGS = ControllerSettings(mode="setpoint")


def sailed(status: str = "nominal", error: tuple[float, float, float] = (0.0, 0.0, 0.0), samples: int = 5) -> Tally:
    tally = Tally()
    for _ in range(samples):
        tally.acted(status, error)
    return tally


def codes(health: Health) -> list[str]:
    return [alarm.kind.code for alarm in health.alarms]


def test_all_is_well() -> None:
    health = health_of(sailed(error=(0.3, 0.4, 0.1)), SETTINGS)
    assert (health.level, health.message, health.alarms) == (Level.OK, "nominal", ())
    assert (health.values["mode"], health.values["samples"]) == ("setpoint", 5)
    assert (health.values["position_error_m"], health.values["heading_error_rad"]) == (0.5, 0.1)


@pytest.mark.parametrize(
    ("status", "code", "level"),
    [
        ("observer_invalid", "CONTROLLER-OBSERVER-INVALID", Level.ERROR),
        ("estimate_late", "CONTROLLER-ESTIMATE-LATE", Level.WARN),
        ("joystick_stale", "CONTROLLER-JOYSTICK-STALE", Level.WARN),
        ("path_missing", "CONTROLLER-PATH-MISSING", Level.WARN),
        ("wind_stale", "CONTROLLER-WIND-STALE", Level.WARN),
    ],
)
def test_every_safe_state_is_an_alarm(status: str, code: str, level: Level) -> None:
    health = health_of(sailed(status), SETTINGS)
    assert (codes(health), health.level) == ([code], level)


def test_safe_states_together_are_all_told() -> None:
    health = health_of(sailed("observer_invalid,wind_stale"), SETTINGS)
    assert codes(health) == ["CONTROLLER-OBSERVER-INVALID", "CONTROLLER-WIND-STALE"]
    assert health.level is Level.ERROR


def test_a_late_sample_between_two_reports_is_told() -> None:
    tally = sailed("estimate_late")
    tally.acted("nominal", (0.0, 0.0, 0.0))
    assert codes(health_of(tally, SETTINGS)) == ["CONTROLLER-ESTIMATE-LATE"]
    tally.reported()
    tally.acted("nominal", (0.0, 0.0, 0.0))
    assert codes(health_of(tally, SETTINGS)) == []


def test_no_odometry_since_the_last_report_and_odometry_that_waits() -> None:
    tally = sailed()
    tally.reported()
    assert codes(health_of(tally, SETTINGS)) == ["CONTROLLER-NO-ODOMETRY"]
    health = health_of(tally, SETTINGS, "wind, which nobody publishes")
    assert codes(health) == ["CONTROLLER-WAITS"]
    assert health.message == "odometry waits for an input: wind, which nobody publishes"


def test_no_answer_of_the_allocator_to_any_sample_is_told() -> None:
    tally = sailed()
    tally.unanswered = 4
    assert codes(health_of(tally, SETTINGS)) == [], "now and then one is late, in real time"
    tally.unanswered = 5
    assert codes(health_of(tally, SETTINGS)) == ["CONTROLLER-NO-TAU-ACHIEVED"]


def test_errors_beyond_their_limit_are_told_where_there_is_one() -> None:
    far = sailed(error=(3.0, -4.0, -0.2))
    assert codes(health_of(far, SETTINGS)) == []
    health = health_of(far, SETTINGS.model_copy(update={"position_alarm": 4.9, "heading_alarm": 0.19}))
    assert codes(health) == ["CONTROLLER-POSITION-ERROR", "CONTROLLER-HEADING-ERROR"]
    assert health.message == (
        "position error above position_alarm: 5 m of 4.9 m; heading error above heading_alarm: 0.2 rad of 0.19 rad"
    )
    assert codes(health_of(far, SETTINGS.model_copy(update={"position_alarm": 5.1, "heading_alarm": 0.21}))) == []
