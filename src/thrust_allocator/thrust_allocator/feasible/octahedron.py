"""Octahedron of feasible demands and proportional reduction: [Garus-F] (3.1)-(3.3), [Garus-N] (7)-(8), (12).

[Garus-F] says that a demand can be produced if and only if it lies in the octahedron whose corners are the largest
forces by axis. What is attainable is a zonotope, of which that octahedron is a part if its corners are attainable, as
they are with identical thrusters placed symmetrically. There it is exactly what the pseudo-inverse can give, and two
thirds of the volume of the zonotope. With a thruster lost, or another layout, the full thrust of one axis comes with a
by-product in another: the corner is not attainable and the octahedron not even feasible. :func:`served_limits` are
corners that the pseudo-inverse reaches without by-products, and are the printed ones with symmetrical thrusters.

Axes that share no thruster are divided apart, as both papers divide horizontal and vertical motion: a force of one
group costs nothing in another.
"""

from __future__ import annotations

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.feasible.pseudo_inverse import pseudo_inverse

Group = tuple[int, ...]

# Part of the largest element of its row below which an element of the configuration matrix is rounding: directions are
# written down to 12 digits.
_NO_SHARE = 1e-9


def axis_limits(configuration: FloatArray, thrust_max: FloatArray) -> FloatArray:
    """Return tau_i^max = sum_j |B_ij| f_j^max as printed, shape (m,), N or N m: [Garus-F] before (3.1), [Garus-N] (7).

    Parameters
    ----------
    configuration
        B, generalized force per newton of every thruster, shape (m, n).
    thrust_max
        f^max, shape (n,), N, the same both ways; 0 for a lost thruster.
    """
    limits: FloatArray = np.abs(configuration) @ thrust_max
    return limits


def served_limits(configuration: FloatArray, thrust_max: FloatArray, inverse: FloatArray | None = None) -> FloatArray:
    """Return the largest force of every axis alone that the pseudo-inverse gives within limits, shape (m,), N or N m.

    They are those of :func:`axis_limits` if thrusters are placed symmetrically, and less otherwise. The set of demands
    whose pseudo-inverse is within limits is convex, so that the octahedron of these corners lies within it.

    Parameters
    ----------
    configuration, thrust_max
        As there.
    inverse
        B* of the thrusters in use, shape (n, m), if it is there already.
    """
    used = thrust_max > 0.0
    if inverse is None:
        inverse = pseudo_inverse(configuration, used)
    share = np.abs(inverse[used])
    if not len(share):
        return np.zeros(len(configuration))
    with np.errstate(divide="ignore"):
        reach = np.where(share > 0.0, thrust_max[used, None] / share, np.inf).min(axis=0)
    # An axis of which no thruster gives anything has a zero column in the inverse.
    limits: FloatArray = np.minimum(reach, axis_limits(configuration, thrust_max))
    return limits


def coupled_axes(configuration: FloatArray) -> tuple[Group, ...]:
    """Return the groups of axes that share thrusters, each in order: indices into the rows of ``configuration``."""
    size = np.abs(configuration)
    share = size > _NO_SHARE * size.max(axis=1, initial=0.0)[:, None]
    left, groups = list(range(len(configuration))), []
    while left:
        group = {left[0]}
        while True:
            thrusters = share[sorted(group)].any(axis=0)
            larger = group | {i for i in left if (share[i] & thrusters).any()}
            if larger == group:
                break
            group = larger
        groups.append(tuple(sorted(group)))
        left = [i for i in left if i not in group]
    return tuple(groups)


def axis_loads(tau: FloatArray, limits: FloatArray) -> FloatArray:
    """Return |tau_i| / tau_i^max, shape (..., m): terms of (3.1); infinite for a demand in an axis with limit 0.

    Parameters
    ----------
    tau
        Generalized force, shape (..., m), N or N m; finite.
    limits
        tau^max, shape (m,).
    """
    size = np.abs(tau)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        loads: FloatArray = np.where(size > 0.0, size / limits, 0.0)
    return loads


def octahedron_load(tau: FloatArray, limits: FloatArray) -> FloatArray:
    """Return the left side of (3.1), shape (...): at most 1 within the octahedron. Arguments as for the loads."""
    load: FloatArray = axis_loads(tau, limits).sum(axis=-1)
    return load


def reduce_proportionally(tau: FloatArray, limits: FloatArray) -> FloatArray:
    """Return the demand, brought to the octahedron along its direction, shape (..., m): [Garus-F] (3.3).

    (3.3) divides by the first element of the demand, which may be zero. The same point is the demand over its load, by
    (3.4), so that all ratios (3.2) are kept whatever is zero. What is asked in an axis that has no thruster is given up
    first: it would take everything with it.

    Arguments as in :func:`axis_loads`.
    """
    kept = np.where(limits > 0.0, tau, 0.0)
    load = octahedron_load(kept, limits)[..., None]
    reduced: FloatArray = np.where(load > 1.0, kept / np.maximum(load, 1.0), kept)
    return reduced


def octahedron_volume(limits: FloatArray) -> float:
    """Return the volume of the octahedron of ``limits`` (m,): 2^m / m! of the product, 4/3 of it with three axes."""
    m = len(limits)
    return float(2.0**m * np.prod(limits / np.arange(1.0, m + 1.0)))
