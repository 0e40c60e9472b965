"""Reference generator: a second-order filter with velocity limits, [Ruth] B.3.2."""

from __future__ import annotations

import math

from dp_controller.second_order import transition
from dp_controller.vectors import ZERO, Triple, to_body

# Longest step in units of 1/frequency. The limited velocity is held over a step, so that the change-over to the
# unlimited filter comes late by up to one step; below 1 this cannot cause overshoot when damping >= 1.
LONGEST_STEP = 0.5


class ReferenceGenerator:
    """Position reference that moves to a target as a second-order filter does, at limited speed.

    The filter x'' = w^2 (p - x) - 2 z w (x' - p') + p'' is written as a velocity loop,

        x'' - p'' = 2 z w (v_c - x'),    v_c = p' + w / (2 z) (p - x),

    and the limits act on the commanded velocity v_c. So the filter is exact while v_c is within the limits,
    acceleration is bounded at a step of the target, and no state winds up while the limits act. Surge and sway are
    scaled together, so that the reference moves to its target in a straight line. Limits are on the velocity seen
    in the body frame of the reference heading.

    Parameters
    ----------
    frequency
        w, rad/s.
    damping
        z, relative damping.
    velocity_max
        Limits in surge (m/s), sway (m/s) and yaw (rad/s).

    Attributes
    ----------
    position
        North (m), east (m), heading (rad, not wrapped).
    velocity
        Rate of change of ``position``, NED.
    """

    __slots__ = ("_damping", "_dt", "_free", "_frequency", "_velocity_max", "position", "velocity")

    def __init__(self, frequency: float, damping: float, velocity_max: Triple) -> None:
        self._frequency = frequency
        self._damping = damping
        self._velocity_max = velocity_max
        # Every step of a run has the same length, nearly always.
        self._dt = 0.0
        self._free = transition(frequency, damping, 0.0)
        self.position: Triple = ZERO
        self.velocity: Triple = ZERO

    @property
    def velocity_max(self) -> Triple:
        """Limits in surge (m/s), sway (m/s) and yaw (rad/s)."""
        return self._velocity_max

    @velocity_max.setter
    def velocity_max(self, limits: Triple) -> None:
        self._velocity_max = limits
        self.velocity = self._limited(self.position[2], self.velocity)

    def steps_in(self, dt: float) -> int:
        """Return into how many equal steps ``dt`` (s) has to be divided."""
        return max(1, math.ceil(dt * self._frequency / LONGEST_STEP - 1e-9))

    def reset(self, position: Triple, velocity: Triple) -> None:
        """Start anew from ``position`` and ``velocity`` (NED), the latter cut to the limits."""
        self.position = position
        self.velocity = self._limited(position[2], velocity)

    def body_velocity(self) -> Triple:
        """Return the velocity in the body frame of the reference heading."""
        return to_body(self.position[2], self.velocity)

    def step(
        self,
        start: Triple,
        start_velocity: Triple,
        end: Triple,
        end_velocity: Triple,
        dt: float,
    ) -> None:
        """Advance by ``dt`` (s) while the target goes from ``start`` to ``end``.

        Parameters
        ----------
        start, end
            Target at the beginning and the end of the step: north, east, heading (not wrapped: the reference turns
            the way the number says).
        start_velocity, end_velocity
            Rate of change of the target, NED; zero for a set point.
        dt
            At most what :meth:`steps_in` allows.
        """
        x, v = self.position, self.velocity
        heading = x[2]
        pull = self._frequency / (2.0 * self._damping)
        commanded = (
            start_velocity[0] + pull * (start[0] - x[0]),
            start_velocity[1] + pull * (start[1] - x[1]),
            start_velocity[2] + pull * (start[2] - x[2]),
        )
        limited = self._limited(heading, commanded)
        if dt != self._dt:
            self._free = transition(self._frequency, self._damping, dt)
            self._dt = dt
        free = self._free
        position, velocity = list(x), list(v)
        for i in range(3):
            if limited[i] == commanded[i]:
                error, rate = x[i] - start[i], v[i] - start_velocity[i]
                position[i] = end[i] + free.ee * error + free.er * rate
                velocity[i] = end_velocity[i] + free.re * error + free.rr * rate
            else:
                lag = 2.0 * self._damping * self._frequency
                excess = v[i] - limited[i]
                remains = math.exp(-lag * dt)
                position[i] = x[i] + limited[i] * dt + excess * (1.0 - remains) / lag
                velocity[i] = limited[i] + excess * remains
        self._move(x, (position[0], position[1], position[2]), dt)
        self.velocity = self._limited(self.position[2], (velocity[0], velocity[1], velocity[2]))

    def _move(self, start: Triple, end: Triple, dt: float) -> None:
        """Go from ``start`` to ``end``, no further than the limits allow in ``dt``."""
        mean = ((end[0] - start[0]) / dt, (end[1] - start[1]) / dt, (end[2] - start[2]) / dt)
        allowed = self._limited(start[2], mean)
        if allowed == mean:
            self.position = end
        else:
            self.position = (
                start[0] + allowed[0] * dt,
                start[1] + allowed[1] * dt,
                start[2] + allowed[2] * dt,
            )

    def _limited(self, heading: float, velocity: Triple) -> Triple:
        """Return a NED velocity, scaled so that it is within the limits in the body frame at ``heading``."""
        surge_max, sway_max, yaw_max = self._velocity_max
        surge, sway, yaw = to_body(heading, velocity)
        excess = max(abs(surge) / surge_max, abs(sway) / sway_max)
        limited_yaw = min(max(yaw, -yaw_max), yaw_max)
        if excess <= 1.0:
            return velocity[0], velocity[1], limited_yaw
        return velocity[0] / excess, velocity[1] / excess, limited_yaw
