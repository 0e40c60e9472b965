"""Marching thrusters in a cross, shared among surge, yaw and pitch by portions: [Kostenko] (5)-(6).

[Kostenko]'s axes are X ahead, Y up, Z to starboard, his moments M_y about up and M_z about starboard. In this frame,
down, that is M_y = -N and M_z = M (bow up), and his vertical force is -Z. The four thrusters sit L_s astern at delta to
the long axis and the bow thruster L_b ahead; positive thrust pushes ahead and up (U), down (D), to port (L), to
starboard (R), and up (B). So (5) reads

    X = (T_U + T_D + T_L + T_R) cos(delta)        -Z = (T_U - T_D) sin(delta) + T_B
   -N = (T_R - T_L) sin(delta) L_s                 M = T_B L_b - (T_U - T_D) sin(delta) L_s

(6) prints T_x = P_x F_x / (4 cos(delta)) where |F_x / (4 cos(delta))| < T_max, else P_x T_max sign(F_x): of every
demand only its portion, saturated or not. The text wants thrusts that realise the demands, and a limit by portions
that makes channels independent. So they do as a limit alone,

    T_x = F_x / (4 cos(delta)) where that is less than P_x T_max in size, else P_x T_max sign(F_x)

and alike for the others. |T_x| + |T_phi| and |T_x| + |T_psi| are then no more than T_max, every channel gets what it
asks for up to its portion, and none has a say in another.

Of heave [Kostenko] says that the bow thruster serves it, and calls what the pitch moment of U and D brings with it a
by-product. Here heave is demanded too, and both are met: with q = (T_D - T_U) sin(delta) = 2 T_psi sin(delta),

    -Z = T_B - q,    M = T_B L_b + q L_s    give    T_B = (M - L_s Z) / (L_s + L_b),    q = (M + L_b Z) / (L_s + L_b)

in place of T_psi = M / (2 L_s sin(delta)). Heave and pitch share these thrusters: if T_psi is beyond its portion or T_B
beyond its limits, both are reduced by one factor, so that neither is turned round for the sake of the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, sin

import numpy as np

from marine_model.errors import InputError
from marine_model.guards import FloatArray

# Portions are written in decimal.
_SUM = 1e-9


@dataclass(frozen=True, slots=True)
class Portions:
    """P_x, P_phi, P_psi: what part of T_max every channel may have.

    Raises
    ------
    InputError
        If one is not within 0 and 1, or P_x + P_phi or P_x + P_psi is not 1, the condition of (6).
    """

    surge: float
    yaw: float
    pitch: float

    def __post_init__(self) -> None:
        for name in ("surge", "yaw", "pitch"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise InputError(f"portions.{name}: expected a number from 0 to 1, found {value}")
        for name in ("yaw", "pitch"):
            total = self.surge + getattr(self, name)
            if abs(total - 1.0) > _SUM:
                raise InputError(f"portions.surge + portions.{name}: expected 1, found {total:.9g}")


@dataclass(frozen=True, slots=True)
class Cross:
    """Where the thrusters are: delta (rad), L_s and L_b (m), and limits of the bow thruster (N)."""

    angle: float
    stern_arm: float
    bow_arm: float
    bow_min: float
    bow_max: float


@dataclass(frozen=True, slots=True)
class PortionedThrust:
    """Thrusts of :func:`portion`.

    Attributes
    ----------
    thrust
        T_U, T_D, T_L, T_R, T_B, shape (..., 5), N.
    load
        Largest thrust of a channel, or of the bow thruster, over what it may have, shape (...): at most 1 if all
        demands are met.
    """

    thrust: FloatArray
    load: FloatArray


def portion(
    surge: FloatArray,
    heave: FloatArray,
    pitch: FloatArray,
    yaw: FloatArray,
    cross: Cross,
    portions: Portions,
    thrust_max: float,
) -> PortionedThrust:
    """Return the thrusts for demands, each of shape (...): N, N, N m, N m in the body frame, heave down, pitch bow up.

    Parameters
    ----------
    surge, heave, pitch, yaw
        Demands; finite.
    cross
        Geometry.
    portions
        Shares of the channels.
    thrust_max
        T_max of a marching thruster at the present speed, N, 0 or more.

    Raises
    ------
    InputError
        If ``thrust_max`` is not 0 or more.
    """
    if not 0.0 <= thrust_max < inf:
        raise InputError(f"thrust_max: expected a finite number, 0 or more, found {thrust_max}")
    along, across = 4.0 * cos(cross.angle), 2.0 * sin(cross.angle)
    arms = cross.stern_arm + cross.bow_arm
    by_surge, surge_load = _limited(surge / along, portions.surge * thrust_max)
    by_yaw, yaw_load = _limited(-yaw / (across * cross.stern_arm), portions.yaw * thrust_max)
    bow = (pitch - cross.stern_arm * heave) / arms
    lifted = (pitch + cross.bow_arm * heave) / (arms * across)
    _, lifted_load = _limited(lifted, portions.pitch * thrust_max)
    _, up = _limited(np.maximum(bow, 0.0), cross.bow_max)
    _, down = _limited(np.minimum(bow, 0.0), -cross.bow_min)
    pair_load = np.max([lifted_load, up, down], axis=0)
    share = 1.0 / np.maximum(pair_load, 1.0)
    by_pitch, bow = share * lifted, share * bow
    thrust = np.stack([by_surge - by_pitch, by_surge + by_pitch, by_surge - by_yaw, by_surge + by_yaw, bow], axis=-1)
    return PortionedThrust(thrust, np.max([surge_load, yaw_load, pair_load], axis=0))


def _limited(thrust: FloatArray, limit: float) -> tuple[FloatArray, FloatArray]:
    """Return ``thrust``, no more than ``limit`` in size, and its part of the limit."""
    size = np.abs(thrust)
    with np.errstate(divide="ignore", invalid="ignore"):
        load = np.where(size > 0.0, size / limit, 0.0)
    return np.clip(thrust, -limit, limit), load
