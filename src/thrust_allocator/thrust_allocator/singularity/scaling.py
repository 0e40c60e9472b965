"""Makes forces and moments, and weak and strong thrusters, comparable: [Ruth] 7.1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector
from marine_model.thruster import AzimuthThruster

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class Scaling:
    """The scaling of one vessel. Made once; the same for all angles and all failures of that vessel, [Ruth] 7.5.3.

    Attributes
    ----------
    typical_arm
        L_typ, m, [Ruth] (7.2).
    mean_thrust_max
        T_max mean, N, [Ruth] (7.3).
    thrust_max
        T_max, shape (n,), N; all equal to their mean where so asked, [Ruth] (7.113).
    lever_x, lever_y
        Lever arms, shape (n,), m, body frame.
    direction
        Directions when held fixed, shape (n,), rad.
    azimuth_thruster
        Which thrusters can turn, bool, shape (n,).
    """

    typical_arm: float
    mean_thrust_max: float
    thrust_max: FloatArray
    lever_x: FloatArray
    lever_y: FloatArray
    direction: FloatArray
    azimuth_thruster: BoolArray

    @property
    def moment_scale(self) -> float:
        """1 / L_typ, 1/m: the yaw element of S, [Ruth] after (7.4)."""
        return 1.0 / self.typical_arm

    @property
    def count(self) -> int:
        """Number of thrusters n."""
        return len(self.thrust_max)

    def scaled(self, tau: ArrayLike) -> FloatArray:
        """Return S tau / T_max mean, shape (3,), of a generalized force in N, N, N m, [Ruth] (7.6)."""
        vector = finite_vector("tau", tau, 3) / self.mean_thrust_max
        vector[2] /= self.typical_arm
        return vector

    def unscaled(self, tau_scaled: ArrayLike) -> FloatArray:
        """Return the generalized force in N, N, N m, shape (3,), of a scaled one: [Ruth] (7.6) backwards."""
        vector = finite_vector("tau_scaled", tau_scaled, 3) * self.mean_thrust_max
        vector[2] *= self.typical_arm
        return vector

    def scaled_thrust(self, thrust: ArrayLike) -> FloatArray:
        """Return T / T_max, shape (n,), [Ruth] (7.7)."""
        return finite_vector("thrust", thrust, self.count) / self.thrust_max

    def unscaled_thrust(self, thrust_scaled: ArrayLike) -> FloatArray:
        """Return the thrust in N, shape (n,), of a scaled one: [Ruth] (7.7) backwards."""
        return finite_vector("thrust_scaled", thrust_scaled, self.count) * self.thrust_max


def scaling_of(vessel: Vessel, equal_thrust: bool = False) -> Scaling:
    """Return the scaling of a vessel, [Ruth] (7.2)-(7.4).

    Parameters
    ----------
    vessel
        The whole vessel: thrusters that are lost count in L_typ and T_max mean all the same.
    equal_thrust
        Replace every T_max by their mean, as [Ruth] (7.113) does for Table 7.1 and Table 7.2's fourth column.
    """
    # Copies, because compiled routines take read-only arrays for another type and would be compiled twice.
    lever_x, lever_y = vessel.lever_x.copy(), vessel.lever_y.copy()
    thrust_max = vessel.thrust_max.copy()
    mean = float(np.abs(thrust_max).mean())
    if equal_thrust:
        thrust_max[:] = mean
    return Scaling(
        typical_arm=float(np.hypot(lever_x, lever_y).mean()),
        mean_thrust_max=mean,
        thrust_max=thrust_max,
        lever_x=lever_x,
        lever_y=lever_y,
        direction=vessel.fixed_direction.copy(),
        azimuth_thruster=np.array([isinstance(thruster, AzimuthThruster) for thruster in vessel.thrusters]),
    )


def mask(name: str, value: ArrayLike | None, count: int, default: bool) -> BoolArray:
    """Return ``value`` as a bool array of shape (count,), or all ``default`` if None.

    Raises
    ------
    InputError
        If it is not bool or of another shape.
    """
    if value is None:
        return np.full(count, default)
    array = np.asarray(value)
    if array.shape != (count,) or (array.dtype != np.bool_ and count > 0):
        raise InputError(f"{name}: expected {count} bools, found shape {array.shape} of {array.dtype}")
    return np.ascontiguousarray(array, dtype=np.bool_)


def scaled_configuration(
    vessel: Vessel | Scaling,
    azimuth: ArrayLike | None = None,
    enabled: Sequence[bool] | BoolArray | None = None,
    equal_thrust: bool = False,
) -> FloatArray:
    """Return the scaled thruster configuration matrix, shape (3, k), dimensionless: surge, sway, yaw.

    Parameters
    ----------
    vessel
        A vessel, or its scaling.
    azimuth
        Directions of the force, shape (n,), rad; a tunnel thruster keeps its own whatever stands here. One column
        per enabled thruster, B_S of [Ruth] (7.4). None: thrusters rotate freely, B_G of [Ruth] (7.94)-(7.96), a
        tunnel thruster has one column and an azimuth thruster two (surge, then sway), in the order of the vessel
        file as in [Ruth] (7.117).
    enabled
        Bool mask, shape (n,); columns of the others are left out, [Ruth] 7.5.4 step 3. L_typ and T_max mean remain
        those of the whole vessel. None: all.
    equal_thrust
        As in `scaling_of`; only with a vessel.

    Raises
    ------
    InputError
        If ``azimuth`` or ``enabled`` has the wrong shape or type, or ``equal_thrust`` comes with a scaling.
    """
    if isinstance(vessel, Scaling):
        if equal_thrust:
            raise InputError("equal_thrust: expected False with a scaling (it has one already), found True")
        scaling = vessel
    else:
        scaling = scaling_of(vessel, equal_thrust)
    present = mask("enabled", enabled, scaling.count, default=True)
    if azimuth is not None:
        given = finite_vector("azimuth", azimuth, scaling.count)
        angle = np.where(scaling.azimuth_thruster, given, scaling.direction)
        return _columns(scaling, np.flatnonzero(present), angle[present])
    # Each azimuth thruster twice, as a thruster ahead and one to starboard.
    index = np.repeat(np.arange(scaling.count), np.where(scaling.azimuth_thruster, 2, 1))
    index = index[present[index]]
    angle = scaling.direction[index]
    rotating = scaling.azimuth_thruster[index]
    second = np.zeros(len(index), dtype=np.bool_)
    second[1:] = index[1:] == index[:-1]
    matrix = _columns(scaling, index, angle)
    share = scaling.thrust_max[index] / scaling.mean_thrust_max
    ahead, starboard = rotating & ~second, rotating & second
    # Written out, so that zeros are zeros and not cosines of 90 deg.
    matrix[:, ahead] = np.array([np.ones(len(index)), np.zeros(len(index)), -scaling.lever_y[index]])[:, ahead]
    matrix[:, starboard] = np.array([np.zeros(len(index)), np.ones(len(index)), scaling.lever_x[index]])[:, starboard]
    matrix[2, rotating] /= scaling.typical_arm
    matrix[:, rotating] *= share[rotating]
    return matrix


def _columns(scaling: Scaling, index: NDArray[np.intp], angle: FloatArray) -> FloatArray:
    """Return B_S for thrusters ``index`` pointing along ``angle``, shape (3, len(index))."""
    c, s = np.cos(angle), np.sin(angle)
    moment = (scaling.lever_x[index] * s - scaling.lever_y[index] * c) / scaling.typical_arm
    matrix: FloatArray = np.array([c, s, moment]) * (scaling.thrust_max[index] / scaling.mean_thrust_max)
    return matrix
