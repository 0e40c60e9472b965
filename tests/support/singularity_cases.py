"""Thruster configurations for tests of `thrust_allocator.singularity`."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

from marine_model.guards import FloatArray
from thrust_allocator.singularity import Scaling


@st.composite
def fixed_configurations(draw: st.DrawFn, smallest: int = 3, largest: int = 6) -> tuple[FloatArray, np.ndarray]:
    """A scaled configuration matrix of fixed thrusters, (3, k), and which of them are unidirectional."""
    k = draw(st.integers(smallest, largest))
    number = st.floats(-2.0, 2.0, width=32)
    angle = st.floats(-math.pi, math.pi)
    columns = []
    for _ in range(k):
        direction, x, y = draw(angle), draw(number), draw(number)
        share = draw(st.floats(0.1, 2.0))
        c, s = math.cos(direction), math.sin(direction)
        columns.append([share * c, share * s, share * (x * s - y * c)])
    unidirectional = np.array([draw(st.booleans()) for _ in range(k)])
    return np.array(columns).T.copy(), unidirectional


def unit_vectors(seed: int, count: int, size: int = 3) -> FloatArray:
    vectors = np.random.default_rng(seed).normal(size=(count, size))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def projected(B: FloatArray, unidirectional: np.ndarray, v: FloatArray) -> FloatArray:
    """P(B' v) for v of shape (count, m): what the shortest thrusts are made of."""
    thrust = v @ B
    return np.where(unidirectional & (thrust < 0.0), 0.0, thrust)


def mirrored(scaling: Scaling) -> Scaling:
    """The vessel with port and starboard swapped, thrusters in the same order."""
    return replace(scaling, lever_y=-scaling.lever_y, direction=-scaling.direction)
