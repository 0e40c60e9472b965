"""Surge and sway of four azimuth propellers beside a yaw moment: at one common angle, and each at its own.

With p = X / cos a, q = Y / sin a and r = N / (d sin(a + phi)) the thrusts at the common angle a are

    f = (sx p - sy q - sx sy r + w) / 4

where w is free: it gives no force, and the pseudo-inverse sets it to 0. The best w brings the largest of them to a
quarter of the sum of the two largest of |p|, |q|, |r|, so that all that can be given at the angle is

    |p| + |q| <= 4 f_max,    |p| + |r| <= 4 f_max,    |q| + |r| <= 4 f_max

against |p| + |q| + |r| <= 4 f_max by the pseudo-inverse, and (17) of [Garus-A], which takes the largest |r| of all
angles. A moment of either sign, and any smaller one, can be had with the same surge and sway: the sets hold for all.
"""

from __future__ import annotations

import numpy as np

from dp_tools.compare.polytope import Polytope
from marine_model.guards import FloatArray
from thrust_allocator.feasible import AzimuthSquare

_ANGLES = 361
_REFINEMENTS = 4
_FINER = 20
_TANGENTS = 1440
_BISECTIONS = 70


def load_together(
    square: AzimuthSquare, moment: float, surge: FloatArray, sway: FloatArray, angle: FloatArray | float
) -> FloatArray:
    """Return how many times surge and sway (N, shape (...)) are what can be given at the common ``angle``.

    At most 1 if they can be given beside ``moment`` (N m), by any thrusts within limits. ``angle`` is one for all
    demands or one each, rad.
    """
    total = 4.0 * square.thrust_max
    rest = total - moment / (square.distance * np.sin(np.asarray(angle) + square.bearing))
    p, q = _over(np.abs(surge), np.cos(angle)), _over(np.abs(sway), np.sin(angle))
    with np.errstate(divide="ignore", invalid="ignore"):
        load: FloatArray = np.where(rest > 0.0, np.maximum((p + q) / total, np.maximum(p, q) / rest), np.inf)
    return load


def best_together(
    square: AzimuthSquare, moment: float, surge: FloatArray, sway: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the least :func:`load_together` over all angles from 0 to pi/2, and that angle (rad); shapes (...).

    A grid of a quarter of a degree, and around its best angle finer ones: to 1e-6 of the load.
    """
    grid = np.linspace(0.0, np.pi / 2.0, _ANGLES)
    loads = np.array([load_together(square, moment, surge, sway, angle) for angle in grid])
    at = np.argmin(loads, axis=0)
    angles, best = grid[at], np.take_along_axis(loads, at[None], axis=0)[0]
    step = grid[1]
    for _ in range(_REFINEMENTS):
        centre = angles
        for offset in np.linspace(-step, step, 2 * _FINER + 1):
            tried = np.clip(centre + offset, 0.0, np.pi / 2.0)
            load = load_together(square, moment, surge, sway, tried)
            better = load < best
            angles, best = np.where(better, tried, angles), np.where(better, load, best)
        step /= _FINER
    return best, angles


def outline_together(square: AzimuthSquare, moment: float, bearings: FloatArray) -> FloatArray:
    """Return the boundary of what can be given at some common angle, along ``bearings`` (k,) from surge to sway, rad.

    Shape (k, 2): surge, sway, N. The set is no convex one, but holds with every point all that is nearer along its ray.
    """
    rays = np.column_stack([np.cos(bearings), np.sin(bearings)])
    loads, _ = best_together(square, moment, rays[:, 0], rays[:, 1])
    outline: FloatArray = rays / loads[:, None]
    return outline


def apart(square: AzimuthSquare, moment: float) -> Polytope:
    """Return surge and sway (N) that can be given beside ``moment`` (N m) when every propeller has its own angle.

    Of forces T_j in discs, the largest n'F with the moment given is, by duality, the least over l of
    sum_j f_max |n + l t_j| - l N, t_j being the moment of a newton along either axis. The set is what 1440 tangents
    enclose, 2e-6 more than it is.
    """
    bearings = np.linspace(0.0, 2.0 * np.pi, _TANGENTS, endpoint=False)
    normals = np.column_stack([np.cos(bearings), np.sin(bearings)])
    where = (
        np.column_stack([square.sign_x * np.cos(square.bearing), square.sign_y * np.sin(square.bearing)])
        * square.distance
    )
    turning = np.column_stack([-where[:, 1], where[:, 0]])

    def reach(level: FloatArray) -> FloatArray:
        found: FloatArray = normals[:, None, :] + level[:, None, None] * turning
        return found

    def short(level: FloatArray) -> FloatArray:
        """Return how much moment is missing at ``level``."""
        along = reach(level)
        size = np.maximum(np.linalg.norm(along, axis=2), np.finfo(float).tiny)
        given = square.thrust_max * ((along * turning).sum(axis=2) / size).sum(axis=1)
        missing: FloatArray = moment - given
        return missing

    low, high = np.zeros(_TANGENTS), np.full(_TANGENTS, 1.0 / square.distance)
    while (short(high) > 0.0).any():
        high *= 2.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        missing = short(middle) > 0.0
        low, high = np.where(missing, middle, low), np.where(missing, high, middle)
    heights = square.thrust_max * np.linalg.norm(reach(high), axis=2).sum(axis=1) - high * moment
    return Polytope(normals, heights)


def area_of(outline: FloatArray) -> float:
    """Return the area within an outline (k, 2)."""
    x, y = outline.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _over(force: FloatArray, part: FloatArray | float) -> FloatArray:
    """Return force / part, 0 for no force and infinite where there is no part of it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found: FloatArray = np.where(force > 0.0, force / np.where(np.asarray(part) > 1e-15, part, 0.0), 0.0)
    return found
