"""What `dp status` knows and shows, from messages alone."""

from __future__ import annotations

import io
import json
import math
from typing import Any

import pytest
from rich.console import Console

from dp_node import Level, health_with, raised
from dp_tools.status.alarm_log import AlarmLog
from dp_tools.status.bars import share_bar, thrust_bar
from dp_tools.status.document import to_document
from dp_tools.status.rate import Meter
from dp_tools.status.screen import fitting_height, render
from dp_tools.status.state import StatusState
from dp_tools.status.watch_circle import watch_circle
from marine_model import load_vessel
from marine_model.frames import attitude_to_quaternion
from support.status_messages import GRAPH, VESSEL, allocation_status, diagnostics, healthy, odometry, under_way

NOW = 1000.0


def screen(state: StatusState, now: float = NOW, width: int = 80, height: int = 24) -> list[str]:
    """The lines of the screen as a terminal of this size would show them."""
    console = Console(file=io.StringIO(), width=width, height=height, force_terminal=False)
    console.print(render(state, now, width, height), height=height)
    written = console.file
    assert isinstance(written, io.StringIO)
    return written.getvalue().splitlines()


def text(state: StatusState, now: float = NOW, width: int = 80, height: int = 24) -> str:
    return "\n".join(screen(state, now, width, height))


def line_of(state: StatusState, word: str, now: float = NOW, **size: int) -> str:
    return next(line for line in screen(state, now, **size) if word in line)


# The screen -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("width", "height"), [(80, 24), (100, 30), (132, 43), (200, 60)])
def test_the_screen_fills_the_terminal_and_no_more(width: int, height: int) -> None:
    lines = screen(under_way(), width=width, height=height)
    assert len(lines) == height
    assert max(len(line.rstrip()) for line in lines) <= width


def test_a_smaller_terminal_gets_the_upper_left_part() -> None:
    assert screen(under_way(), width=40, height=10)[0].startswith(" DP  /  cybership3")


def test_everything_of_a_graph_under_way_is_on_eighty_by_twenty_four() -> None:
    lines = screen(under_way())
    assert "cybership3  120.0 s ×2" in lines[0]
    assert "recording 4.3 MB" in lines[0]
    assert "2 alarms" in lines[0]
    shown = "\n".join(lines)
    for said in (
        "N 0.130  E -0.080 m  20.1°",
        "N 0.200  E -0.200 m  17.2°",
        "0.133 m  -2.9°",
        "0.021  -0.004 m/s  0.6°/s",
        "4.12 m/s from 14° starboard",
        "optimal, rotating",
        "2.9 of 3.1 W",
        "4.2 -1.1 0.30",
        "0.42 (0.77)",
    ):
        assert said in shown
    state = under_way()
    assert line_of(state, "tunnel_bow").split()[-2:] == ["at", "limit"]
    assert line_of(state, "azimuth_port").split()[-1] == "air"
    assert line_of(state, "azimuth_starboard ").split()[-1] == "disabled"
    assert line_of(state, "● dp_observer").split()[:4] == ["●", "dp_observer", "10/s", "nominal"]
    assert line_of(state, "▲ thruster_drivers").split()[1:4] == ["thruster_drivers", "110/s", "alarm"]


def test_alarms_are_newest_first_with_advice_and_what_does_not_fit_is_counted() -> None:
    shown = text(under_way())
    first, second = shown.index("ALLOCATOR-THRUSTERS-DISABLED  0 s"), shown.index("DRIVERS-VENTILATION  5 s")
    assert first < second
    assert "→ Mind the smaller margin" in shown
    assert "… and 1 more" in shown
    tall = text(under_way(), height=40)
    assert "✓ OBSERVER-MEASUREMENTS-LOST  over for 7 s" in tall
    assert "more" not in tall


def test_nothing_is_left_out_at_the_fitting_height() -> None:
    state = under_way()
    height = fitting_height(state, NOW, 80)
    assert "✓ OBSERVER-MEASUREMENTS-LOST" in text(state, height=height)
    assert "more" not in text(state, height=height)


def test_an_empty_state_is_shown_as_such() -> None:
    shown = text(StatusState("/ship"))
    assert " DP  /ship" in shown
    assert "no alarms" in shown
    assert "not recording" in shown
    assert "no thruster_command" in shown
    assert all(f"○ {name}" in shown for name in GRAPH)


def test_nodes_that_fall_silent_and_come_back() -> None:
    state = under_way()
    assert "silent" not in text(state, NOW + 2.9)
    later = line_of(state, "✕ dp_observer", NOW + 3.2)
    assert later.split()[1:5] == ["dp_observer", "silent", "3.2", "s"]
    assert "no data for 3.2 s" in line_of(state, "✕ dp_observer", NOW + 3.2, width=140)
    assert "Vessel" in line_of(state, "no data for 3.2 s", NOW + 3.2)
    assert line_of(state, "no data for 3.2 s", NOW + 3.2, width=100).count("no data for 3.2 s") == 2
    assert "6 nodes silent" in screen(state, NOW + 3.2)[0]
    assert "not recording" in text(state, NOW + 3.2)
    state.update("/diagnostics", diagnostics(NOW + 4.0, "dp_observer", healthy()), NOW + 4.0)
    assert "● dp_observer" in text(state, NOW + 4.1)


def test_numbers_that_are_not_there_or_not_finite_do_not_stop_the_screen() -> None:
    state = under_way()
    state.update("allocation_status", allocation_status(121.0, math.inf, math.inf, minimum_gain=math.nan), NOW)
    state.update("odometry", odometry(121.0, valid=False), NOW)
    shown = text(state)
    assert "∞" in shown
    assert "invalid" in line_of(state, "position")
    state.update("allocation_status", allocation_status(122.0, 0.0, 0.0, commanded_power=math.nan), NOW)
    state.update("odometry", odometry(122.0, north=math.inf, east=math.nan), NOW)
    assert "nan" in line_of(state, "position")


def test_a_recorder_that_has_stopped_or_lost_messages_is_seen_in_the_first_line() -> None:
    state = under_way()
    values: dict[str, object] = {"messages": 5, "bytes": 1_000_000, "lost": 7}
    lost = health_with([raised("RECORDER-MESSAGES-LOST", "7")], values)
    state.update("/diagnostics", diagnostics(NOW + 1.0, "recorder", lost), NOW)
    assert "recording 1.0 MB, 7 lost" in screen(state)[0]
    full = health_with([raised("RECORDER-DISK-FULL")], values)
    state.update("/diagnostics", diagnostics(NOW + 2.0, "recorder", full), NOW)
    assert "recording stopped" in screen(state)[0]


# What it is made of ---------------------------------------------------------------------------------------------------


def test_reports_of_another_namespace_and_old_ones_are_not_taken() -> None:
    state = StatusState("/fleet/ship")
    state.update("/diagnostics", diagnostics(NOW, "dp_observer", healthy()), NOW)
    state.update("/diagnostics", diagnostics(NOW, "ship/dp_observer", healthy()), NOW)
    assert not state.known
    state.update("/diagnostics", diagnostics(NOW, "fleet/ship/dp_observer", healthy(poses=2)), NOW)
    state.update("/diagnostics", diagnostics(NOW - 1.0, "fleet/ship/dp_observer", healthy(poses=1)), NOW)
    assert state.nodes["dp_observer"].values["poses"] == "2"


def test_an_alarm_lasts_from_its_first_report_to_the_first_without_it() -> None:
    log = AlarmLog()
    log.report("a", {"NODE-NOT-ACTIVE": "inactive"}, 10.0)
    log.report("a", {"NODE-NOT-ACTIVE": "still", "DRIVERS-SENSOR-LOST": "x"}, 12.0)
    log.report("b", {}, 13.0)
    assert [(alarm.code, alarm.since, alarm.text) for alarm in log.active] == [
        ("DRIVERS-SENSOR-LOST", 12.0, "x"),
        ("NODE-NOT-ACTIVE", 10.0, "still"),
    ]
    assert log.active[0].level is Level.ERROR
    log.report("a", {}, 14.0)
    assert log.active == []
    assert [alarm.until for alarm in log.over(20.0)] == [14.0, 14.0]
    assert log.over(75.0) == []
    log.report("a", {"NODE-NOT-ACTIVE": "again"}, 80.0)
    assert [(alarm.since, alarm.until) for alarm in log.active] == [(80.0, None)]


def test_an_alarm_that_was_seen_stays_seen_while_it_lasts() -> None:
    state = under_way()
    state.alarms.acknowledge()
    assert "DRIVERS-VENTILATION  5 s  seen" in text(state)
    assert "→" not in text(state)
    log = state.alarms
    log.report("thruster_drivers", {}, NOW + 1.0)
    log.report("thruster_drivers", {"DRIVERS-VENTILATION": "x"}, NOW + 2.0)
    assert [alarm.acknowledged for alarm in log.active if alarm.code == "DRIVERS-VENTILATION"] == [False]


def test_a_code_that_is_not_in_the_table_is_shown_as_an_error_without_advice() -> None:
    log = AlarmLog()
    log.report("x", {"FOREIGN-THING": "what"}, 1.0)
    assert (log.active[0].level, log.active[0].advice) == (Level.ERROR, "")


def test_rates_are_of_the_last_seconds_and_begin_anew_with_the_count() -> None:
    meter = Meter()
    for k in range(100):
        meter.note(0.1 * k, 5 * k)
        assert (meter.rate is None) == (k < 20)
    assert meter.rate == pytest.approx(50.0)
    for k in range(100):
        meter.note(10.0 + 0.1 * k, 500.0)
    assert meter.rate == 0.0
    meter.note(20.0, 3.0)
    assert meter.rate is None


def test_bars() -> None:
    assert share_bar(0.5, 4, "").plain == "██··"
    assert share_bar(7.0, 4, "").plain == "████"
    assert share_bar(math.nan, 4, "").plain == "····"
    assert thrust_bar(5.0, -4.0, 10.0, 9, "").plain == "····│██··"
    assert thrust_bar(-4.0, -4.0, 10.0, 9, "").plain == "████│····"
    assert thrust_bar(-4.0, 0.0, 10.0, 9, "").plain == "····│····"


@pytest.mark.parametrize(
    ("north", "east", "heading", "arrow", "row", "column"),
    [(0.0, 0.0, 0.0, "↑", 3, 7), (1.0, 0.0, math.pi, "↓", 0, 7), (0.0, -1.0, -0.75 * math.pi, "↙", 3, 0)],
)
def test_the_vessel_is_drawn_where_it_is(
    north: float, east: float, heading: float, arrow: str, row: int, column: int
) -> None:
    picture, radius = watch_circle(north, east, heading)
    assert radius == (1.0 if north or east else 0.1)
    assert picture.plain.splitlines()[row][column] == arrow


def test_a_submerged_vehicle_shows_its_depth_and_the_method_that_divides_its_demands() -> None:
    state = StatusState("/", load_vessel("ukwial"))
    message = odometry(10.0)
    message.pose.pose.position.z = 7.25
    q = message.pose.pose.orientation
    q.x, q.y, q.z, q.w = attitude_to_quaternion(0.02, -0.05, 0.35)
    state.update("odometry", message, NOW)
    divided = allocation_status(10.0, method="pseudo_inverse", feasible_load=1.14)
    state.update("allocation_status", divided, NOW)
    shown = text(state, width=120, height=30)
    assert "7.250 m  roll 1.1°  pitch -2.9°" in shown
    assert "optimal, pseudo_inverse" in shown
    document = to_document(state, NOW)
    assert document["vessel"]["depth"] == 7.25
    assert document["vessel"]["pitch"] == pytest.approx(-0.05, abs=1e-12)
    assert document["margins"]["feasible_load"] == 1.14


def test_the_document_is_json_of_the_same() -> None:
    state = under_way()
    state.update("allocation_status", allocation_status(121.0, math.inf, 2.0), NOW)
    document: dict[str, Any] = json.loads(json.dumps(to_document(state, NOW), allow_nan=False))
    assert document["vessel"]["position"] == pytest.approx([0.13, -0.08, 0.35])
    assert (document["margins"]["margin"], document["margins"]["margin_turned"]) == (None, 2.0)
    assert [row["name"] for row in document["thrusters"]] == list(VESSEL.thruster_names)
    assert [node["name"] for node in document["nodes"]] == [*GRAPH, "recorder"]
    assert document["nodes"][3]["level"] == "WARN"
    assert document["pace"] == pytest.approx(2.0)
    active = [(alarm["code"], alarm["seconds"]) for alarm in document["alarms"] if alarm["active"]]
    assert active == [("ALLOCATOR-THRUSTERS-DISABLED", 0.0), ("DRIVERS-VENTILATION", 5.0)]
    assert json.dumps(to_document(StatusState(), NOW), allow_nan=False)
