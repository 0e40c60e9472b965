"""Balls of generalized force that a vessel can certainly produce: [Ruth] Theorem 7.3 and Lemma 7.2."""

from __future__ import annotations

import math
from typing import NamedTuple

from marine_model.errors import InputError
from marine_model.guards import finite_number
from thrust_allocator.singularity.scaling import Scaling


class AttainableBound(NamedTuple):
    """Radii of three balls, each of which the attainable set contains.

    Attributes
    ----------
    scaled
        Of scaled generalized force, dimensionless: (7.76), (7.106).
    weighted
        Of S tau = (surge, sway, yaw / L_typ), N: (7.77), (7.107).
    unscaled
        Of tau = (surge N, sway N, yaw N m): (7.78), (7.108).
    """

    scaled: float
    weighted: float
    unscaled: float


def theorem_7_3(gain: float, scaling: Scaling) -> AttainableBound:
    """Return the bound for fixed thrusters, [Ruth] (7.76)-(7.78).

    Every scaled force up to ``gain`` needs a scaled thrust of length 1 at most, which keeps every thruster within
    |T_j| <= T_max,j. (The print writes the norm of tau above the radius: the boundary of the set is no nearer.) Reverse
    thrust is taken to be as strong as forward thrust; where a bidirectional thruster's T_min is weaker, multiply by
    the smallest |T_min| / T_max.

    Parameters
    ----------
    gain
        Minimum gain by any method.
    scaling
        Of the vessel.

    Raises
    ------
    InputError
        If ``gain`` is not finite or below 0.
    """
    sigma = finite_number("gain", gain)
    if sigma < 0.0:
        raise InputError(f"gain: expected a number not below 0, found {sigma}")
    weighted = sigma * scaling.mean_thrust_max
    return AttainableBound(sigma, weighted, min(1.0, scaling.typical_arm) * weighted)


def lemma_7_2(gain: float, scaling: Scaling, as_printed: bool = True) -> AttainableBound:
    """Return the bound with rotating thrusters, [Ruth] (7.106)-(7.108).

    The print divides Theorem 7.3 by the root of 2, so that both components of a rotating thruster may reach the bound
    at once. They cannot: the minimum-norm thrust for a force up to ``gain`` has a length of at most 1 over all
    components together, so that every pair lies in its disc already. ``as_printed`` False leaves the factor out.

    Parameters
    ----------
    gain, scaling
        As in `theorem_7_3`.
    as_printed
        With the factor 1 / sqrt(2).

    Raises
    ------
    InputError
        As `theorem_7_3`.
    """
    return theorem_7_3(finite_number("gain", gain) * (math.sqrt(0.5) if as_printed else 1.0), scaling)
