"""Power spectra of several windows, as Figures 5.7 and 5.8 of [Ruth]."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure as Canvas

from dp_tools.figures.spectrum import signal_of
from dp_tools.plot_specs.spectra import Spectra
from dp_tools.report import style
from dp_tools.report.groups import lines_of, name_groups
from dp_tools.report.panels import WIDTH, svg_uri
from dp_tools.report.scene import Scene
from dp_tools.spectra import spectrum

# Unit of the density, and factor to it.
_UNITS = {"W": ("W²/Hz", 1.0), "N m": ("(N m)²/Hz", 1.0), "mN m": ("(mN m)²/Hz", 1e6)}
# Below this torque, N m, all are those of a model.
_MODEL_TORQUE = 1.0


def spectra(scene: Scene, spec: Spectra) -> tuple[str, str]:
    """Draw the power spectral density of every window."""
    thrusters = spec.of or ("",)
    unit, scale = _UNITS[_shown_in(scene, spec)]
    figure = Canvas(figsize=(WIDTH, 1.0 + 2.0 * len(thrusters)), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(thrusters), 1, sharex=True)).tolist()
    for axis, thruster in zip(axes, thrusters, strict=True):
        signal = signal_of(scene.run, spec.signal, thruster)
        name = thruster.replace("_", " ")
        axis.set_ylabel(f"{name}\n({unit})" if name else f"total power ({unit})")
        for window, line in lines_of(spec.groups):
            frequency, density = spectrum(signal.window(*scene.scenario.windows[window]), spec.segment)
            shown = (frequency > 0.0) & (frequency <= spec.up_to)
            axis.plot(frequency[shown], scale * density[shown], **line)
        for mark in spec.marked:
            axis.axvline(mark, color=style.MUTED, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
        axis.set_ylim(bottom=0.0)
        axis.set_xlim(0.0, spec.up_to)
    name_groups(figure, axes, "frequency (Hz)")
    alt = f"Power spectrum of {spec.signal.replace('_', ' ')} in the windows of {', '.join(spec.groups)}"
    return svg_uri(figure), alt


def _shown_in(scene: Scene, spec: Spectra) -> str:
    if spec.signal == "total_power":
        return "W"
    return "mN m" if float(np.abs(scene.run["motor_torque"].values).max()) < _MODEL_TORQUE else "N m"
