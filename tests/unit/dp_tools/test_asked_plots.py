"""Pictures that a scenario asks for beside those of every report."""

from __future__ import annotations

import base64
import dataclasses
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import ValidationError

from dp_tools.plot_specs import PlotSpec
from dp_tools.plot_specs.gain import AttainablePlot, MinimumGains
from dp_tools.plot_specs.overlay import Overlay
from dp_tools.plot_specs.overlay_panels import OverlayPanels
from dp_tools.plot_specs.spectra import Spectra
from dp_tools.plot_specs.thrust_and_loss import ThrustAndLoss
from dp_tools.report import style
from dp_tools.report.asked import _DRAWN_BY, asked_pictures
from dp_tools.report.scene import Scene
from dp_tools.report.style import plot_style
from dp_tools.report.thrust_and_loss import antispin_flag
from dp_tools.run_data import RunData, Series
from dp_tools.scenario import Event, Scenario, load_scenario
from marine_model import Vessel, load_vessel
from marine_model.errors import DocumentError, InputError
from support.repository import SCENARIOS
from support.synthetic_run import SAMPLE, synthetic_run


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


GROUPS = {"off": ("fixed",), "on": ("rotating",)}
WELCH = {"segment": 16.0, "up_to": 5.0}


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        (
            OverlayPanels.model_validate(
                {
                    "kind": "overlay_panels",
                    "title": "Panels",
                    "groups": GROUPS,
                    "panels": [
                        {"series": "total_power"},
                        {"series": "thrust_command", "thruster": "azimuth_port"},
                        {"series": "azimuth_command", "thruster": "azimuth_bow"},
                        {"series": "beta_q2", "thruster": "azimuth_port"},
                    ],
                }
            ),
            "total power (W), thrust (N) azimuth_port, direction (deg) azimuth_bow, β_Q2 (1) azimuth_port",
        ),
        (
            Spectra.model_validate(
                {"kind": "spectra", "title": "S", "signal": "total_power", "groups": GROUPS, "marked": [1.25]} | WELCH
            ),
            "total power",
        ),
        (
            Spectra.model_validate(
                {
                    "kind": "spectra",
                    "title": "S",
                    "signal": "motor_torque",
                    "of": ["azimuth_port", "tunnel_bow"],
                    "groups": GROUPS,
                }
                | WELCH
            ),
            "motor torque",
        ),
        (ThrustAndLoss.model_validate({"kind": "thrust_and_loss", "title": "T"}), "torque loss factor"),
        (
            ThrustAndLoss.model_validate({"kind": "thrust_and_loss", "title": "T", "window": "switch"}),
            "Commanded thrust",
        ),
    ],
)
def test_a_scenario_gets_the_pictures_that_it_asks_for(
    spec: PlotSpec, words: str, run: RunData, vessel: Vessel
) -> None:
    scenario = load_scenario(SCENARIOS / "run_a.yaml").model_copy(update={"plots": (spec,)})
    with plot_style():
        (picture,) = asked_pictures(Scene(run, scenario, vessel))
    assert picture.title == spec.title
    assert picture.image.startswith("data:image/svg+xml;base64,")
    assert words in picture.alt


@pytest.mark.parametrize(
    ("kind", "fields", "message"),
    [
        (
            Spectra,
            {"kind": "spectra", "signal": "motor_torque"} | WELCH,
            "of: expected thrusters with motor_torque only",
        ),
        (Spectra, {"kind": "spectra", "signal": "total_power", "of": ["x"]} | WELCH, "of: expected thrusters"),
        (
            OverlayPanels,
            {"kind": "overlay_panels", "panels": [{"series": "total_power", "thruster": "x"}]},
            "thruster: expected one with every series but total_power, found 'x'",
        ),
        (OverlayPanels, {"kind": "overlay_panels", "panels": [{"series": "beta_q2"}]}, "thruster: expected one"),
    ],
)
def test_what_a_picture_cannot_be_made_of_is_refused(
    kind: type[PlotSpec], fields: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValidationError, match=message):
        kind.model_validate({"title": "T", "groups": GROUPS} | fields)


def test_a_thruster_of_a_picture_must_be_there(tmp_path: Path) -> None:
    text = (SCENARIOS / "run_d.yaml").read_text(encoding="utf-8")
    path = tmp_path / "x.yaml"
    path.write_text(text.replace("of: [azimuth_bow, azimuth_port,", "of: [rudder, azimuth_port,"), encoding="utf-8")
    with pytest.raises(DocumentError, match=r"of: expected one of tunnel_bow, .*, found 'rudder'"):
        load_scenario(path)


def test_the_flag_of_antispin_is_that_of_the_parameters() -> None:
    def switch(at: float, state: bool) -> Event:
        return Event(at=at, parameters={"thrust_allocator": {"antispin.enabled": state}})

    events = (Event(at=0.0, setpoint=(0.0, 0.0, 0.0)), switch(10.0, True), switch(30.0, False))
    scenario = load_scenario(SCENARIOS / "run_a.yaml").model_copy(update={"events": events})
    flag = antispin_flag(scenario, 40.0)
    assert flag.t.tolist() == [0.0, 10.0, 30.0, 40.0]
    assert flag.values[:, 0].tolist() == [0.0, 1.0, 0.0, 0.0]


def drawn(run: RunData, vessel: Vessel, spec: dict[str, Any], **fields: Any) -> tuple[str, str]:
    """Return what the picture is said to show, and its SVG."""
    scenario = Scenario.model_validate(
        {
            "name": "trial",
            "title": "Trial",
            "description": "",
            "vessel": "cybership3",
            "duration": 380.0,
            "windows": {"part": [100.0, 200.0]},
            "plots": [{"title": "One"} | spec],
        }
        | fields
    )
    with plot_style():
        (picture,) = asked_pictures(Scene(run, scenario, vessel))
    head, _, data = picture.image.partition(",")
    assert head == "data:image/svg+xml;base64"
    return picture.alt, base64.b64decode(data).decode()


def test_sectors_are_shaded(run: RunData, vessel: Vessel) -> None:
    alt, whole = drawn(run, vessel, {"kind": "sectors"})
    assert "forbidden sectors" in alt
    # Five sectors, each seen once more a turn below, and the patch of the legend.
    assert whole.count(style.FAULT) == 11
    assert drawn(run, vessel, {"kind": "sectors", "window": "part"})[1] != whole


def test_the_demand_of_auto_mode_stands_over_its_hysteresis(run: RunData, vessel: Vessel) -> None:
    t = np.arange(100) * SAMPLE
    series = {**run.series, "performance_measure": Series(t, np.linspace(0.0, 2.0, 100)[:, None])}
    alt, image = drawn(dataclasses.replace(run, series=series), vessel, {"kind": "auto_mode"})
    assert "hysteresis" in alt
    assert image.count(style.BAND) == 2  # band and legend
    del series["performance_measure"]
    with pytest.raises(InputError, match="performance_measure"):
        drawn(dataclasses.replace(run, series=series), vessel, {"kind": "auto_mode"})


FAILS = [
    {"at": 20.0, "parameters": {"vessel_sim": {"propulsion.failed": [False, True, True, False]}}},
    {"at": 40.0, "parameters": {"vessel_sim": {"propulsion.failed": [False] * 4}}},
    {"at": 60.0, "parameters": {"vessel_sim": {"propulsion.azimuth_failed": [False, False, True, False]}}},
]


def test_faults_are_red(run: RunData, vessel: Vessel) -> None:
    _, image = drawn(run, vessel, {"kind": "faults"}, events=FAILS)
    assert image.count(style.FAULT) == 2 * 4 + 1  # two faults in four panels, and the legend
    assert drawn(run, vessel, {"kind": "faults"})[1].count(style.FAULT) == 0


def test_every_picture_of_a_report_shades_the_thruster_that_is_faulty(run: RunData, vessel: Vessel) -> None:
    base = load_scenario(SCENARIOS / "run_a.yaml")
    events = [*(event.model_dump(exclude_defaults=True) for event in base.events), *FAILS]
    events.sort(key=lambda event: event.get("at", 0.0))
    scenario = Scenario.model_validate(base.model_dump(exclude={"events"}) | {"events": events})
    with plot_style():
        panels = Scene(run, scenario, vessel).panels(
            ("azimuth bow\n(deg)", "azimuth port\n(deg)", "east (m)"), (0.0, 380.0)
        )
        plain = Scene(run, base, vessel).panels(("azimuth bow\n(deg)", "azimuth port\n(deg)", "east (m)"), (0.0, 380.0))
    more = [len(a.patches) - len(b.patches) for a, b in zip(panels.axes, plain.axes, strict=True)]
    windows = len(Scene(run, base, vessel).measured_windows)  # not shaded beside faults
    assert more == [1 - windows, 2 - windows, 2 - windows]


def test_figures_as_bars(run: RunData, vessel: Vessel) -> None:
    figures = [
        {"name": f"power_{name}", "kind": "mean_power", "title": name, "window": name} for name in ("part", "rest")
    ]
    windows = {"part": [100.0, 200.0], "rest": [210.0, 300.0]}
    spec = {
        "kind": "bars",
        "figures": ["power_rest", "power_part"],
        "label": "power (W)",
        "logarithmic": True,
        "level": 1.0,
    }
    alt, _ = drawn(run, vessel, spec, figures=figures, windows=windows)
    assert alt == "power (W) of rest, part"


@pytest.mark.parametrize("window", ["", "part"])
@pytest.mark.parametrize("reverse", ["as_ahead", "own", "none"])
def test_demand_is_drawn_beside_the_minimum_gain(window: str, reverse: str, run: RunData, vessel: Vessel) -> None:
    alt, _ = drawn(run, vessel, {"kind": "attainable", "window": window, "reverse": reverse})
    assert "minimum gain" in alt


@pytest.mark.parametrize("push", [False, True])
def test_minimum_gains_are_drawn(push: bool, run: RunData, vessel: Vessel) -> None:
    alt, _ = drawn(run, vessel, {"kind": "minimum_gains", "limit": 0.5, "push": push})
    assert "singularity avoidance" in alt


def test_gains_need_no_window_but_one_that_is_there() -> None:
    assert AttainablePlot(kind="attainable", title="D", window="switch").windows() == (("window", "switch"),)
    assert MinimumGains(kind="minimum_gains", title="G").windows() == ()


def test_bars_of_a_figure_that_nobody_asks_for_are_refused(tmp_path: Path) -> None:
    text = (SCENARIOS / "run_h.yaml").read_text(encoding="utf-8").replace("figures: [badness_12,", "figures: [nothing,")
    (tmp_path / "trial.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(DocumentError, match=r"plots\.1\.figures: expected a name out of figures, found 'nothing'"):
        load_scenario(tmp_path / "trial.yaml")
