"""Heave, roll and pitch as three systems of their own, carried over any length of time exactly.

With mass m (added mass included), damping d and stiffness k, the state of an axis is position x, rate v and bias b, a
force over mass:

    x_dot = v + n_x,    v_dot = tau / m - d / m v - k / m x + b + n_v,    b_dot = n_b

The noises n say how much less than the fixes the model is believed. Their densities, over that of the noise of the
fixes, follow from one number, the bandwidth w:

    q_x = 3 w^2 + 2 k / m - (d / m)^2,    q_v = 3 w^4 - (k / m)^2 - q_x (d / m)^2,    q_b = w^6

because then s (s^2 + d / m s + k / m) has the spectral factor (s + w)^3: with fixes that come steadily the error has
all three poles at -w. Where an axis is by itself faster than w a density would be negative. It is zero then, and the
motion of that axis is followed faster than w, its bias more slowly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from marine_model.guards import FloatArray
from marine_model.vertical import VerticalObserverGains

POSITION, RATE, BIAS = range(3)

_TAYLOR_TERMS = 16  # of a matrix of norm 1/2: the rest is below 1e-19
_MOST_DOUBLINGS = 60


@dataclass(frozen=True, slots=True)
class Step:
    """Three axes over one length of time; first index: heave, roll, pitch.

    Attributes
    ----------
    transition
        Shape (3, 3, 3): of the state (position, rate, bias).
    force
        Shape (3, 3): state after that time by a constant force over mass of 1.
    noise
        Shape (3, 3, 3): covariance that it adds.
    """

    transition: FloatArray
    force: FloatArray
    noise: FloatArray


class AxisModels:
    """The three axes of one vehicle.

    Parameters
    ----------
    gains
        Mass, damping, stiffness, bandwidth.
    """

    def __init__(self, gains: VerticalObserverGains) -> None:
        mass = np.array(gains.mass)
        d, k, w = np.array(gains.damping) / mass, np.array(gains.stiffness) / mass, np.array(gains.bandwidth)
        system, density = np.zeros((3, 4, 4)), np.zeros((3, 4, 4))
        system[:, POSITION, RATE] = system[:, RATE, BIAS] = system[:, RATE, 3] = 1.0  # the fourth: a constant force
        system[:, RATE, POSITION], system[:, RATE, RATE] = -k, -d
        density[:, POSITION, POSITION] = np.maximum(3.0 * w**2 + 2.0 * k - d**2, 0.0)
        density[:, RATE, RATE] = np.maximum(3.0 * w**4 - k**2 - density[:, POSITION, POSITION] * d**2, 0.0)
        density[:, BIAS, BIAS] = w**6
        # Van Loan, Computing integrals involving the matrix exponential, IEEE Trans. Automatic Control 23, 1978.
        zero = np.zeros((3, 4, 4))
        self._rates = np.block([[-system, density], [zero, system.transpose(0, 2, 1)]])
        self._known: tuple[float, Step] | None = None

    def over(self, length: float) -> Step:
        """Return the axes over ``length`` (s)."""
        # Every step of a run has the same length, nearly always.
        if self._known is not None and self._known[0] == length:
            return self._known[1]
        whole = _exponential(self._rates * length)
        transition = whole[:, 4:, 4:].transpose(0, 2, 1)
        noise = transition @ whole[:, :4, 4:]
        step = Step(transition[:, :3, :3].copy(), transition[:, :3, 3].copy(), _symmetric(noise[:, :3, :3]))
        self._known = length, step
        return step


def steady_covariance(step: Step, variance: float) -> FloatArray:
    """Return the covariance after a fix in the long run of one fix a step, shape (3, 3, 3).

    By the doubling algorithm for the discrete Riccati equation (Anderson and Moore, *Optimal Filtering*, 1979, 6.7).

    Parameters
    ----------
    step
        From one fix to the next.
    variance
        Of the noise of a fix.
    """
    identity = np.broadcast_to(np.eye(3), (3, 3, 3))
    a, x = step.transition.transpose(0, 2, 1), step.noise
    g = np.zeros((3, 3, 3))
    g[:, POSITION, POSITION] = 1.0 / variance
    for _ in range(_MOST_DOUBLINGS):
        inverse = np.linalg.inv(identity + g @ x)
        turned = a.transpose(0, 2, 1)
        # x (I + g x)^-1 and (I + g x)^-1 g are symmetric.
        a, g, grown = a @ inverse @ a, g + a @ inverse @ g @ turned, x + turned @ x @ inverse @ a
        same = np.abs(grown - x).max() <= 1e-14 * np.abs(grown).max()
        x = _symmetric(grown)
        if same:
            break
    return corrected(x, variance)[1]


def corrected(covariance: FloatArray, variance: float) -> tuple[FloatArray, FloatArray]:
    """Return the gain of a fix, shape (3, 3) (axis, state), and the covariance after it, shape (3, 3, 3)."""
    spread = covariance[:, POSITION, POSITION] + variance
    gain = covariance[:, :, POSITION] / spread[:, None]
    rest = np.zeros((3, 3, 3))
    rest[:] = np.eye(3)
    rest[:, :, POSITION] -= gain
    rest[:, POSITION, POSITION] = variance / spread  # not 1 - gain: nothing would be left of it after a long gap
    # Joseph's form stays positive whatever the covariance has grown to.
    after = rest @ covariance @ rest.transpose(0, 2, 1) + variance * gain[:, :, None] * gain[:, None, :]
    return gain, _symmetric(after)


def _symmetric(matrices: FloatArray) -> FloatArray:
    return 0.5 * (matrices + matrices.transpose(0, 2, 1))


def _exponential(matrices: FloatArray) -> FloatArray:
    """Return exp of every matrix, shape (k, n, n): Taylor's series, halved and squared."""
    norm = float(np.abs(matrices).sum(axis=2).max())
    halvings = max(0, math.ceil(math.log2(2.0 * norm))) if norm > 0.0 else 0
    scaled = matrices * 0.5**halvings
    term: FloatArray = np.broadcast_to(np.eye(matrices.shape[1]), matrices.shape)
    total = term.copy()
    for j in range(1, _TAYLOR_TERMS + 1):
        term = term @ scaled / j
        total += term
    for _ in range(halvings):
        total = total @ total
    return total
