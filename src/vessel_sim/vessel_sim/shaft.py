"""One propeller shaft under constant motor torque, solved in closed form.

    2 pi J dn/dt = Q_m - K_Q rho D^5 n |n| - Q_v n - Q_s sgn(n)

n in Hz. The load is quadratic, so that on either side of n = 0 this is a Riccati equation; with the square
completed, m = n + Q_v / (2 c), it is 2 pi J dm/dt = G - c m^2, whose solutions are tanh (G > 0), tan (G < 0) and
1/t (G = 0). The step is exact for any length: no time constant of a shaft bounds the time step. Coulomb friction
holds the shaft at rest while |Q_m| <= Q_s.
"""

from __future__ import annotations

import math

from marine_model.vessel import Vessel


class Shaft:
    """Motor, shaft and propeller of one thruster.

    Parameters
    ----------
    inertia
        J, kg m^2.
    load
        c = K_Q rho D^5, N m s^2: propeller torque per shaft speed squared.
    viscous
        Q_v, N m s: friction per Hz.
    static
        Q_s, N m: Coulomb friction.
    """

    __slots__ = ("_angular_inertia", "_load", "_offset", "_offset_squared", "_static")

    def __init__(self, inertia: float, load: float, viscous: float = 0.0, static: float = 0.0) -> None:
        self._angular_inertia = 2.0 * math.pi * inertia
        self._load = load
        self._static = static
        self._offset = viscous / (2.0 * load)
        self._offset_squared = self._offset**2

    def advance(self, speed: float, torque: float, dt: float) -> float:
        """Return the shaft speed (Hz) after ``dt`` (s) under motor ``torque`` (N m) from ``speed`` (Hz)."""
        if speed > 0.0 or (speed == 0.0 and torque > self._static):
            speed, left = self._forward(speed, torque - self._static, dt)
            if left > 0.0 and torque < -self._static:
                return -self._forward(0.0, -torque - self._static, left)[0]
            return speed
        if speed < 0.0 or torque < -self._static:
            speed, left = self._forward(-speed, -torque - self._static, dt)
            if left > 0.0 and torque > self._static:
                return self._forward(0.0, torque - self._static, left)[0]
            return -speed
        return 0.0

    def _forward(self, speed: float, torque: float, dt: float) -> tuple[float, float]:
        """Return speed after ``dt`` and 0, or 0 and the time left after coming to rest. ``speed`` >= 0."""
        load, offset = self._load, self._offset
        start = speed + offset
        square = torque / load + self._offset_squared  # G / c, the square of the final m where positive
        if square > 0.0:
            final = math.sqrt(square)
            rate = final * load / self._angular_inertia
            t = math.tanh(rate * dt)
            reached = final * (start + final * t) / (final + start * t) - offset
            if reached >= 0.0 or torque >= 0.0:
                return (reached if reached > 0.0 else 0.0), 0.0
            at_rest = math.atanh(final * (start - offset) / (offset * start - square)) / rate
            return 0.0, max(dt - at_rest, 0.0)
        if square < 0.0:
            scale = math.sqrt(-square)
            rate = scale * load / self._angular_inertia
            angle = math.atan2(start, scale)
            at_rest = (angle - math.atan2(offset, scale)) / rate
            if at_rest <= dt:
                return 0.0, dt - at_rest
            return scale * math.tan(angle - rate * dt) - offset, 0.0
        # G = 0: without viscous friction a coasting shaft, which never quite stops.
        reached = start / (1.0 + start * load * dt / self._angular_inertia) - offset
        if reached >= 0.0:
            return reached, 0.0
        at_rest = (start / offset - 1.0) * self._angular_inertia / (start * load)
        return 0.0, max(dt - at_rest, 0.0)


def shafts(vessel: Vessel) -> list[Shaft]:
    """Return the shafts of all thrusters of ``vessel``, in file order."""
    load = vessel.propellers.torque_per_speed_squared.tolist()
    return [
        Shaft(t.shaft.inertia, load[i], t.shaft.friction_viscous, t.shaft.friction_static)
        for i, t in enumerate(vessel.thrusters)
    ]
