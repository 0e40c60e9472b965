"""A hull form from main dimensions: smooth, and symmetric fore and aft as well as to port and starboard.

Nothing is known of the lines of the hulls in question, so no difference between bow and stern is made up.
With xi = 2 x / L, zeta the depth over the draught, B the beam and C_B the block coefficient:

    half breadth of the waterline      (B / 2) (1 - |xi|^n),  n = C_W / (1 - C_W)
    section at xi                      superellipse, (y / half breadth)^m + zeta^m = 1
    area coefficient of that section   C_M - d xi^2, which fixes m

C_M = 1 / (1 + (1 - C_B)^3.5) (Schneekluth and Bertram, Ship Design for Efficiency and Economy, 1998) and, for twin
screws and a transom stern, C_W = 0.262 + 0.810 C_B / C_M (Eames, in Parsons, Parametric Design, 2003). d is the one
free parameter: it is such that the panels enclose the volume that the ship displaces. The keel is flat from end to end;
trim is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import gammaln

Array = NDArray[np.float64]

# Below this a section is little more than a fin.
_LEAST_SECTION = 0.2
_CURVE_POINTS = 2001


@dataclass(frozen=True)
class HullForm:
    """One member of the family; lengths in m.

    Parameters
    ----------
    length, beam, draught
        Main dimensions.
    waterplane, midship
        C_W and C_M.
    fining
        d.
    """

    length: float
    beam: float
    draught: float
    waterplane: float
    midship: float
    fining: float

    @classmethod
    def of(cls, length: float, beam: float, draught: float, volume: float) -> HullForm:
        """Return the form whose volume (m^3) is exact before it is cut into panels.

        Raises
        ------
        ValueError
            If no such hull has this volume.
        """
        block = volume / (length * beam * draught)
        if not 0.4 <= block <= 0.95:
            raise ValueError(f"block coefficient: expected 0.4 to 0.95, found {block:.3f}")
        midship = 1.0 / (1.0 + (1.0 - block) ** 3.5)
        waterplane = 0.262 + 0.810 * block / midship
        n = waterplane / (1.0 - waterplane)
        # Integral of (1 - xi^n) (C_M - d xi^2) over 0 < xi < 1 is C_B.
        fining = (midship * waterplane - block) / (1.0 / 3.0 - 1.0 / (n + 3.0))
        if midship - fining < _LEAST_SECTION:
            raise ValueError(
                f"section at the ends: expected an area coefficient of at least {_LEAST_SECTION}, "
                f"found {midship - fining:.2f}"
            )
        return cls(length, beam, draught, waterplane, midship, fining)

    @property
    def exponent(self) -> float:
        """n, of the waterline."""
        return self.waterplane / (1.0 - self.waterplane)

    def half_breadth(self, xi: Array) -> Array:
        """Half breadth of the waterline, m, at xi in 0 ... 1."""
        return 0.5 * self.beam * (1.0 - xi**self.exponent)

    def stations(self, count: int) -> Array:
        """``count`` + 1 values of xi from midships to the end, evenly spaced along the waterline."""
        xi = np.linspace(0.0, 1.0, _CURVE_POINTS)
        return _evenly(0.5 * self.length * xi, self.half_breadth(xi), xi, count)

    def section(self, xi: float, count: int) -> tuple[Array, Array]:
        """``count`` + 1 points (y, z), m, of half a section from the waterline to the keel, evenly spaced."""
        m = superellipse_exponent(self.midship - self.fining * xi**2)
        half = float(self.half_breadth(np.array(xi)))
        angle = np.linspace(0.0, 0.5 * np.pi, _CURVE_POINTS)
        cosine, sine = np.cos(angle), np.sin(angle)
        cosine[-1] = 0.0
        # In the polar angle of the unit curve its corners stay well spaced however large m is.
        radius = (cosine**m + sine**m) ** (-1.0 / m)
        y, z = half * radius * cosine, -self.draught * radius * sine
        return _evenly(y, z, y, count), _evenly(y, z, z, count)


def superellipse_exponent(coefficient: float) -> float:
    """Return m of |y|^m + |z|^m = 1 that covers ``coefficient`` of its box: Gamma(1 + 1/m)^2 / Gamma(1 + 2/m)."""

    def excess(m: float) -> float:
        return float(np.exp(2.0 * gammaln(1.0 + 1.0 / m) - gammaln(1.0 + 2.0 / m)) - coefficient)

    return float(brentq(excess, 0.3, 1000.0))


def _evenly(x: Array, y: Array, value: Array, count: int) -> Array:
    """Interpolate ``value`` at evenly spaced lengths of the curve (x, y)."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    return np.interp(np.linspace(0.0, length[-1], count + 1), length, value)
