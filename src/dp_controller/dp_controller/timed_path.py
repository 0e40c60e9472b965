"""A timed path: poses with times, interpolated smoothly."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import ArrayLike

from dp_controller.vectors import ZERO, Triple
from marine_model.errors import InputError
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray

# Points of a segment at which its speed is looked at, with both ends.
_SPEED_POINTS = 9


class TimedPath:
    """Position and velocity as functions of time through given poses.

    Between two poses every coordinate is a cubic with the slopes of Fritsch and Butland (SIAM J. Sci. Stat. Comput.
    5(2), 1984): velocity is continuous, no coordinate leaves the interval between two poses, and a part sailed at
    constant velocity stays one. The vessel is at rest at the first and the last pose, holds the first before the start
    and the last after the end. From one pose to the next the heading turns the shorter way; so a turn of 180 degrees
    or more needs poses in between.

    Parameters
    ----------
    times
        Shape (k,), s, increasing, k >= 1.
    positions
        Shape (k, 3): north (m), east (m), heading (rad).

    Raises
    ------
    InputError
        If a shape is wrong, a number is not finite, or times do not increase.
    """

    def __init__(self, times: ArrayLike, positions: ArrayLike) -> None:
        t, poses = _checked(times, positions)
        turns = wrap_angles(np.diff(poses[:, 2]))
        heading = np.concatenate((poses[:1, 2], poses[0, 2] + np.cumsum(turns)))
        knots = np.column_stack((poses[:, :2], heading))
        slopes = _slopes(t, knots)
        self._times: list[float] = t.tolist()
        self._knots: list[list[float]] = knots.tolist()
        self._slopes: list[list[float]] = slopes.tolist()

    @property
    def start(self) -> float:
        """Time of the first pose, s."""
        return self._times[0]

    @property
    def end(self) -> float:
        """Time of the last pose, s."""
        return self._times[-1]

    def __len__(self) -> int:
        return len(self._times)

    def at(self, time: float) -> tuple[Triple, Triple]:
        """Return position (heading not wrapped) and its rate of change, NED, at ``time`` (s)."""
        times = self._times
        if time <= times[0]:
            return _triple(self._knots[0]), ZERO
        if time >= times[-1]:
            return _triple(self._knots[-1]), ZERO
        i = bisect_right(times, time) - 1
        h = times[i + 1] - times[i]
        u = (time - times[i]) / h
        w = 1.0 - u
        # Cubic Hermite basis and its derivative, slopes scaled by h.
        b0, b1 = w * w * (1.0 + 2.0 * u), u * u * (3.0 - 2.0 * u)
        s0, s1 = h * u * w * w, -h * u * u * w
        d = 6.0 * u * w / h
        e0, e1 = w * (1.0 - 3.0 * u), u * (3.0 * u - 2.0)
        p, q, m, n = self._knots[i], self._knots[i + 1], self._slopes[i], self._slopes[i + 1]
        return (
            (
                b0 * p[0] + b1 * q[0] + s0 * m[0] + s1 * n[0],
                b0 * p[1] + b1 * q[1] + s0 * m[1] + s1 * n[1],
                b0 * p[2] + b1 * q[2] + s0 * m[2] + s1 * n[2],
            ),
            (
                d * (q[0] - p[0]) + e0 * m[0] + e1 * n[0],
                d * (q[1] - p[1]) + e0 * m[1] + e1 * n[1],
                d * (q[2] - p[2]) + e0 * m[2] + e1 * n[2],
            ),
        )

    def body_speeds(self) -> FloatArray:
        """Return the largest |surge|, |sway| (m/s) and |yaw rate| (rad/s) along the path, shape (3,)."""
        if len(self) < 2:
            return np.zeros(3)
        t = np.array(self._times)
        u = np.linspace(0.0, 1.0, _SPEED_POINTS)[:, None, None]
        h = np.diff(t)[None, :, None]
        p, q = np.array(self._knots[:-1])[None], np.array(self._knots[1:])[None]
        m, n = np.array(self._slopes[:-1])[None], np.array(self._slopes[1:])[None]
        w = 1.0 - u
        velocity = 6.0 * u * w * (q - p) / h + w * (1.0 - 3.0 * u) * m + u * (3.0 * u - 2.0) * n
        position = w**2 * (1.0 + 2.0 * u) * p + u**2 * (3.0 - 2.0 * u) * q + h * u * w * (w * m - u * n)
        heading = position[..., 2]
        c, s = np.cos(heading), np.sin(heading)
        surge = c * velocity[..., 0] + s * velocity[..., 1]
        sway = c * velocity[..., 1] - s * velocity[..., 0]
        return np.array([np.abs(part).max() for part in (surge, sway, velocity[..., 2])])


def _triple(values: list[float]) -> Triple:
    return values[0], values[1], values[2]


def _checked(times: ArrayLike, positions: ArrayLike) -> tuple[FloatArray, FloatArray]:
    try:
        t = np.array(times, dtype=np.float64)
        poses = np.array(positions, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"path: expected numbers, found {error}") from error
    if t.ndim != 1 or t.size == 0:
        raise InputError(f"path times: expected shape (k,) with k of at least 1, found {t.shape}")
    if poses.shape != (t.size, 3):
        raise InputError(f"path positions: expected shape ({t.size}, 3), found {poses.shape}")
    for name, array in (("times", t), ("positions", poses)):
        bad = np.flatnonzero(~np.isfinite(array.reshape(t.size, -1)).all(axis=1))
        if bad.size:
            raise InputError(f"path {name}: expected finite numbers, found {array[bad[0]].tolist()} at pose {bad[0]}")
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if back.size:
        i = int(back[0])
        raise InputError(f"path times: expected them to increase, found {t[i + 1]} s after {t[i]} s at pose {i + 1}")
    return t, poses


def _slopes(t: FloatArray, knots: FloatArray) -> FloatArray:
    """Return the slope of every coordinate at every pose, shape (k, 3)."""
    slopes = np.zeros_like(knots)
    if len(t) < 3:
        return slopes
    h = np.diff(t)[:, None]
    secant = np.diff(knots, axis=0) / h
    left, right = secant[:-1], secant[1:]
    before, after = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    same_way = left * right > 0.0
    # Weighted harmonic mean; zero at a turning point of the coordinate.
    denominator = np.where(same_way, before * right + after * left, 1.0)
    slopes[1:-1] = np.where(same_way, (before + after) * left * right / denominator, 0.0)
    return slopes
