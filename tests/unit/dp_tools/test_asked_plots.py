"""Pictures that a scenario asks for beside those of every report."""

from __future__ import annotations

from typing import get_args

import pytest

from dp_tools.plot_specs import PlotSpec
from dp_tools.plot_specs.overlay import Overlay
from dp_tools.report.asked import _DRAWN_BY, asked_pictures
from dp_tools.report.scene import Scene
from dp_tools.report.style import plot_style
from dp_tools.run_data import RunData
from dp_tools.scenario import Scenario, load_scenario
from marine_model import Vessel, load_vessel
from support.repository import SCENARIOS
from support.synthetic_run import synthetic_run


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


@pytest.fixture(scope="module")
def run(vessel: Vessel) -> RunData:
    return synthetic_run(vessel)


def every_kind(base: type[PlotSpec] = PlotSpec) -> set[type[PlotSpec]]:
    found = {kind for kind in base.__subclasses__() if "kind" in kind.model_fields}
    return found.union(*(every_kind(kind) for kind in base.__subclasses__()))


def test_every_kind_of_plot_has_somebody_who_draws_it() -> None:
    assert set(_DRAWN_BY) == every_kind()
    names = [get_args(kind.model_fields["kind"].annotation)[0] for kind in _DRAWN_BY]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("series", get_args(Overlay.model_fields["series"].annotation))
def test_windows_are_laid_over_one_another(series: str, run: RunData, vessel: Vessel) -> None:
    base = load_scenario(SCENARIOS / "run_a.yaml")
    spec = Overlay(kind="overlay", title="Terms", series=series, groups={"off": ("fixed",), "on": ("rotating",)})
    scenario: Scenario = base.model_copy(update={"plots": (spec,)})
    with plot_style():
        (picture,) = asked_pictures(Scene(run, scenario, vessel))
    assert picture.title == "Terms"
    assert picture.image.startswith("data:image/svg+xml;base64,")
    assert "off, on" in picture.alt
