"""A second implementation of [Ruth] 4.4.2, from the print and by another method, to hold the allocator against.

The quadratic program is solved as least squares with inequalities by the dual of Lawson and Hanson (least distance
programming over non-negative least squares), and the answer's active set is solved once more by itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular
from scipy.optimize import nnls

from marine_model import Vessel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reference:
    """Optimum of one step: components (n,) in N, and the cost (4.20)."""

    force_x: Array
    force_y: Array
    cost: float


def reference(
    vessel: Vessel,
    rotating: list[bool],
    thrust: Array,
    azimuth: Array,
    tau: Array,
    dt: float,
    limit_scale: Array | float = 1.0,
    rate_scale: Array | float = 1.0,
    lost: Array | bool = False,
) -> Reference:
    """Solve (4.20)-(4.42); the fixed thrusters point along ``azimuth`` in this step.

    A lost one gives nothing: its columns are zero, which leaves it at whatever its window has that costs least, so that
    the window is opened to zero and its weight is kept.
    """
    gains = vessel.allocator
    n = len(thrust)
    c1, c2 = gains.approach_fraction, gains.zero_region
    step = vessel.thrust_rate * dt
    turn = rate_scale * vessel.azimuth_rate * dt
    gone = np.broadcast_to(np.asarray(lost), n)
    span = vessel.thrust_max - vessel.thrust_min
    least = np.where(rotating, -c2 * span, limit_scale * vessel.thrust_min)
    t_high = np.maximum(np.minimum(limit_scale * vessel.thrust_max, thrust + step), thrust - c1 * step)  # (4.14)
    t_low = np.minimum(np.maximum(least, thrust - step), thrust + c1 * step)  # (4.15)

    t_high, t_low = np.where(gone, 1.0, t_high), np.where(gone, -1.0, t_low)

    # (4.24), over x = [T_x, T_y]
    B = np.zeros((3, 2 * n))
    B[0, :n] = B[1, n:] = 1.0
    B[2, :n], B[2, n:] = -vessel.lever_y, vessel.lever_x
    B[:, np.tile(gone, 2)] = 0.0
    rows: list[Array] = []
    limits: list[float] = []

    def at_least(j: int, a_x: float, a_y: float, constant: float) -> None:
        """a_x T_x,j + a_y T_y,j + constant >= 0"""
        row = np.zeros(2 * n)
        row[j], row[n + j] = -a_x, -a_y
        rows.append(row)
        limits.append(constant)

    basis = []
    for j in range(n):
        if not rotating[j]:
            c, s = math.cos(azimuth[j]), math.sin(azimuth[j])
            at_least(j, c, s, -t_low[j])  # (4.30)
            at_least(j, -c, -s, t_high[j])  # (4.34)
            column = np.zeros(2 * n)
            column[j], column[n + j] = c, s  # all that (4.28) leaves
            basis.append(column)
            continue
        low, high = azimuth[j] - turn[j], azimuth[j] + turn[j]
        region = c2 * (t_high[j] - t_low[j])  # without the |cos| of the print
        at_least(j, -math.sin(low), math.cos(low), region)  # (4.38)
        at_least(j, math.sin(high), -math.cos(high), region)  # (4.39)
        at_least(j, math.cos(azimuth[j]), math.sin(azimuth[j]), min(-t_low[j], region))  # (4.40), the region square
        for end in (low, high):  # (4.41), (4.42)
            at_least(j, -math.cos(end), -math.sin(end), math.cos(end - azimuth[j]) * t_high[j])
        basis += [np.eye(2 * n)[j], np.eye(2 * n)[n + j]]

    N = np.column_stack(basis)
    gamma_w = gains.slack_gain * np.array(gains.slack_weight)
    W = np.tile(np.array(gains.thrust_weight), 2)
    # || gamma W_v (tau - B N z) ||^2 + || W_u N z ||^2
    E = np.vstack([gamma_w[:, None] * (B @ N), W[:, None] * N])
    f = np.concatenate([gamma_w * tau, np.zeros(2 * n)])
    z = _least_squares(E, f, np.array(rows) @ N, np.array(limits))
    x = N @ z
    residual = E @ z - f
    return Reference(x[:n], x[n:], float(residual @ residual))


def _least_squares(E: Array, f: Array, G: Array, h: Array) -> Array:
    """Minimise || E z - f || subject to G z <= h; E has full column rank."""
    Q, R = qr(E, mode="economic")
    q = Q.T @ f
    M = solve_triangular(R, G.T, trans="T").T  # G z = M (y + q), y = R z - q
    d = h - M @ q
    size = np.linalg.norm(M, axis=1)
    M, d = M / size[:, None], d / size
    if (d >= 0.0).all():
        return solve_triangular(R, q)
    scale = np.abs(d).max()
    u, _ = nnls(np.vstack([-M.T, -d / scale]), np.append(np.zeros(M.shape[1]), 1.0))
    active = u > 0.0
    y, *_ = np.linalg.lstsq(M[active], d[active], rcond=None)
    multipliers, *_ = np.linalg.lstsq(M[active].T, -y, rcond=None)
    # The conditions of Karush, Kuhn and Tucker, in the norm of the cost: without them this is no reference.
    if (M @ y - d).max() > 1e-7 * scale or multipliers.min() < -1e-7 * scale:
        raise ArithmeticError("the reference has not found the optimum")
    return solve_triangular(R, y + q)
