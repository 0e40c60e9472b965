"""Minimum gain over the angles of two thrusters, whole and with each thruster lost: [Ruth] Figures 7.4-7.13."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.plan import Plan
from benchmarks.result import Aim, Result
from benchmarks.statistics import summarize
from marine_model import Vessel, load_vessel
from marine_model.guards import FloatArray
from thrust_allocator.singularity import Scaling, gain_map, scaling_of

_ANGLES = 72
_REPETITIONS = 5
_SECOND = Aim("value", "<=", 1.0)


def measure_gain_map(plan: Plan) -> list[Result]:
    """Measure a map with all thrusters bidirectional, and with the azimuth thrusters unidirectional."""
    vessel = load_vessel(plan.vessel)
    n = len(vessel.thrusters)
    turning = [j for j, turns in enumerate(vessel.can_rotate) if turns]
    thrusters = turning[-2], turning[-1]
    angles = np.linspace(-np.pi, np.pi, _ANGLES, endpoint=False)
    enabled = np.vstack([np.ones((1, n), dtype=np.bool_), ~np.eye(n, dtype=np.bool_)])
    results = []
    for name, one_way in (
        ("bidirectional", np.zeros(n, dtype=np.bool_)),
        ("unidirectional", np.array(vessel.can_rotate)),
    ):

        def draw(grid: FloatArray, mask: Any = one_way) -> FloatArray:
            return np.asarray(gain_map(vessel, thrusters, (grid, grid), vessel.fixed_direction, enabled, mask))

        begin = time.perf_counter()
        draw(angles[:2])  # machine code is made or loaded
        first = time.perf_counter() - begin
        times, theirs = [], []
        found = np.zeros(0)
        for _ in range(_REPETITIONS):
            begin = time.perf_counter()
            found = draw(angles)
            times.append(time.perf_counter() - begin)
            if name == "bidirectional":
                begin = time.perf_counter()
                peer = _by_svd(vessel, scaling_of(vessel), thrusters, angles, enabled)
                theirs.append(time.perf_counter() - begin)
        size = " x ".join(map(str, found.shape))
        note = f"{size} configurations, median of {_REPETITIONS}; first call of all {first:.2f} s"
        if theirs:
            note += f"; largest difference to numpy's singular values {float(np.abs(found - peer).max()):.1g}"
        results.append(
            Result(
                f"gain_map_{name}",
                summarize(times).median,
                "s",
                "numpy.linalg.svd, one call for each failure" if theirs else None,
                summarize(theirs).median if theirs else None,
                _SECOND,
                note,
            )
        )
    return results


def _by_svd(
    vessel: Vessel, scaling: Scaling, thrusters: tuple[int, int], angles: FloatArray, enabled: Any
) -> FloatArray:
    """Return the smallest singular value of the scaled configuration, [Ruth] (7.1), shape (cases, angles, angles)."""
    first, second = np.meshgrid(angles, angles, indexing="ij")
    azimuth = np.broadcast_to(vessel.fixed_direction, (*first.shape, len(vessel.thrusters))).copy()
    azimuth[..., thrusters[0]], azimuth[..., thrusters[1]] = first, second
    c, s = np.cos(azimuth), np.sin(azimuth)
    moment = (scaling.lever_x * s - scaling.lever_y * c) / scaling.typical_arm
    matrix = np.stack([c, s, moment], axis=-2) * (scaling.thrust_max / scaling.mean_thrust_max)
    return np.array([np.linalg.svd(matrix[..., mask], compute_uv=False)[..., -1] for mask in enabled])
