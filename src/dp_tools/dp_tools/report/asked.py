"""The pictures that a scenario asks for: which function draws which kind."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from dp_tools.plot_specs import PlotSpec
from dp_tools.plot_specs.gain import AttainablePlot, MinimumGains
from dp_tools.plot_specs.overlay import Overlay
from dp_tools.report.gain import attainable_plot, minimum_gains
from dp_tools.report.overlay import overlay
from dp_tools.report.scene import Picture, Scene

# Each takes the scene and a spec of its own kind, and returns the image as data URI, and in words what it shows.
_DRAWN_BY: dict[type[PlotSpec], Callable[[Scene, Any], tuple[str, str]]] = {
    AttainablePlot: attainable_plot,
    MinimumGains: minimum_gains,
    Overlay: overlay,
}


def asked_pictures(scene: Scene) -> Iterator[Picture]:
    """Return the pictures that the scenario asks for, in its order."""
    for spec in scene.scenario.plots:
        image, alt = _DRAWN_BY[type(spec)](scene, spec)
        text = " ".join(part for part in (spec.text, f"As {spec.source}." if spec.source else "") if part)
        yield Picture(spec.title, text, image, alt)
