"""Interpolation between pitch ratios: cubic splines, which are linear in what is interpolated."""

from __future__ import annotations

import numpy as np

from marine_model.guards import FloatArray


class PitchInterpolation:
    """Cubic spline over pitch ratios (a parabola through three, a line through two, a constant for one).

    Parameters
    ----------
    pitch_ratio
        P/D, shape (p,), rising.
    """

    def __init__(self, pitch_ratio: FloatArray) -> None:
        self._pitch_ratio = pitch_ratio

    @property
    def breaks(self) -> FloatArray:
        """Ends of the pieces, shape (pieces + 1,)."""
        return self._pitch_ratio if len(self._pitch_ratio) > 1 else np.repeat(self._pitch_ratio, 2)

    def weights(self, pitch_ratio: FloatArray) -> FloatArray:
        """Return what every known pitch ratio counts for at ``pitch_ratio``: shape (*shape of it, p)."""
        if len(self._pitch_ratio) == 1:
            return np.ones((*np.shape(pitch_ratio), 1))
        # SciPy is loaded where a table is: observer and controller, which read vessel files, do without.
        from scipy.interpolate import CubicSpline

        return np.asarray(CubicSpline(self._pitch_ratio, np.eye(len(self._pitch_ratio)))(pitch_ratio))

    def pieces(self, values: FloatArray) -> FloatArray:
        """Return the polynomials of ``values``, shape (p, ...): shape (pieces, ..., terms), lowest power first."""
        if len(self._pitch_ratio) == 1:
            return values[..., None]
        from scipy.interpolate import CubicSpline

        coefficients = np.asarray(CubicSpline(self._pitch_ratio, values, axis=0).c)
        return np.moveaxis(coefficients[::-1], 0, -1)
