"""Wind over the open sea after NORSOK N-003 (also ISO 19901-1): speed by height, and the NPD spectrum of gusts.

All at full scale, in m, s and Hz. U is the mean over an hour at a height of 10 m.
"""

from __future__ import annotations

import math

import numpy as np

from marine_model.guards import FloatArray

REFERENCE_HEIGHT = 10.0  # m
# Hz: periods of 2 s to 10 min, for which the spectrum is given.
LOWEST, HIGHEST = 1.0 / 600.0, 0.5

_EXPONENT = 0.468  # n
_POWER = 5.0 / (3.0 * _EXPONENT)


def speed_at(height: float, mean: float) -> float:
    """Return the mean wind speed at ``height`` (m): U (1 + C ln(z / 10)) with C = 0.0573 sqrt(1 + 0.15 U)."""
    return mean * (1.0 + 0.0573 * math.sqrt(1.0 + 0.15 * mean) * math.log(height / REFERENCE_HEIGHT))


def spectrum(frequency: FloatArray, mean: float, height: float) -> FloatArray:
    """Return S(f), m^2/s, of the wind speed along the mean wind.

    S = 320 (U/10)^2 (z/10)^0.45 / (1 + f~^n)^(5/(3n)) with f~ = 172 f (z/10)^(2/3) (U/10)^(-3/4) and n = 0.468.

    Parameters
    ----------
    frequency
        Hz, any shape.
    mean
        U, m/s, above 0.
    height
        z, m, above 0.
    """
    level, time = _level_and_time(mean, height)
    return np.asarray(level / (1.0 + (time * frequency) ** _EXPONENT) ** _POWER)


def variance_below(frequency: FloatArray, mean: float, height: float) -> FloatArray:
    """Return the integral of :func:`spectrum` from 0 to ``frequency``, m^2/s^2, in closed form.

    The integral of (1 + (a f)^n)^-p is f 2F1(p, 1/n; 1 + 1/n; -(a f)^n).
    """
    from scipy.special import hyp2f1  # here: its import is slow

    level, time = _level_and_time(mean, height)
    inverse = 1.0 / _EXPONENT
    return np.asarray(
        level * frequency * hyp2f1(_POWER, inverse, 1.0 + inverse, -((time * frequency) ** _EXPONENT)),
        dtype=np.float64,
    )


def _level_and_time(mean: float, height: float) -> tuple[float, float]:
    z, u = height / REFERENCE_HEIGHT, mean / 10.0
    return 320.0 * u * u * z**0.45, 172.0 * z ** (2.0 / 3.0) * u**-0.75
