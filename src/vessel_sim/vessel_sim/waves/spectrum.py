"""JONSWAP wave spectrum."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number, positive_number

_WIDTH_BELOW, _WIDTH_ABOVE = 0.07, 0.09  # of the peak, over its frequency (Hasselmann et al. 1973)
_GRID = 20_001


@dataclass(frozen=True)
class Jonswap:
    """S(omega; H_s, T_p, gamma) with 4 sqrt(m_0) = H_s, m_0 the integral of S.

    S = H_s^2 / (16 omega_p I) x^-5 exp(-5/4 x^-4) gamma^exp(-(x - 1)^2 / (2 sigma^2)), x = omega / omega_p, with
    sigma = 0.07 below the peak and 0.09 above. I is the integral of what depends on x, by quadrature: the usual
    0.2 / (1 - 0.287 ln gamma) is a fit to it. Without a peak, gamma = 1, this is the spectrum of two parameters of the
    ITTC (Bretschneider).

    Parameters
    ----------
    significant_height
        H_s, m, above 0.
    peak_period
        T_p, s, above 0.
    peakedness
        gamma, at least 1 (Pierson-Moskowitz).

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    significant_height: float
    peak_period: float
    peakedness: float = 3.3

    def __post_init__(self) -> None:
        positive_number("significant_height", self.significant_height)
        positive_number("peak_period", self.peak_period)
        if finite_number("peakedness", self.peakedness) < 1.0:
            raise InputError(f"peakedness: expected at least 1, found {self.peakedness}")

    @property
    def peak_frequency(self) -> float:
        """omega_p, rad/s."""
        return 2.0 * math.pi / self.peak_period

    @cached_property
    def _shape_integral(self) -> float:
        from scipy.integrate import quad  # here: its import is slow

        below, _ = quad(self._shape, 0.0, 1.0)
        above, _ = quad(self._shape, 1.0, 3.0)
        tail, _ = quad(self._shape, 3.0, math.inf)
        return float(below + above + tail)

    def _shape(self, x: ArrayLike) -> FloatArray:
        ratio = np.asarray(x, dtype=np.float64)
        # exp(-5/4 x^-4) is below the smallest number for x < 0.2.
        safe = np.maximum(ratio, 0.1)
        width = np.where(safe <= 1.0, _WIDTH_BELOW, _WIDTH_ABOVE)
        peak = self.peakedness ** np.exp(-0.5 * ((safe - 1.0) / width) ** 2)
        return np.where(ratio > 0.1, safe**-5.0 * np.exp(-1.25 * safe**-4.0) * peak, 0.0)

    def density(self, omega: ArrayLike) -> FloatArray:
        """Return S, m^2 s, one-sided over ``omega`` (rad/s)."""
        x = np.asarray(omega, dtype=np.float64) / self.peak_frequency
        scale = self.significant_height**2 / (16.0 * self.peak_frequency * self._shape_integral)
        return scale * self._shape(x)

    def frequencies(self, share: ArrayLike, cutoff: float) -> FloatArray:
        """Return the frequencies (rad/s) below which lies ``share`` of the energy up to ``cutoff`` omega_p.

        Parameters
        ----------
        share
            In [0, 1].
        cutoff
            Highest frequency over that of the peak.
        """
        from scipy.integrate import cumulative_trapezoid  # here: its import is slow

        x = np.linspace(0.1, cutoff, _GRID)
        energy = cumulative_trapezoid(self._shape(x), x, initial=0.0)
        return np.interp(np.asarray(share, dtype=np.float64), energy / energy[-1], x) * self.peak_frequency
