"""How much of a demand can be had with its direction kept."""

from __future__ import annotations

import numpy as np

from marine_model.guards import FloatArray
from thrust_allocator.engine import Answer, Engine
from thrust_allocator.plan.polygon import CORNERS
from thrust_allocator.program.active_set import solve
from thrust_allocator.step import set_polygons

# The demand given up costs this many times what all thrusters cost at full span, so that no thrust is saved by giving
# up more; and the slack is made stiffer by as much again and more, so that it takes no part.
_PRICE = 1e3
_STIFFER = 1e-4


def attainable_share(engine: Engine, answer: Answer, span: FloatArray) -> float:
    """Return the largest share of the demand of ``answer`` that its step can give with nothing else besides, 0 to 1.

    The demand itself acts as one more thruster: it gives between 0 and 1 of the generalized force tau, so that
    sum_j B_j u_j + k tau = tau, and k, the part given up, has a price. The share is 1 - k.

    Parameters
    ----------
    engine
        That made the answer.
    answer
        Of a step whose slack is not small.
    span
        |T_max| + |T_min|, shape (n,), N.
    """
    n, m = len(span), len(answer.tau)
    columns = np.zeros((n + 1, m, 2))
    columns[:n] = engine.columns
    columns[n, :, 0] = answer.tau
    weight = np.append(answer.weight, _PRICE * float(answer.weight @ span**2))
    corners, count = np.zeros((n + 1, CORNERS, 2)), np.zeros(n + 1, dtype=np.int64)
    set_polygons(answer.plans, engine.weights.zero_region, corners[:n], count[:n])
    corners[n, 1, 0] = 1.0
    count[n] = 2
    force, face = np.zeros((n + 1, 2)), np.zeros(n + 1, dtype=np.int64)
    steps = solve(
        columns,
        weight,
        corners,
        count,
        _STIFFER * answer.compliance,
        answer.tau,
        np.zeros(m),
        force,
        face,
        np.zeros((m, m + 1)),
    )
    # The axes as they are weighted are all that is left if the method fails.
    return 1.0 if steps < 0 else 1.0 - float(min(max(force[n, 0], 0.0), 1.0))
