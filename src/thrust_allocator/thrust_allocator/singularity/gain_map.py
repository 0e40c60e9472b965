"""Minimum gain over the angles of two thrusters, for several failures at once: [Ruth] Figures 7.4-7.13."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from marine_model import Vessel
from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector
from thrust_allocator.singularity.gain import GainMethod, method_number
from thrust_allocator.singularity.minimum_norm import IntArray
from thrust_allocator.singularity.scaling import BoolArray, Scaling, mask, scaled_configuration, scaling_of
from thrust_allocator.singularity.theorem import gain_of


def gain_map(
    vessel: Vessel | Scaling,
    thrusters: tuple[int, int],
    angles: tuple[ArrayLike, ArrayLike],
    azimuth: ArrayLike,
    enabled: ArrayLike | None = None,
    unidirectional: ArrayLike | None = None,
    method: GainMethod = "auto",
) -> FloatArray:
    """Return the minimum gain of fixed thrusters, shape (cases, first angles, second angles).

    Parameters
    ----------
    vessel
        A vessel, or its scaling (with equal maximum thrusts for Figures 7.4-7.9).
    thrusters
        Indices of the two azimuth thrusters whose angles vary.
    angles
        Their angles, two vectors, rad.
    azimuth
        Angles of all, shape (n,), rad; those of the two are not used.
    enabled
        Bool masks, shape (cases, n). None: one case, all thrusters.
    unidirectional
        Bool mask over thrusters, shape (n,). None: all are bidirectional.
    method
        As in `minimum_gain`.

    Raises
    ------
    InputError
        If a shape or type is wrong, a number not finite, or ``thrusters`` are not two azimuth thrusters.
    """
    scaling = vessel if isinstance(vessel, Scaling) else scaling_of(vessel)
    n = scaling.count
    first, second = thrusters
    if first == second or not all(0 <= j < n and scaling.azimuth_thruster[j] for j in thrusters):
        raise InputError(f"thrusters: expected indices of two azimuth thrusters below {n}, found {thrusters}")
    base = finite_vector("azimuth", azimuth, n)
    cases = np.ones((1, n), dtype=np.bool_) if enabled is None else np.asarray(enabled)
    if cases.ndim != 2 or cases.shape[1] != n or cases.dtype != np.bool_:
        raise InputError(f"enabled: expected bools of shape (cases, {n}), found {cases.shape} of {cases.dtype}")
    kind = mask("unidirectional", unidirectional, n, default=False).astype(np.int64)
    number = method_number(method, 3, bool(kind.any()))
    columns = []
    for j, values in zip(thrusters, angles, strict=True):
        grid = finite_vector(f"angles of thruster {j}", values, np.size(values))
        columns.append(_columns_over(scaling, j, grid))
    gains = np.empty((len(cases), len(columns[0]), len(columns[1])))
    fixed = scaled_configuration(scaling, base)
    _fill(fixed, first, columns[0], second, columns[1], np.ascontiguousarray(cases), kind, number, gains)
    return gains


def _columns_over(scaling: Scaling, j: int, angles: FloatArray) -> FloatArray:
    """Return thruster j's column of B_S at each angle, shape (len(angles), 3)."""
    c, s = np.cos(angles), np.sin(angles)
    moment = (scaling.lever_x[j] * s - scaling.lever_y[j] * c) / scaling.typical_arm
    columns: FloatArray = np.column_stack([c, s, moment]) * (scaling.thrust_max[j] / scaling.mean_thrust_max)
    return columns


@compiled
def _fill(
    fixed: FloatArray,
    first: int,
    first_columns: FloatArray,
    second: int,
    second_columns: FloatArray,
    cases: BoolArray,
    kind: IntArray,
    method: int,
    gains: FloatArray,
) -> None:
    n = fixed.shape[1]
    direction = np.empty(3)
    for case in range(len(cases)):
        used = 0
        for j in range(n):
            used += 1 if cases[case, j] else 0
        B = np.zeros((3, used))
        kinds = np.zeros(used, dtype=np.int64)
        edges = np.zeros((used, 4))
        here, there, i = -1, -1, 0
        for j in range(n):
            if cases[case, j]:
                for a in range(3):
                    B[a, i] = fixed[a, j]
                kinds[i] = kind[j]
                here = i if j == first else here
                there = i if j == second else there
                i += 1
        for p in range(len(first_columns)):
            if here >= 0:
                for a in range(3):
                    B[a, here] = first_columns[p, a]
            for q in range(len(second_columns)):
                if there >= 0:
                    for a in range(3):
                        B[a, there] = second_columns[q, a]
                gains[case, p, q] = gain_of(B, kinds, edges, method, direction)
