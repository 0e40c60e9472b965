"""One axis kept, the others reduced by weights: [Garus-N] (10), (13)-(14)."""

from __future__ import annotations

import numpy as np

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.feasible.octahedron import axis_loads, octahedron_load

# a_i times 1 / a_i is 1 but for its last digit.
_ONE = 1.0 + 1e-15


def reduce_by_priority(tau: FloatArray, limits: FloatArray, weights: FloatArray, kept: int | None) -> FloatArray:
    """Return the demand, brought to the octahedron with one axis kept, shape (..., m).

    With l_i = |tau_i| / tau_i^max, the kept axis takes l_kept and leaves 1 - l_kept to the others, which get tau'_i =
    s a_i tau_i with the one s that uses it up. That is (14), written without quotients of demands, and gives the
    ratios (10) of the weights a_i. As printed it has no bound: with a >> b, a tau'_2 beyond tau_2 is ordered. Here no
    axis gets more than was demanded; what it leaves goes to the others in the ratio of their weights,

        tau'_i = min(1, s a_i) tau_i,    sum_i min(1, s a_i) l_i = 1 - l_kept

    whose left side rises with s along straight lines between the points s = 1 / a_i.

    If the kept axis alone is beyond its limit, it gets its limit and the others nothing: the corner of the octahedron.
    What is asked in an axis that has no thruster is given up first.

    Parameters
    ----------
    tau
        Generalized force, shape (..., m), N or N m; finite.
    limits
        tau^max, shape (m,).
    weights
        a_i, shape (m,), above 0; that of the kept axis has no say.
    kept
        Index of the axis; None: all are weighted.

    Raises
    ------
    InputError
        If a weight is not above 0, or there is no such axis.
    """
    m = len(limits)
    if weights.shape != (m,) or not (np.isfinite(weights).all() and (weights > 0.0).all()):
        raise InputError(f"priority.weights: expected {m} finite numbers above 0, found {weights.tolist()}")
    if kept is not None and not 0 <= kept < m:
        raise InputError(f"priority.axis: expected an index from 0 to {m - 1}, found {kept}")
    served = np.where(limits > 0.0, tau, 0.0)
    loads = axis_loads(served, limits)
    budget = np.ones(loads.shape[:-1])
    others = loads.copy()
    if kept is not None:
        budget = np.maximum(1.0 - loads[..., kept], 0.0)
        others[..., kept] = 0.0
    factor = _shares(others, weights, budget)
    if kept is not None:
        own = loads[..., kept]
        factor[..., kept] = np.where(own > 1.0, 1.0 / np.maximum(own, 1.0), 1.0)
    within = octahedron_load(served, limits) <= 1.0
    reduced: FloatArray = np.where(within[..., None], served, factor * served)
    return reduced


def _shares(loads: FloatArray, weights: FloatArray, budget: FloatArray) -> FloatArray:
    """Return min(1, s a_i), shape (..., m), with sum_i of it times the load equal to ``budget`` (...), or all 1."""
    level = np.full(budget.shape, np.inf)
    # From the first point 1 / a_i back to the last: the first segment that reaches the budget holds s.
    for point in sorted(set((1.0 / weights).tolist()), reverse=True):
        full = weights * point > _ONE
        taken = np.where(full, loads, 0.0).sum(axis=-1)
        slope = np.where(full, 0.0, weights * loads).sum(axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = np.where(slope > 0.0, (budget - taken) / slope, np.inf)
        level = np.where(s <= point, np.maximum(s, 0.0), level)
    shares: FloatArray = np.minimum(level[..., None] * weights, 1.0)
    return shares
