"""The table of alarms, and alarms on /diagnostics."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable
from pathlib import Path

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


# Table, page, source and tests ----------------------------------------------------------------------------------------

ROOT = Path(__file__).parents[3]
CODE = re.compile(r"(?:NODE|OBSERVER|CONTROLLER|ALLOCATOR|DRIVERS|SIMULATOR|RECORDER|SUPERVISOR)(?:-[A-Z]+)+")


def codes_in(paths: Iterable[Path]) -> set[str]:
    """Every code that is a string of its own in these files; in a test also behind ``alarm.``."""
    found = set()
    for path in paths:
        for item in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(item, ast.Constant) and isinstance(item.value, str):
                text = item.value.removeprefix("alarm.")
                if CODE.fullmatch(text):
                    found.add(text)
    return found


def test_every_code_is_raised_by_somebody_and_nobody_raises_another() -> None:
    table = ROOT / "src" / "dp_node" / "dp_node" / "alarms.py"
    assert codes_in(path for path in ROOT.glob("src/**/*.py") if path != table) == set(ALARMS)


def test_every_code_is_named_in_a_test() -> None:
    here = Path(__file__)
    assert set(ALARMS) <= codes_in(path for path in ROOT.glob("tests/**/*.py") if path != here)


def test_the_page_holds_the_same_table() -> None:
    page = (ROOT / "docs" / "alarms.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if line.startswith("| `")]
    told = {code.strip("`"): (level, text, advice) for code, level, text, _, advice in rows}
    assert told == {code: (kind.level.name, kind.text, kind.advice) for code, kind in ALARMS.items()}
    assert list(told) == list(ALARMS)
    assert all(when for _, _, _, when, _ in rows)
