"""Power spectral densities of signals of a run, and the energy in a band of them (Welch's method, Hann window)."""

from __future__ import annotations

import math

import numpy as np

from dp_tools.run_data import Series
from marine_model.errors import InputError
from marine_model.guards import FloatArray

# Each segment begins a quarter of a segment after the one before: with a Hann window nothing more is to be had of it.
_HOPS = 4
# A Hann window spreads a sine over two steps of frequency to either side.
_MAIN_LOBE = 4


def band_energies(series: Series, frequency: float, bandwidth: float) -> FloatArray:
    """Return the energy in a band in successive, overlapping segments of one signal; their mean is Welch's estimate.

    A segment lasts four times the reciprocal of the bandwidth, so that a sine in the middle of the band, amplitude A,
    has all of its energy A^2 / 2 within.

    Parameters
    ----------
    series
        One column, evenly sampled.
    frequency, bandwidth
        Middle of the band and its whole width, Hz.

    Raises
    ------
    InputError
        If the signal is shorter than a segment, or the band reaches beyond what its sampling can show.
    """
    from scipy.signal import periodogram  # here: its import is slow

    step = _time_step(series)
    if bandwidth <= 0.0 or frequency - 0.5 * bandwidth < 0.0 or frequency + 0.5 * bandwidth > 0.5 / step:
        raise InputError(
            f"band: expected it between 0 and {0.5 / step:g} Hz, found {frequency:g} Hz +- {0.5 * bandwidth:g} Hz"
        )
    length = round(_MAIN_LOBE / bandwidth / step)
    x = series.values[:, 0]
    if len(x) < length:
        raise InputError(f"window: expected at least {length} samples for a band of {bandwidth:g} Hz, found {len(x)}")
    segments = np.lib.stride_tricks.sliding_window_view(x, length)[:: max(1, length // _HOPS)]
    frequencies, density = periodogram(segments, fs=1.0 / step, window="hann", detrend="constant", axis=-1)
    inside = np.abs(frequencies - frequency) <= 0.5 * bandwidth + 1e-9 / step
    energies: FloatArray = density[:, inside].sum(axis=1) * float(frequencies[1])
    return energies


def spectrum(series: Series, segment: float) -> tuple[FloatArray, FloatArray]:
    """Return frequency (Hz) and one-sided density (unit squared per Hz) of one signal, in segments of ``segment`` s."""
    from scipy.signal import welch  # here: its import is slow

    step = _time_step(series)
    length = min(len(series.t), round(segment / step))
    frequencies, density = welch(
        series.values[:, 0],
        fs=1.0 / step,
        window="hann",
        nperseg=length,
        noverlap=length - length // _HOPS,
        detrend="constant",
    )
    return frequencies, density


def _time_step(series: Series) -> float:
    if len(series.t) < 2:
        raise InputError(f"window: expected at least 2 samples, found {len(series.t)}")
    step = float(series.t[-1] - series.t[0]) / (len(series.t) - 1)
    if not math.isfinite(float(series.values.sum())):
        raise InputError("signal: expected finite numbers")
    return step
