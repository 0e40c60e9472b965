"""What the drivers' node says of itself, from what it has done."""

from __future__ import annotations

import math

import pytest

from dp_node import Health, Level
from thruster_drivers.drivers import COMMAND_STALE, NO_COMMAND, NOMINAL, SENSOR_LOST, SPEED_LOST
from thruster_drivers.node_health import Tally, health_of

NAMES = ("bow", "port", "starboard")


def said(tally: Tally) -> Health:
    return health_of(tally, "power", NAMES, None)


def codes(health: Health) -> list[str]:
    return [alarm.kind.code for alarm in health.alarms]


def test_all_is_well() -> None:
    tally = Tally(status=NOMINAL, command_age=0.1, commands=3, feedback=30)
    health = health_of(tally, "power", NAMES, [0, 2, 0])
    assert (health.level, health.message, health.alarms) == (Level.OK, "nominal", ())
    assert (health.values["controller"], health.values["ventilation_events.port"]) == ("power", 2)


@pytest.mark.parametrize(
    ("status", "code", "level"),
    [
        (NO_COMMAND, "DRIVERS-NO-COMMAND", Level.WARN),
        (COMMAND_STALE, "DRIVERS-COMMAND-STALE", Level.WARN),
        (SENSOR_LOST, "DRIVERS-SENSOR-LOST", Level.ERROR),
        (SPEED_LOST, "DRIVERS-SPEED-LOST", Level.WARN),
    ],
)
def test_every_safe_state_is_an_alarm(status: str, code: str, level: Level) -> None:
    health = said(Tally(status=status, command_age=math.inf, feedback=1))
    assert (codes(health), health.level) == ([code], level)


def test_no_feedback_since_the_last_report_hides_a_status_that_is_old() -> None:
    tally = Tally(status=COMMAND_STALE, feedback=7)
    tally.reported()
    assert codes(said(tally)) == ["DRIVERS-NO-FEEDBACK"]
    tally.feedback += 1
    assert codes(said(tally)) == ["DRIVERS-COMMAND-STALE"]


def test_clipped_commands_and_ventilation_are_told_for_one_report() -> None:
    tally = Tally(status=NOMINAL, feedback=1, clipped=2, last_clipped=("bow", "port"))
    tally.ventilated.update({"starboard", "bow"})
    health = said(tally)
    assert codes(health) == ["DRIVERS-COMMAND-CLIPPED", "DRIVERS-VENTILATION"]
    assert [alarm.detail for alarm in health.alarms] == ["2 times, bow, port last", "bow, starboard"]
    tally.reported()
    tally.feedback += 1
    assert said(tally).alarms == ()


def test_a_clamped_speed_is_counted_and_told_where_it_matters() -> None:
    tally = Tally(status=NOMINAL, feedback=1)
    for beyond in (0.0, -0.04, 0.05):
        tally.clamped(beyond)
    health = health_of(tally, "code_map", NAMES, None, 0.1)
    assert health.alarms == ()  # noise of an estimate near the end of a table
    assert (health.values["speed_clamped"], health.values["speed_age_s"]) == (2, 0.1)
    for beyond in (-0.3, 0.2):
        tally.clamped(beyond)
    health = health_of(tally, "code_map", NAMES, None, 0.1)
    assert (codes(health), health.alarms[0].detail) == (["DRIVERS-SPEED-CLAMPED"], "by up to 0.3 m/s")
    tally.reported()
    tally.feedback += 1
    health = health_of(tally, "code_map", NAMES, None, 0.1)
    assert (health.alarms, health.values["speed_clamped"]) == ((), 4)
    assert "speed_clamped" not in said(tally).values  # no law looks at it


def test_a_feedback_that_waits_is_told_instead_of_none() -> None:
    health = health_of(Tally(status=NOMINAL), "code_map", NAMES, None, 0.1, "odometry, which nobody publishes")
    assert codes(health) == ["DRIVERS-WAITS"]
    assert health.message == "thruster_feedback waits for an input: odometry, which nobody publishes"
