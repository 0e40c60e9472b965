"""How much of a demand is attainable: at given angles, and when the thrusters have turned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from marine_model import Vessel
from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.attainable.boundary import turning_reach, zonotope_reach
from thrust_allocator.attainable.force_set import ForceSet, flags, limit_fraction
from thrust_allocator.singularity import scaling_of


class Margin(NamedTuple):
    """Largest multiple of a demand that is attainable: the demand is if it is 1 or more. Infinite for no demand."""

    fixed: float  # with the present angles
    turning: float  # once every thruster that can turn points the best way


def reach(forces: ForceSet, direction: FloatArray) -> tuple[float, FloatArray]:
    """Return the largest s with ``s * direction`` in the set, and the normal of the boundary there.

    The normal, shape (3,), is as long as makes normal . direction = 1; zeros with a zonotope, which may have many.
    """
    # Any common factor will do; the largest element keeps squares from over- and underflow.
    largest = float(np.abs(direction).max())
    balance = np.array([1.0, 1.0, 1.0 / forces.length])
    unit = direction * balance / largest
    first, second = forces.first * balance, forces.second * balance
    if not forces.turns.any():
        return zonotope_reach(first, forces.lower, forces.upper, unit) / largest, np.zeros(3)
    turns = forces.turns.astype(np.float64)
    scale, normal = turning_reach(first, second, forces.lower, forces.upper, turns, unit)
    return scale / largest, normal * balance / largest


class ThrustMargin:
    """The margin of a demand in every step: made once for the vessel and its failures, then asked with present angles.

    Parameters
    ----------
    vessel
        The vessel.
    enabled
        n bools; False: the thruster is lost.
    thrust_limit_scale
        Fraction of both thrust limits that may be used, shape (n,), 0 to 1.
    can_rotate
        n bools: which thrusters turn; the others keep their present angle. The vessel's own if left out.

    Raises
    ------
    InputError
        If a shape is wrong, or a fraction out of range.
    """

    def __init__(
        self,
        vessel: Vessel,
        *,
        enabled: Sequence[bool] | None = None,
        thrust_limit_scale: ArrayLike | None = None,
        can_rotate: Sequence[bool] | None = None,
    ) -> None:
        n = len(vessel.thrusters)
        limits = limit_fraction(vessel, enabled, thrust_limit_scale)
        length = scaling_of(vessel).typical_arm
        # One array, because every argument of compiled code costs a tenth of a microsecond.
        self._thrusters = np.column_stack(
            [
                vessel.lever_x / length,
                vessel.lever_y / length,
                vessel.thrust_min * limits,
                vessel.thrust_max * limits,
                vessel.can_rotate if can_rotate is None else flags("can_rotate", can_rotate, n),
                np.where(vessel.can_rotate, np.nan, vessel.fixed_direction),
            ]
        ).astype(np.float64, order="C")
        self._length = length

    def __call__(self, azimuth: FloatArray, tau: FloatArray) -> Margin:
        """Return the margin of a demand.

        Parameters
        ----------
        azimuth
            Present directions, float64, shape (n,), rad; that of a tunnel is not read.
        tau
            Demanded generalized force, float64, shape (3,): N, N, N m. Both are finite and C-contiguous.
        """
        return Margin(*margins(self._thrusters, self._length, azimuth, tau))


@compiled
def margins(thrusters: FloatArray, length: float, azimuth: FloatArray, tau: FloatArray) -> tuple[float, float]:
    """Return both margins of a demand, compiled.

    Parameters
    ----------
    thrusters
        Shape (n, 6): lever arms over ``length``, lower and upper thrust limit (N), 1.0 where the thruster turns, and
        the direction of a tunnel (rad), NaN for an azimuth thruster.
    length
        Typical lever arm, m.
    azimuth, tau
        As in ``ThrustMargin``.
    """
    n = thrusters.shape[0]
    unit = np.empty(3)
    unit[0], unit[1], unit[2] = tau[0], tau[1], tau[2] / length
    largest = max(abs(unit[0]), abs(unit[1]), abs(unit[2]))
    if largest == 0.0:
        return math.inf, math.inf
    unit /= largest
    first, second = np.empty((n, 3)), np.zeros((n, 3))
    lower, upper, turns = np.empty(n), np.empty(n), np.empty(n)
    any_turns = False
    for j in range(n):
        lever_x, lever_y = thrusters[j, 0], thrusters[j, 1]
        angle = azimuth[j] if math.isnan(thrusters[j, 5]) else thrusters[j, 5]
        c, s = math.cos(angle), math.sin(angle)
        first[j, 0], first[j, 1], first[j, 2] = c, s, lever_x * s - lever_y * c
        lower[j], upper[j], turns[j] = thrusters[j, 2], thrusters[j, 3], thrusters[j, 4]
    fixed = zonotope_reach(first, lower, upper, unit) / largest
    for j in range(n):
        if turns[j] > 0.0 and upper[j] > 0.0:
            any_turns = True
            first[j, 0], first[j, 1], first[j, 2] = 1.0, 0.0, -thrusters[j, 1]
            second[j, 0], second[j, 1], second[j, 2] = 0.0, 1.0, thrusters[j, 0]
            upper[j] = max(upper[j], -lower[j])
    if not any_turns:
        return fixed, fixed
    turning, _ = turning_reach(first, second, lower, upper, turns, unit)
    # The one set holds the other; rounding may say otherwise by 1e-12.
    return fixed, max(turning / largest, fixed)
