"""What each thruster can still do about its present thrust: [Ruth] 7.2."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number, finite_vector
from thrust_allocator.singularity.gain import GainMethod, MinimumGain, minimum_gain
from thrust_allocator.singularity.minimum_norm import IntArray, checked_matrix
from thrust_allocator.singularity.scaling import Scaling


class LocalKind(IntEnum):
    """Which way a thruster can change its thrust by the required amount."""

    NEGATIVE = -1  # down only, near its largest thrust: (7.10)
    NONE = 0  # neither way: its range is narrower than the changes together. Not in the source.
    POSITIVE = 1  # up only, near its smallest thrust: (7.9)
    BIDIRECTIONAL = 2  # both ways: (7.8)


def classify(
    thrust: ArrayLike,
    thrust_min: ArrayLike,
    thrust_max: ArrayLike,
    delta_minus: ArrayLike,
    delta_plus: ArrayLike,
) -> IntArray:
    """Return the `LocalKind` of every thruster, shape (n,), [Ruth] (7.8)-(7.10).

    Parameters
    ----------
    thrust
        Present thrust, shape (n,), N.
    thrust_min, thrust_max
        Limits in force, shape (n,), N; thrust_min is 0 for a thruster that gives no reverse thrust.
    delta_minus, delta_plus
        Necessary available change down (not above 0) and up (not below 0), shape (n,), N.

    Raises
    ------
    InputError
        If a shape is wrong, a number not finite, a change of the wrong sign, or the limits in the wrong order.
    """
    T = np.asarray(thrust, dtype=np.float64)
    n = T.shape[0] if T.ndim == 1 else 1
    T = finite_vector("thrust", thrust, n)
    low, high = finite_vector("thrust_min", thrust_min, n), finite_vector("thrust_max", thrust_max, n)
    down, up = finite_vector("delta_minus", delta_minus, n), finite_vector("delta_plus", delta_plus, n)
    if (down > 0.0).any() or (up < 0.0).any():
        raise InputError(
            f"delta_minus, delta_plus: expected numbers not above and not below 0, found {down.tolist()}, {up.tolist()}"
        )
    if (low > high).any():
        raise InputError(f"thrust_min: expected not above thrust_max, found {low.tolist()} and {high.tolist()}")
    may_sink, may_rise = low - down <= T, high - up >= T
    kinds = np.full(n, int(LocalKind.NONE), dtype=np.int64)
    kinds[may_rise] = LocalKind.POSITIVE
    kinds[may_sink] = LocalKind.NEGATIVE
    kinds[may_sink & may_rise] = LocalKind.BIDIRECTIONAL
    return kinds


def local_minimum_gain(B_scaled: ArrayLike, kinds: ArrayLike, method: GainMethod = "auto") -> MinimumGain:
    """Return the minimum gain for small changes about the present thrust, [Ruth] 7.2.

    Columns of negatively unidirectional thrusters change their sign, [Ruth] (7.12); those of thrusters that cannot
    change either way are left out.

    Parameters
    ----------
    B_scaled
        Scaled configuration matrix at the present directions, shape (m, n).
    kinds
        From `classify`, shape (n,).
    method
        As in `minimum_gain`.

    Raises
    ------
    InputError
        If a shape is wrong, or a kind is not one of `LocalKind`.
    """
    B = checked_matrix(B_scaled)
    kind = np.asarray(kinds)
    if kind.shape != (B.shape[1],) or not np.isin(kind, list(LocalKind)).all():
        raise InputError(f"kinds: expected {B.shape[1]} numbers of LocalKind, found {kind.tolist()}")
    sign = np.where(kind == LocalKind.NEGATIVE, -1.0, 1.0)
    used = kind != LocalKind.NONE
    return minimum_gain((B * sign)[:, used], kind[used] != LocalKind.BIDIRECTIONAL, method)


def required_change_scaled(scaling: Scaling, gain: float, perturbation_scaled: float) -> FloatArray:
    """Return how far each thrust may have to move for a scaled perturbation, shape (n,), N: [Ruth] (7.15).

    Parameters
    ----------
    scaling
        Of the vessel.
    gain
        Minimum gain, not below 0; infinite changes at 0.
    perturbation_scaled
        Length of the change of scaled generalized force, not below 0.

    Raises
    ------
    InputError
        If a number is not finite or below 0.
    """
    sigma = _not_negative("gain", gain)
    size = _not_negative("perturbation_scaled", perturbation_scaled)
    if size == 0.0:
        return np.zeros(scaling.count)
    return scaling.thrust_max * (size / sigma if sigma > 0.0 else math.inf)


def required_change(scaling: Scaling, gain: float, perturbation: float) -> FloatArray:
    """Return how far each thrust may have to move for a perturbation in N, N, N m, shape (n,), N: [Ruth] (7.16).

    The print multiplies by min(1, L_typ). The length of S tau is at most max(1, 1 / L_typ) that of tau, and that is
    what stands here.

    Parameters
    ----------
    scaling, gain
        As in `required_change_scaled`.
    perturbation
        Length of the change of (N, N, N m), not below 0.

    Raises
    ------
    InputError
        If a number is not finite or below 0.
    """
    size = _not_negative("perturbation", perturbation)
    return required_change_scaled(scaling, gain, max(1.0, scaling.moment_scale) * size / scaling.mean_thrust_max)


def _not_negative(name: str, value: float) -> float:
    number = finite_number(name, value)
    if number < 0.0:
        raise InputError(f"{name}: expected a number not below 0, found {number}")
    return number
