"""The report page: complete, self-contained, and honest about what is missing."""

from __future__ import annotations

import base64
import dataclasses
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from dp_tools.quantities import number, with_unit
from dp_tools.report.page import write_report
from dp_tools.report.panels import Panels
from dp_tools.report.picture import write_picture
from dp_tools.report.thinning import break_turns, thin
from dp_tools.run_data import RunData, RunInfo, Series
from dp_tools.scenario import Scenario, free_run, load_scenario
from marine_model import Vessel, load_vessel
from marine_model.errors import DocumentError
from support.repository import SCENARIOS
from support.synthetic_run import synthetic_run


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load_scenario(SCENARIOS / "run_a.yaml")


@pytest.fixture(scope="module")
def run(vessel: Vessel) -> RunData:
    return synthetic_run(vessel)


@pytest.fixture(scope="module")
def page(run: RunData, scenario: Scenario, vessel: Vessel, tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("report")
    path = write_report(run, scenario, vessel, folder)
    assert path == folder / "report.html"
    assert (folder / "figures.json").is_file()
    return path.read_text(encoding="utf-8")


class Page(HTMLParser):
    """Collects references, text and open tags."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.references: list[str] = []
        self.images: list[str] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "img", "link", "br"):
            self.open.append(tag)
        for name, value in attrs:
            if name in ("src", "href") and value:
                (self.images if tag == "img" else self.references).append(value)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] != "style":
            self.text += data


def test_page_needs_nothing_outside_itself(page: str) -> None:
    parsed = Page(page)
    assert parsed.open == []
    assert all(reference.startswith("#") for reference in parsed.references)
    assert all(image.startswith("data:image/svg+xml;base64,") for image in parsed.images)
    assert "<script" not in page
    assert "url(" not in page
    assert "@import" not in page


def test_every_link_has_its_target(page: str) -> None:
    for reference in Page(page).references:
        assert f'id="{reference.removeprefix("#")}"' in page


def test_pictures_are_those_of_the_thesis(page: str, scenario: Scenario) -> None:
    text = Page(page).text
    for title in (
        "Position and heading",
        "Power",
        "Generalized forces",
        "Thrust directions",
        "Thruster forces",
        "Ventilation: torque loss factors",
        "Observer: wave filter and bias",
        "The switch from fixed to rotating thrusters",
    ):
        assert title in text
    # Nine of the whole run, five of the close-up, and those that the scenario asks for.
    assert len(Page(page).images) == 14 + len(scenario.plots)


def test_pictures_are_drawings_without_outside_references(page: str) -> None:
    for image in Page(page).images:
        svg = base64.b64decode(image.partition(",")[2]).decode("utf-8")
        assert "<svg" in svg
        outside = re.findall(r'(?:href|src)="(?!#)([^"]*)"', svg)
        assert outside == []


def test_table_has_ours_beside_the_thesis(page: str, scenario: Scenario) -> None:
    text = Page(page).text
    for spec in scenario.figures:
        assert spec.title in text
    assert "−44.0 %" in text
    assert scenario.figures[0].reason in text
    assert "at most 12.04 deg: held" in text
    assert "Held: no violation in" in text


def test_quantities_are_told_in_the_reader_s_units(
    run: RunData, scenario: Scenario, vessel: Vessel, tmp_path: Path
) -> None:
    """A share in per cent, and a limit without zeros that nobody gave."""
    figures: list[dict[str, Any]] = [
        {
            "name": "share",
            "kind": "ventilating_share",
            "title": "Share",
            "window": "all",
            "thruster": vessel.thruster_names[2],
        },
        {"name": "deviation", "kind": "force_deviation", "title": "Deviation", "window": "all", "axis": "surge"}
        | {"at_most": 0.05},
    ]
    changed = scenario.model_dump(mode="json") | {"figures": figures, "close_ups": [], "plots": []}
    changed["windows"] = {"all": [0.0, 100.0]}
    page = write_report(run, Scenario.model_validate(changed), vessel, tmp_path).read_text(encoding="utf-8")
    text = Page(page).text
    assert "10.0 %" in text  # one second in ten
    assert "at most 0.05 N" in text


def test_flags_of_ventilation_are_bars_at_the_foot(scenario: Scenario) -> None:
    panels = Panels(("one", "two"), scenario, (2.0, 6.0))
    t = np.arange(0.0, 10.0, 0.5)
    flags = np.isin(t, [0.5, 3.0, 3.5, 5.0, 9.5])
    panels.stretches(0, t, flags, "flagged", "red")
    panels.stretches(1, t, np.zeros_like(flags), "flagged", "red")
    (bars,) = panels.axes[0].collections
    # Those in view, each to the first sample without a flag.
    spans = [path.get_extents().intervalx.tolist() for path in bars.get_paths()]
    assert spans == [[3.0, 4.0], [5.0, 5.5]]
    assert not panels.axes[1].collections


def test_same_run_gives_the_same_page(
    page: str, run: RunData, scenario: Scenario, vessel: Vessel, tmp_path: Path
) -> None:
    assert write_report(run, scenario, vessel, tmp_path).read_text(encoding="utf-8") == page


def test_broken_limit_is_shown(run: RunData, scenario: Scenario, vessel: Vessel, tmp_path: Path) -> None:
    values = run["thrust_command"].values.copy()
    values[500, 1] = 9.0
    series = {**run.series, "thrust_command": Series(run["thrust_command"].t, values)}
    text = Page(
        write_report(dataclasses.replace(run, series=series), scenario, vessel, tmp_path).read_text(encoding="utf-8")
    ).text
    # One thrust outside, and the steps to it and back are too fast.
    assert "Broken: 3 violations in" in text
    assert "first at 100.0 s" in text
    assert "at most 0: broken" in text


def test_run_with_few_signals_still_has_a_page(run: RunData, vessel: Vessel, tmp_path: Path) -> None:
    names = ("estimate_position", "tau_desired", "tau_achieved")
    bare = dataclasses.replace(run, series={name: run[name] for name in names}, labels={})
    page = write_report(bare, free_run(vessel.name, 380.0), vessel, tmp_path).read_text(encoding="utf-8")
    parsed = Page(page)
    assert len(parsed.images) == 3
    assert "Thruster limits" not in parsed.text
    assert "Figures of merit" not in parsed.text


def test_text_of_a_scenario_is_text_not_markup(run: RunData, vessel: Vessel, tmp_path: Path) -> None:
    scenario = free_run(vessel.name, 380.0).model_copy(
        update={"title": "<b>&</b>", "description": "<script>x</script>"}
    )
    bare = dataclasses.replace(run, series={"estimate_position": run["estimate_position"]})
    page = write_report(bare, scenario, vessel, tmp_path).read_text(encoding="utf-8")
    assert "<script" not in page
    assert "<b>&</b>" in Page(page).text


def test_picture_for_a_readme(run: RunData, scenario: Scenario, vessel: Vessel, tmp_path: Path) -> None:
    path = write_picture(run, scenario, vessel, tmp_path / "images" / "run.png")
    assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (12.345, "12.3"), (-0.0012345, "−0.00123"), (1234.5, "1234"), (1e-7, "1.00e−07"), (2.5e7, "2.50e+07")],
)
def test_numbers(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [(0.0071, "m", "7.10 mm"), (0.71, "m", "0.710 m"), (0.0, "m", "0 m"), (3.0, "1", "3.00"), (3.0, "N m", "3.00 N m")],
)
def test_quantities(value: float, unit: str, text: str) -> None:
    assert with_unit(value, unit) == text


@given(arrays(np.float64, st.integers(1, 3000), elements=st.floats(-1e6, 1e6)), st.integers(4, 500))
@settings(max_examples=60, deadline=None)
def test_thinning_keeps_ends_and_extremes(values: np.ndarray, points: int) -> None:
    t = np.arange(len(values)) * 0.02
    thin_t, thin_values = thin(t, values, points)
    assert len(thin_t) <= max(points + 2, min(len(t), points + 2))
    assert thin_t[0] == t[0]
    assert thin_t[-1] == t[-1]
    assert (np.diff(thin_t) > 0.0).all()
    assert thin_values.min() == values.min()
    assert thin_values.max() == values.max()
    assert np.isin(thin_t, t).all()


def test_thinning_keeps_gaps() -> None:
    values = np.ones(1000)
    values[500] = np.nan
    assert np.isnan(thin(np.arange(1000.0), values, 100)[1]).sum() == 1


def test_turns_break_the_line() -> None:
    assert np.isnan(break_turns(np.array([170.0, 179.0, -179.0, -170.0]))).tolist() == [False, False, True, False]


def test_run_info_survives_its_file(tmp_path: Path) -> None:
    info = RunInfo("run_a", "cybership3", "in process", 3, {"numpy": "2"}, "2026-01-01T00:00:00+00:00", 380.0, 2.0)
    info.write(tmp_path / "run.json")
    assert RunInfo.read(tmp_path / "run.json") == info
    assert info.real_time_factor == 190.0
    assert dataclasses.replace(info, wall_time=0.0).real_time_factor is None
    (tmp_path / "run.json").write_text('{"colour": "red"}', encoding="utf-8")
    with pytest.raises(DocumentError, match="expected the fields of a run"):
        RunInfo.read(tmp_path / "run.json")
    with pytest.raises(DocumentError, match="cannot be read"):
        RunInfo.read(tmp_path / "none.json")
