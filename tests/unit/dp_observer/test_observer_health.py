"""What the observer's node says of itself, from what it has done."""

from __future__ import annotations

import pytest

from dp_node import Health, Level
from dp_observer.estimate import ObserverStatus
from dp_observer.node_health import Tally, health_of, status_text

LIMIT = 1.0  # s, age of tau_achieved


def sailed(**changes: object) -> Tally:
    tally = Tally(poses=5, status=ObserverStatus.NOMINAL)
    for name, value in changes.items():
        setattr(tally, name, value)
    return tally


def codes(health: Health) -> list[str]:
    return [alarm.kind.code for alarm in health.alarms]


def test_all_is_well() -> None:
    health = health_of(sailed(force_age=0.2, time_since_measurement=0.0), LIMIT)
    assert (health.level, health.message, health.alarms) == (Level.OK, "nominal", ())
    assert (health.values["status"], health.values["poses"]) == ("nominal", 5)
    assert health_of(sailed(status=ObserverStatus.INITIALISED), LIMIT).message == "first position fix"


@pytest.mark.parametrize(
    ("status", "code", "level"),
    [
        (ObserverStatus.UNINITIALISED, "OBSERVER-NO-FIX-YET", Level.WARN),
        (ObserverStatus.DEAD_RECKONING, "OBSERVER-DEAD-RECKONING", Level.WARN),
        (ObserverStatus.OUTLIER_REFUSED, "OBSERVER-FIX-REFUSED", Level.WARN),
        (ObserverStatus.INVALID, "OBSERVER-ESTIMATE-INVALID", Level.ERROR),
        (ObserverStatus.REINITIALISED, "OBSERVER-REINITIALISED", Level.WARN),
    ],
)
def test_every_status_but_the_good_ones_is_an_alarm(status: ObserverStatus, code: str, level: Level) -> None:
    health = health_of(sailed(status=status), LIMIT)
    assert (codes(health), health.level) == ([code], level)
    assert health.message == status_text(status)


def test_every_status_is_known() -> None:
    calm = {status for status in ObserverStatus if not codes(health_of(sailed(status=status), LIMIT))}
    assert calm == {ObserverStatus.NOMINAL, ObserverStatus.INITIALISED}


def test_no_pose_since_the_last_report() -> None:
    tally = sailed()
    tally.reported()
    assert codes(health_of(tally, LIMIT)) == ["OBSERVER-NO-POSE"]
    tally.poses += 1
    assert codes(health_of(tally, LIMIT)) == []


def test_measurements_that_are_missing_are_told_once() -> None:
    tally = sailed(without_fix=2, outliers=1, late=3, ahead=4)
    health = health_of(tally, LIMIT)
    assert codes(health) == ["OBSERVER-MEASUREMENTS-LOST"]
    assert health.message.endswith("2 without fix, 1 refused as outliers, 3 late, 4 made up for, beside 5 poses")
    tally.reported()
    tally.poses += 5
    assert codes(health_of(tally, LIMIT)) == []


def test_a_position_set_anew_between_two_reports_is_told() -> None:
    tally = sailed()
    tally.estimated(ObserverStatus.REINITIALISED, 0.0)
    tally.estimated(ObserverStatus.NOMINAL, 0.0)
    assert codes(health_of(tally, LIMIT)) == ["OBSERVER-REINITIALISED"]
    tally.reported()
    tally.poses += 1
    assert codes(health_of(tally, LIMIT)) == []


def test_thrust_that_is_not_told_is_taken_for_none() -> None:
    assert codes(health_of(sailed(force_age=LIMIT), LIMIT)) == []
    health = health_of(sailed(force_age=1.4), LIMIT)
    assert (codes(health), health.level) == (["OBSERVER-NO-TAU-ACHIEVED"], Level.WARN)
    assert health.message == "no tau_achieved: the estimate knows of no thrust: for 1.4 s"


def test_a_fix_that_stands_still_is_told_while_poses_come() -> None:
    health = health_of(sailed(equal_fixes=12, frozen=True), LIMIT)
    assert codes(health) == ["OBSERVER-FIX-FROZEN"]
    assert health.alarms[0].detail == "12 times the same"
    assert health.values["equal_fixes"] == 12
    assert codes(health_of(sailed(poses=0, equal_fixes=12, frozen=True), LIMIT)) == ["OBSERVER-NO-POSE"]
