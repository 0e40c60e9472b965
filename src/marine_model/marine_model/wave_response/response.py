"""Response of a hull to regular waves, non-dimensional: one table serves every scale of a hull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_model.errors import InputError
from marine_model.guards import FloatArray

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class WaveResponse:
    """First-order motion and mean drift in regular deep-water waves, at zero speed.

    With length L between perpendiculars and waves of amplitude a and phase
    theta = k (north cos beta + east sin beta) - omega t + epsilon at the origin of the body (midships, in the
    waterline), a mode moves by x(t) = a Re[X exp(i theta)] in the body axes: surge ahead, sway to starboard, heave
    down, roll with starboard down, pitch with the bow up, yaw clockwise from above. Headings b are relative
    directions beta - heading, 0 for waves that travel ahead, pi for head seas.

    The hull is symmetric to port and starboard: b < 0 changes the sign of sway, roll and yaw, in motion and drift.

    Parameters
    ----------
    frequency
        omega sqrt(L / g), rising, above 0, shape (nf,).
    heading
        b from 0 to pi, rad, rising, shape (nh,).
    motion
        X, shape (nf, nh, 6): surge, sway, heave over a; roll, pitch, yaw over a / L.
    drift
        Mean second-order force, body axes, shape (nf, nh, 3): surge, sway over rho g L a^2; yaw over rho g L^2 a^2.
    """

    frequency: FloatArray
    heading: FloatArray
    motion: ComplexArray
    drift: FloatArray

    def at(self, frequency: ArrayLike) -> tuple[ComplexArray, FloatArray]:
        """Return motion, shape (m, nh, 6), and drift, shape (m, nh, 3), at other frequencies.

        Linear between the frequencies of the table. Below them, as the square of the frequency from the long-wave
        limit: a hull that goes with the water at its surface, translations (i cos b, i sin b, -1), slopes that vanish
        with k and no drift. Above them motion falls off with the square of the frequency, as that of a mass under a
        force that does not grow, and drift, a reflection by then, stays as it is.

        Parameters
        ----------
        frequency
            omega sqrt(L / g), at least 0, shape (m,).

        Raises
        ------
        InputError
            If a frequency is not finite or below 0.
        """
        wanted = np.atleast_1d(np.asarray(frequency, dtype=np.float64))
        if wanted.ndim != 1 or not np.isfinite(wanted).all() or (wanted < 0.0).any():
            raise InputError(f"frequency: expected finite numbers of at least 0, found {frequency!r}")
        lowest, highest = self.frequency[0], self.frequency[-1]
        inside = np.clip(wanted, lowest, highest)
        i = np.clip(np.searchsorted(self.frequency, inside, side="right") - 1, 0, len(self.frequency) - 2)
        share = ((inside - self.frequency[i]) / (self.frequency[i + 1] - self.frequency[i]))[:, None, None]
        motion = (1.0 - share) * self.motion[i] + share * self.motion[i + 1]
        drift = (1.0 - share) * self.drift[i] + share * self.drift[i + 1]
        long = (np.minimum(wanted / lowest, 1.0) ** 2)[:, None, None]
        short = (np.minimum(highest / np.maximum(wanted, highest), 1.0) ** 2)[:, None, None]
        return (1.0 - long) * self._in_long_waves() + long * short * motion, long * drift

    def _in_long_waves(self) -> ComplexArray:
        """Motion for k -> 0, shape (nh, 6)."""
        limit = np.zeros((len(self.heading), 6), dtype=np.complex128)
        limit[:, 0] = 1j * np.cos(self.heading)
        limit[:, 1] = 1j * np.sin(self.heading)
        limit[:, 2] = -1.0
        return limit
