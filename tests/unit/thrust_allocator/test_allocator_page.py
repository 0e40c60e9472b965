"""The page of the allocator says what the code declares."""

from __future__ import annotations

import re

from marine_model import load_vessel
from marine_model.settings import parameters_of
from support import parameter_table
from support.repository import MESSAGES, ROOT
from thrust_allocator import AllocatorSettings, Status, solver_names

PAGE = (ROOT / "docs" / "thrust_allocator.md").read_text(encoding="utf-8")


def test_the_table_names_every_parameter_and_no_other() -> None:
    _, _, rest = PAGE.partition(parameter_table.BEGIN)
    rows = rest.partition(parameter_table.END)[0].splitlines()[2:]
    names = [re.match(r"\| `([\w.]+)` \|", row) for row in rows]
    assert all(names)
    found = [match.group(1) for match in names if match]
    assert found == list(parameters_of(AllocatorSettings.for_vessel(load_vessel("cybership3"))))


def test_defaults_ranges_and_units_are_those_of_the_settings() -> None:
    """If not: python tests/support/parameter_table.py"""
    assert parameter_table.page_with(parameter_table.table()) == PAGE


def test_every_field_of_allocation_status_is_on_the_page() -> None:
    definition = (MESSAGES / "msg" / "AllocationStatus.msg").read_text(encoding="utf-8")
    names = re.findall(r"^[\w/]+(?:\[\d*\])? (\w+)", definition, flags=re.MULTILINE)
    section = PAGE.partition("## allocation_status")[2].partition("\n## ")[0]
    assert len(names) > 30
    rows = re.findall(r"^\| (.+?) \|", section, flags=re.MULTILINE)
    told = re.findall(r"`(\w+)`", " ".join(rows))
    assert sorted(told) == sorted(names)


def test_every_status_and_solver_is_on_the_page() -> None:
    assert {name for name in [*Status, *solver_names()] if f"`{name}`" not in PAGE} == set()


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([\w/.]+\.md)\)", PAGE):
        assert (ROOT / "docs" / target).is_file(), target
