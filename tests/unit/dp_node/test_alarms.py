"""The table of alarms, and alarms on /diagnostics."""

from __future__ import annotations

import re

import pytest

from dp_node import ALARMS, Health, Level, health_with, raised
from dp_node.health import to_status
from marine_model.errors import InputError

STALE, FULL = raised("DRIVERS-COMMAND-STALE"), raised("RECORDER-DISK-FULL", "12 messages are missing")


def test_codes_are_upper_case_words_under_the_name_of_who_raises_them() -> None:
    who = {"NODE", "OBSERVER", "CONTROLLER", "ALLOCATOR", "DRIVERS", "SIMULATOR", "RECORDER", "SUPERVISOR"}
    for code, kind in ALARMS.items():
        assert kind.code == code
        assert re.fullmatch(r"[A-Z]+(-[A-Z]+)+", code)
        assert code.partition("-")[0] in who
        assert kind.level in (Level.WARN, Level.ERROR)
        assert kind.text
        assert kind.advice.endswith(".")


def test_an_unknown_code_is_refused() -> None:
    with pytest.raises(InputError, match=r"expected a code of dp_node\.alarms, found 'DRIVERS-TIRED'"):
        raised("DRIVERS-TIRED")


def test_health_with_alarms_has_the_worst_level_and_all_texts() -> None:
    health = health_with([STALE, FULL], {"count": 3})
    assert health.level is Level.ERROR
    assert health.message == f"{STALE.kind.text}; the disk is full: recording has stopped: 12 messages are missing"
    assert (health.alarms, health.values) == ((STALE, FULL), {"count": 3})
    assert health_with([], calm="held") == Health(Level.OK, "held")


def test_the_worse_of_two_keeps_the_alarms_of_both_once() -> None:
    both = health_with([STALE]).worse_of(health_with([FULL, STALE]))
    assert both.alarms == (STALE, FULL)
    assert both.level is Level.ERROR


def test_active_alarms_are_key_values() -> None:
    other = raised("RECORDER-DISK-FULL", "on another disk")
    status = to_status("x", health_with([STALE, FULL, other], {"bytes": 2.0}))
    assert {v.key: v.value for v in status.values} == {
        "bytes": "2",
        "alarm.DRIVERS-COMMAND-STALE": STALE.text,
        "alarm.RECORDER-DISK-FULL": f"{FULL.text}; {other.text}",
    }
