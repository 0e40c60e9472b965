"""A scenario for a vessel of another scale: the same trial by Froude's law."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from dp_tools.figures import AnyFigure
from dp_tools.node_settings import default_settings
from dp_tools.plot_specs import AnyPlot
from dp_tools.plot_specs.bars import Bars
from dp_tools.scenario import NodeParameters, Scenario
from marine_model import Vessel
from marine_model.froude import FroudeLaw, scaled
from marine_model.settings import parameters_of
from marine_model.units import parameter_units
from thrust_allocator.settings import UNLIMITED

# Sample times of similar vessels differ from Froude's law by the rounding to whole nanoseconds, far less than this.
_SAME_CLOCK = 1e-6


def scaled_scenario(scenario: Scenario, own: Vessel, vessel: Vessel) -> Scenario:
    """Return ``scenario``, whose numbers are for the scale of ``own``, for ``vessel``.

    Every number goes by its unit: times, positions, forces, parameters and what figures are compared with; ratios and
    angles stay. Parameters that the scenario leaves alone and whose defaults are plain numbers with a unit are written
    out, scaled.

    Where the sample times of both vessels agree with Froude's law but for the rounding of their time steps to whole
    nanoseconds, all times are multiplied by the ratio of sample times: every event stays at its sample and every wave
    at its phase. Otherwise events and duration go to the nearest sample of ``vessel``.

    Raises
    ------
    InputError
        If a figure or parameter has a unit that is not known.
    """
    before = scenario.scale or own.scale
    ratio = before / vessel.scale
    law = FroudeLaw(ratio)
    samples = vessel.measurement.sample_time / own.measurement.sample_time
    if abs(samples / law.time - 1.0) < _SAME_CLOCK:
        law = FroudeLaw(ratio, clock=samples / law.time)
    scale = _ScenarioLaw(law, own, vessel)
    duration = scale.whole_samples(scenario.duration)
    return law.section(
        scenario,
        name=_name(f"{scenario.name}_{vessel.name}"),
        title=f"{scenario.title}, scaled to {vessel.name}",
        description=(
            f"{scenario.name} scaled by Froude's law from 1:{before:g} to 1:{vessel.scale:g}: lengths by {ratio:g}, "
            f"times by {law.time:.6g}, forces by {law.factor('N'):g}. Numbers in the texts are still those of "
            f"{scenario.name}. {scenario.description}"
        ),
        vessel=vessel.name,
        scale=vessel.scale,
        duration=duration,
        parameters=scale.parameters(scenario.parameters, plain_defaults=True),
        events=tuple(
            law.section(event, at=scale.whole_samples(event.at), parameters=scale.parameters(event.parameters))
            for event in scenario.events
        ),
        # The duration may have been rounded to a sample before the end of a window.
        windows={
            name: (law.value(start, "s"), min(law.value(end, "s"), duration))
            for name, (start, end) in scenario.windows.items()
        },
        figures=tuple(_figure(figure, law) for figure in scenario.figures),
        plots=tuple(_plot(plot, scenario, law) for plot in scenario.plots),
    )


class _ScenarioLaw:
    """Froude's law for what needs the vessels: whole samples and parameters."""

    def __init__(self, law: FroudeLaw, own: Vessel, vessel: Vessel) -> None:
        self._law = law
        self._sample = vessel.measurement.sample_time
        settings = default_settings(own)
        self._units = {node: parameter_units(type(default)) for node, default in settings.items()}
        self._defaults = {node: parameters_of(default) for node, default in settings.items()}
        # Defaults that a vessel file gives follow the vessel.
        like = default_settings(scaled(own, law.length))
        self._following = {node: parameters_of(default) for node, default in like.items()}

    def whole_samples(self, time: float) -> float:
        return round(round(time * self._law.time / self._sample) * self._sample, 9)

    def parameters(self, given: NodeParameters, plain_defaults: bool = False) -> NodeParameters:
        found = {node: self._node(node, values) for node, values in given.items()}
        if plain_defaults:
            for node, defaults in self._defaults.items():
                plain = {k: v for k, v in defaults.items() if v is not None and v == self._following[node][k]}
                own = found.get(node, {})
                scaled_defaults = self._node(node, {k: v for k, v in plain.items() if k not in own}).items()
                # Parameter files know lists only.
                changed = {k: list(v) if isinstance(v, tuple) else v for k, v in scaled_defaults if v != plain[k]}
                if changed:
                    found[node] = own | changed
        return found

    def _node(self, node: str, values: Mapping[str, Any]) -> dict[str, Any]:
        units = self._units.get(node, {})
        return {name: self._value(value, units.get(name)) for name, value in values.items()}

    def _value(self, value: Any, unit: str | None) -> Any:
        if unit is None:
            return value
        new = self._law.value(value, unit)
        if isinstance(value, list | tuple) and new != value:
            return type(value)(old if _unlimited(old) else one for old, one in zip(value, new, strict=True))
        return value if _unlimited(value) else new


def _unlimited(value: Any) -> bool:
    return isinstance(value, int | float) and value >= UNLIMITED


def _figure(figure: AnyFigure, law: FroudeLaw) -> AnyFigure:
    found = {name: getattr(figure, name) for name in ("thesis", "at_most", "at_least")}
    numbers = {name: law.value(value, figure.unit) for name, value in found.items() if value is not None}
    return law.section(figure, **numbers)


def _plot(plot: AnyPlot, scenario: Scenario, law: FroudeLaw) -> AnyPlot:
    if not isinstance(plot, Bars) or plot.level is None:
        return law.section(plot)
    unit = next(figure.unit for figure in scenario.figures if figure.name == plot.figures[0])
    return law.section(plot, level=law.value(plot.level, unit))


def _name(text: str) -> str:
    return re.sub(r"[^a-z0-9_]+", "_", text.lower())
