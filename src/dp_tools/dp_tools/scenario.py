"""Scenario files: what is sailed, when what happens, and what is measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Self

import yaml
from pydantic import Field, PrivateAttr, model_validator

from dp_bringup.workspace import share
from dp_tools.figures import AnyFigure
from dp_tools.node_settings import SIMULATOR, changed_settings, default_settings
from dp_tools.plot_specs import AnyPlot
from marine_model import Vessel, load_vessel
from marine_model.errors import DocumentError, InputError, UnknownNameError
from marine_model.named_files import file_names, named_file
from marine_model.schema import NonNegative, Positive, Section, Vector3
from marine_model.section_text import section_text
from marine_model.settings import Settings, read_only_parameters
from marine_model.units import Unit
from marine_model.yaml_document import FieldPath, YamlDocument, read_yaml

ParameterValue = bool | int | float | str | list[bool] | list[int] | list[float] | list[str]
# By node, by parameter (dots for groups). The units are those of the parameters.
NodeParameters = Annotated[dict[str, dict[str, ParameterValue]], Unit("")]
Window = Annotated[tuple[float, float], Field(strict=False), Unit("s")]  # start and end
Time = Annotated[NonNegative, Unit("s")]
Position = Annotated[Vector3, Unit("m, m, rad")]  # in map_ned
# Of a submerged vehicle: north, east, depth, roll, pitch, heading; and a force along all six axes.
Pose = Annotated[tuple[float, float, float, float, float, float], Field(strict=False), Unit("m, m, m, rad, rad, rad")]
Wrench = Annotated[tuple[float, float, float, float, float, float], Field(strict=False), Unit("N, N, N, N m, N m, N m")]


class PathPoint(Section):
    """Where the vessel shall be at one time."""

    at: Time  # since the start of the run
    position: Position


class Event(Section):
    """What an operator does at one time: parameters first, then at most one of setpoint, joystick and path."""

    at: Time  # whole samples of the control system
    label: str = ""  # shown in the report
    parameters: NodeParameters = Field(default_factory=dict)
    # Three numbers for a vessel on the surface, six for a submerged vehicle.
    setpoint: Position | Pose | None = None
    joystick: Annotated[Vector3, Unit("N, N, N m")] | Wrench | None = None  # in the body frame
    path: Annotated[tuple[PathPoint, ...], Field(strict=False, min_length=2)] | None = None

    @model_validator(mode="after")
    def _one_action(self) -> Self:
        given = [n for n in ("setpoint", "joystick", "path") if getattr(self, n) is not None]
        if len(given) > 1:
            raise ValueError(f"expected at most one of setpoint, joystick and path, found {given}")
        if not given and not self.parameters:
            raise ValueError("expected parameters, setpoint, joystick or path, found none of them")
        times = [point.at for point in self.path or ()]
        if any(later <= earlier for earlier, later in pairwise(times)):
            raise ValueError(f"path: expected times that increase, found {times}")
        return self


class CloseUp(Section):
    """A part of the run that the report also shows enlarged."""

    title: str = Field(min_length=1)
    window: str


class Scenario(Section):
    """One scenario file."""

    name: str = Field(pattern=r"^[a-z][a-z0-9_]*$")
    title: str = Field(min_length=1)
    description: str
    source: str = ""  # where the thesis describes it
    vessel: str  # name, or path (from the scenario's folder)
    scale: Annotated[Positive | None, Unit("")] = None  # that the numbers are for; that of the vessel if absent
    duration: Annotated[Positive, Unit("s")]  # whole samples of the control system
    seed: int = Field(default=0, ge=0)
    parameters: NodeParameters = Field(default_factory=dict)  # at start
    events: Annotated[tuple[Event, ...], Field(strict=False)] = ()
    windows: dict[str, Window] = Field(default_factory=dict)
    close_ups: Annotated[tuple[CloseUp, ...], Field(strict=False)] = ()
    figures: Annotated[tuple[AnyFigure, ...], Field(strict=False)] = ()
    plots: Annotated[tuple[AnyPlot, ...], Field(strict=False)] = ()  # beside those of every report
    _path: Path | None = PrivateAttr(default=None)

    @property
    def path(self) -> Path | None:
        """File that says the same; None if there is none, as it was scaled or made otherwise."""
        return self._path

    @property
    def run(self) -> str:
        """Name in figures.json: ``a`` for ``run_a``."""
        return self.name.removeprefix("run_")

    @property
    def start_parameters(self) -> NodeParameters:
        """Parameters that every node is started with, by node; the seed is among them."""
        simulator = {"seed": self.seed, **self.parameters.get(SIMULATOR, {})}
        return {**self.parameters, SIMULATOR: simulator}

    def settings(self, vessel: Vessel) -> dict[str, Settings]:
        """Return the settings of every node at start.

        Raises
        ------
        InputError
            If a node or parameter is unknown, or a value is refused.
        """
        settings = default_settings(vessel)
        for node, changes in self.start_parameters.items():
            if node not in settings:
                raise InputError(f"node: expected one of {', '.join(settings)}, found '{node}'")
            settings[node] = changed_settings(node, settings[node], changes, vessel)
        return settings


def scenario_folder() -> Path:
    """Return the folder of the scenarios that come with dp_bringup.

    Raises
    ------
    WorkspaceError
        If dp_bringup is not built.
    """
    return share("dp_bringup") / "scenarios"


def scenario_names() -> tuple[str, ...]:
    """Return the names of the scenarios that come with dp_bringup, sorted."""
    return file_names(scenario_folder())


def scenario_path(name_or_path: str | Path) -> Path:
    """Return the file of a scenario. Raises UnknownNameError, WorkspaceError."""
    return named_file("scenario", name_or_path, scenario_folder)


def load_scenario(name_or_path: str | Path, vessel: Vessel | None = None, scale: bool = True) -> Scenario:
    """Return a validated scenario.

    For a vessel of another scale than that of its numbers it is scaled by Froude's law, see
    :func:`dp_tools.scenario_scale.scaled_scenario`; it has another name and no path then.

    Parameters
    ----------
    name_or_path
        A name out of ``scenario_names()``, or the path of a YAML file (anything with a folder or a suffix).
    vessel
        Vessel to sail instead of the one that it names.
    scale
        False takes the numbers as they are: a recording holds the scenario as it was sailed.

    Raises
    ------
    UnknownNameError
        If no scenario has that name, or the path does not exist.
    DocumentError
        If the file cannot be read or breaks the schema, or a node, parameter or window is unknown, or a time does not
        fit: one line per problem, with file, line and field.
    """
    document = read_yaml(scenario_path(name_or_path))
    vessel_file = document.content.get("vessel")
    if isinstance(vessel_file, str) and (document.path.parent / vessel_file).is_file():
        document.content["vessel"] = str(document.path.parent / vessel_file)
    scenario = document.validate(Scenario)
    if vessel is None:
        try:
            vessel = load_vessel(scenario.vessel)
        except UnknownNameError as error:
            raise DocumentError(document.problem(("vessel",), str(error))) from error
    found = _for_scale_of(vessel, scenario) if scale else scenario
    problems = list(_problems(found, document, vessel))
    if problems:
        raise DocumentError("\n".join(problems))
    if found is scenario:
        found._path = document.path.absolute()
    return found


def scenario_document(scenario: Scenario) -> bytes:
    """Return a scenario as a YAML file that can be loaded from anywhere: its own file, where that says the same.

    Raises
    ------
    DocumentError
        If its file cannot be read any more.
    """
    if scenario.path is None:
        return section_text(scenario).encode()
    content = read_yaml(scenario.path).content
    if (content.get("seed", 0), content.get("vessel")) == (scenario.seed, scenario.vessel):
        return scenario.path.read_bytes()
    content |= {"seed": scenario.seed, "vessel": scenario.vessel}
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True).encode()


def free_run(vessel: str, duration: float) -> Scenario:
    """Return the scenario of a run that followed none: no events, nothing to measure."""
    return Scenario(
        name="free_run",
        title="Run without a scenario",
        description="The graph ran until it was stopped.",
        vessel=vessel,
        duration=max(duration, 1e-3),
    )


def _for_scale_of(vessel: Vessel, scenario: Scenario) -> Scenario:
    """Return the scenario for ``vessel``; as it is if its vessel is not known here, and so neither is its scale."""
    if scenario.scale == vessel.scale:
        return scenario
    try:
        own = load_vessel(scenario.vessel)
    except UnknownNameError:
        return scenario
    if (scenario.scale or own.scale) == vessel.scale:
        return scenario
    from dp_tools.scenario_scale import scaled_scenario  # it is made of what stands here

    return scaled_scenario(scenario, own, vessel)


def _problems(scenario: Scenario, document: YamlDocument, vessel: Vessel) -> Iterator[str]:
    for field, message in (
        *_time_problems(scenario, vessel.measurement.sample_time),
        *_window_problems(scenario),
        *_figure_problems(scenario, vessel),
        *_parameter_problems(scenario, vessel),
        *_axis_problems(scenario, vessel),
    ):
        yield document.problem(field, message)


def _time_problems(scenario: Scenario, sample: float) -> Iterator[tuple[FieldPath, str]]:
    """Times are whole samples, so that an event has one meaning on the graph and in process."""
    times: list[tuple[FieldPath, float]] = [(("duration",), scenario.duration)]
    times += [(("events", i, "at"), event.at) for i, event in enumerate(scenario.events)]
    for field, time in times:
        if abs(time / sample - round(time / sample)) > 1e-6:  # decimals such as 0.6 / 0.2 are not exact
            yield field, f"expected a whole multiple of the sample time of {sample} s, found {time}"
        elif time > scenario.duration:
            yield field, f"expected a time within the duration of {scenario.duration} s, found {time}"
    for i, (earlier, later) in enumerate(pairwise(scenario.events)):
        if later.at < earlier.at:
            yield ("events", i + 1, "at"), f"expected events in order of time, found {later.at} after {earlier.at}"


def _window_problems(scenario: Scenario) -> Iterator[tuple[FieldPath, str]]:
    for name, (start, end) in scenario.windows.items():
        if not 0.0 <= start < end <= scenario.duration:
            yield (
                ("windows", name),
                f"expected 0 <= start < end <= {scenario.duration}, found {[start, end]}",
            )
    uses: list[tuple[FieldPath, str]] = [
        (("close_ups", i, "window"), close_up.window) for i, close_up in enumerate(scenario.close_ups)
    ]
    for name, asked in (("figures", scenario.figures), ("plots", scenario.plots)):
        for i, one in enumerate(asked):
            uses += [((name, i, field), window) for field, window in one.windows()]
    for field, window in uses:
        if window not in scenario.windows:
            known = ", ".join(scenario.windows) or "none"
            yield field, f"expected a name out of windows ({known}), found '{window}'"


def _figure_problems(scenario: Scenario, vessel: Vessel) -> Iterator[tuple[FieldPath, str]]:
    seen: set[str] = set()
    for i, figure in enumerate(scenario.figures):
        if figure.name in seen:
            yield ("figures", i, "name"), f"every name must be unique, found '{figure.name}' twice"
        seen.add(figure.name)
    for i, plot in enumerate(scenario.plots):
        for name in plot.figure_names():
            if name not in seen:
                yield ("plots", i, "figures"), f"expected a name out of figures, found '{name}'"
    for name, asked in (("figures", scenario.figures), ("plots", scenario.plots)):
        for i, one in enumerate(asked):
            for field, thruster in one.thrusters():
                if thruster not in vessel.thruster_names:
                    known = ", ".join(vessel.thruster_names)
                    yield (name, i, field), f"expected one of {known}, found '{thruster}'"


def _axis_problems(scenario: Scenario, vessel: Vessel) -> Iterator[tuple[FieldPath, str]]:
    """Yield set points and forces of the joystick that have not the numbers of the vessel's motion."""
    expected = 6 if vessel.is_submerged else 3
    for i, event in enumerate(scenario.events):
        for name in ("setpoint", "joystick"):
            given = getattr(event, name)
            if given is not None and len(given) != expected:
                yield (
                    ("events", i, name),
                    f"expected {expected} numbers for '{vessel.name}', found {len(given)}: {list(given)}",
                )


def _parameter_problems(scenario: Scenario, vessel: Vessel) -> Iterator[tuple[FieldPath, str]]:
    """Apply every change in order of time to the settings that hold by then, as the nodes will."""
    if "seed" in scenario.parameters.get(SIMULATOR, {}):
        yield ("parameters", SIMULATOR, "seed"), "the seed is the scenario's own field 'seed'"
    settings = default_settings(vessel)
    changes: list[tuple[FieldPath, NodeParameters, bool]] = [(("parameters",), scenario.parameters, True)]
    changes += [(("events", i, "parameters"), e.parameters, False) for i, e in enumerate(scenario.events)]
    for place, nodes, at_start in changes:
        for node, values in nodes.items():
            if node not in settings:
                yield (*place, node), f"expected one of {', '.join(settings)}, found '{node}'"
                continue
            if not at_start:
                for name in read_only_parameters(type(settings[node])) & set(values):
                    yield (*place, node, name), "cannot change while the node runs; set it under parameters"
            try:
                settings[node] = changed_settings(node, settings[node], values, vessel)
            except InputError as whole:
                yield _blame((*place, node), node, settings[node], values, vessel, whole)


def _blame(
    place: FieldPath,
    node: str,
    settings: Settings,
    values: Mapping[str, ParameterValue],
    vessel: Vessel,
    whole: InputError,
) -> tuple[FieldPath, str]:
    """Return the first value that is wrong by itself; else the node, as only the combination is wrong."""
    for name, value in values.items():
        try:
            changed_settings(node, settings, {name: value}, vessel)
        except InputError as error:
            return (*place, name), str(error)
    return place, str(whole)
