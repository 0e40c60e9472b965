"""The report as one self-contained HTML page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dp_tools.figures import Figure, compute_figures, write_figures
from dp_tools.limits import LimitCheck, limits_violations
from dp_tools.quantities import bound, interval, number, quantity, remark
from dp_tools.report.asked import asked_pictures
from dp_tools.report.plots import close_up_pictures, pictures
from dp_tools.report.scene import Picture, Scene
from dp_tools.report.style import plot_style
from dp_tools.report.template import fill_in
from dp_tools.run_data import RunData
from dp_tools.scenario import Scenario
from marine_model import Vessel

REPORT_NAME = "report.html"
FIGURES_NAME = "figures.json"

_LIMIT_TITLES = {
    "thrust": "Thrust",
    "thrust_rate": "Rate of change of thrust",
    "azimuth_rate": "Turning rate of the direction",
    "torque": "Motor torque",
    "azimuth_motor_rate": "Rate of the azimuth motor",
}
_LIMIT_SCALES = {"torque": (1000.0, "mN m")}
_LABEL_TITLES = {
    "controller_mode": "Controller mode",
    "controller_status": "Controller",
    "observer_status": "Observer",
    "azimuth_mode": "Azimuth mode",
    "allocation_status": "Allocator",
}


@dataclass(frozen=True)
class FigureRow:
    """A figure of merit as text."""

    title: str
    ours: str
    interval: str
    thesis: str
    difference: str
    bound: str
    held: bool | None
    remark: str


@dataclass(frozen=True)
class LimitRow:
    """One limit of all thrusters."""

    title: str
    unit: str
    scale: float  # from the unit of the checks to the one shown
    checks: tuple[LimitCheck, ...]

    @property
    def violations(self) -> int:
        """Samples outside, all thrusters together."""
        return sum(check.violations for check in self.checks)


@dataclass(frozen=True)
class StateRow:
    """One word of a mode or status and how long it held."""

    title: str
    word: str
    share: str
    first: str


def write_report(run: RunData, scenario: Scenario, vessel: Vessel, folder: Path) -> Path:
    """Write report.html and figures.json into ``folder`` and return the path of the page.

    Raises
    ------
    InputError
        If the run lacks a series that a figure of the scenario needs.
    OSError
        If the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    figures = compute_figures(run, scenario, vessel)
    page = render(run, scenario, vessel, figures)
    write_figures(folder / FIGURES_NAME, scenario, figures)
    path = folder / REPORT_NAME
    path.write_text(page, encoding="utf-8")
    return path


def render(run: RunData, scenario: Scenario, vessel: Vessel, figures: tuple[Figure, ...]) -> str:
    """Return the page as HTML text; it refers to nothing outside itself."""
    scene = Scene(run, scenario, vessel)
    limits = limits_violations(run, vessel) if "thrust_command" in run else ()
    with plot_style():
        main = [*asked_pictures(scene), *pictures(scene)]
        close_ups: list[tuple[str, str, list[Picture]]] = [
            (c.title, _span_text(scenario.windows[c.window]), list(close_up_pictures(scene, c.window)))
            for c in scenario.close_ups
        ]
    return fill_in(
        "report.html",
        run=run,
        subject=scenario,
        scenario=scenario,
        vessel=vessel,
        figures=[_figure_row(figure) for figure in figures],
        limits=_limit_rows(limits),
        samples=sum(check.samples for check in limits),
        violations=sum(check.violations for check in limits),
        states=_state_rows(run),
        facts=_facts(run, scenario, vessel),
        pictures=main,
        close_ups=close_ups,
        number=number,
    )


def _figure_row(figure: Figure) -> FigureRow:
    spec = figure.spec
    difference = ""
    if figure.difference is not None:
        if spec.shown == "change":
            difference = f"{100.0 * figure.difference:+.1f} points"
        else:
            difference = ("+" if figure.difference > 0.0 else "") + quantity(spec, figure.difference)
    return FigureRow(
        title=spec.title,
        ours="not reached" if figure.value is None else quantity(spec, figure.value),
        interval="" if figure.low is None or figure.high is None else interval(spec, figure.low, figure.high),
        thesis="" if spec.thesis is None else quantity(spec, spec.thesis),
        difference=difference.replace("-", "−"),
        bound=bound(spec),
        held=figure.held,
        remark=remark(spec),
    )


def _limit_rows(checks: tuple[LimitCheck, ...]) -> list[LimitRow]:
    names = list(dict.fromkeys(check.limit for check in checks))
    rows = []
    for name in names:
        chosen = tuple(check for check in checks if check.limit == name)
        scale, unit = _LIMIT_SCALES.get(name, (1.0, chosen[0].unit))
        rows.append(LimitRow(_LIMIT_TITLES[name], unit, scale, chosen))
    return rows


def _state_rows(run: RunData) -> list[StateRow]:
    rows = []
    for name, title in _LABEL_TITLES.items():
        if name not in run.labels or not run.labels[name].words:
            continue
        labels = run.labels[name]
        ends = [*labels.t[1:].tolist(), max(run.duration, float(labels.t[-1]))]
        held: dict[str, float] = {}
        first: dict[str, float] = {}
        for word, start, end in zip(labels.words, labels.t.tolist(), ends, strict=True):
            held[word] = held.get(word, 0.0) + end - start
            first.setdefault(word, start)
        total = sum(held.values())
        for word, time in held.items():
            share = f"{100.0 * time / total:.1f} %" if total > 0.0 else "100 %"
            rows.append(StateRow(title, word, share, f"{first[word]:.1f} s"))
            title = ""
    return rows


def _facts(run: RunData, scenario: Scenario, vessel: Vessel) -> list[tuple[str, str]]:
    info = run.info
    facts = [
        ("Vessel", vessel.name),
        ("Scenario", scenario.name),
        ("Sailed", info.how),
        ("Seed", str(info.seed)),
        ("Duration", f"{info.simulated_time or run.duration:g} s"),
    ]
    if info.real_time_factor is not None:
        facts.append(("Wall time", f"{number(info.wall_time)} s"))
        facts.append(("Real-time factor", number(info.real_time_factor)))
    return facts


def _span_text(span: tuple[float, float]) -> str:
    return f"{span[0]:g} s to {span[1]:g} s"
