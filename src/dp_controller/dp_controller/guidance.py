"""Where the vessel shall be: set point, timed path or present position, through the reference generator."""

from __future__ import annotations

import math

from dp_controller.reference_generator import ReferenceGenerator
from dp_controller.timed_path import TimedPath
from dp_controller.vectors import ZERO, Mask, Triple, both, masked, to_body, to_ned
from marine_model.frames import wrap_angle

NO_AXIS: Mask = (False, False, False)
_TWO_PI = 2.0 * math.pi


class Guidance:
    """Keeps target and reference while axes go in and out of automatic control.

    - An axis that becomes automatic starts from the present position and velocity of the vessel, and holds that
      position unless a set point waits.
    - A set point given while no axis could follow it waits for the first that can. It is used once: the components
      of axes that are manual then are dropped.
    - In a manual axis the reference goes along with the vessel, so that the other axes hold the line or point abeam
      of it wherever it is sailed to.
    - The heading goes to a set point the shorter way from the reference heading.

    Parameters
    ----------
    generator
        Moves the reference.
    """

    def __init__(self, generator: ReferenceGenerator) -> None:
        self.generator = generator
        self._target: Triple = ZERO
        self._waiting: Triple | None = None
        self._path: TimedPath | None = None
        self._turns = 0.0
        self._following = False
        self._joined = False  # the turn of the path is that of the reference
        self._automatic: Mask = NO_AXIS
        self._known = False  # there is a target
        self._live = False  # the reference is no older than one sample

    @property
    def has_path(self) -> bool:
        """True once a path was given."""
        return self._path is not None

    def set_setpoint(self, position: Triple) -> None:
        """Give a set point: north (m), east (m), heading (rad)."""
        self._waiting = position

    def drop_setpoint(self) -> None:
        """Forget a set point that waits."""
        self._waiting = None

    def set_path(self, path: TimedPath) -> None:
        """Give a path; it takes the place of the one before."""
        self._path = path
        self._joined = False

    def lose(self, automatic: Mask) -> None:
        """Let a sample pass without an estimate. The target stays for axes that are automatic throughout."""
        self._live = False
        self._automatic = both(self._automatic, automatic)

    def step(self, position: Triple, velocity: Triple, automatic: Mask, track: bool, now: float, dt: float) -> None:
        """Advance the reference.

        Parameters
        ----------
        position, velocity
            Estimate: NED, and body frame.
        automatic
            Which of surge, sway and yaw are automatic.
        track
            True to follow the path, if there is one.
        now, dt
            Time of the estimate and time since the last one, s.
        """
        generator = self.generator
        turned = generator.position[2]
        heading = turned + wrap_angle(position[2] - turned)
        vessel = (position[0], position[1], heading)
        if automatic == NO_AXIS:
            self._idle(vessel)
            return
        advance = self._live
        if not self._live:
            self._restart(vessel, velocity)
        staying = both(self._automatic, automatic)
        if staying != (True, True, True):
            self._carry_reference(vessel, velocity, automatic, staying)
            self._target = _carried(self._target, vessel, staying)
        self._automatic = automatic
        self._choose_target(vessel, automatic, track and self._path is not None, now)
        if advance and staying != NO_AXIS:
            self._advance(now, dt)

    def error(self, position: Triple, automatic: Mask) -> Triple:
        """Return R(heading)^T (eta_d - eta), [Ruth] (B.15), heading by the shorter way; zero in manual axes."""
        reference = self.generator.position
        north, east, heading = reference[0] - position[0], reference[1] - position[1], reference[2] - position[2]
        return masked(to_body(position[2], (north, east, wrap_angle(heading))), automatic)

    def velocity(self, heading: float) -> Triple:
        """Return the velocity of the reference in the body frame of a vessel at ``heading`` (rad)."""
        return to_body(heading, self.generator.velocity)

    def _idle(self, vessel: Triple) -> None:
        """Go along with the vessel in all axes."""
        self.generator.reset(vessel, ZERO)
        self._target = vessel
        self._automatic = NO_AXIS
        self._following = False
        self._known = self._live = True

    def _restart(self, vessel: Triple, velocity: Triple) -> None:
        """Begin at the vessel, after a start or a loss; the target stays, if there is one."""
        self.generator.reset(vessel, to_ned(vessel[2], velocity))
        target = self._target if self._known else vessel
        self._target = (target[0], target[1], vessel[2] + wrap_angle(target[2] - vessel[2]))
        self._joined = False
        self._known = self._live = True

    def _carry_reference(self, vessel: Triple, velocity: Triple, automatic: Mask, staying: Mask) -> None:
        """Put the reference on the vessel in axes that are manual or only now become automatic."""
        generator = self.generator
        own = to_body(vessel[2], generator.velocity)
        body = [own[i] if staying[i] else velocity[i] if automatic[i] else 0.0 for i in range(3)]
        generator.reset(_carried(generator.position, vessel, staying), to_ned(vessel[2], (body[0], body[1], body[2])))

    def _choose_target(self, vessel: Triple, automatic: Mask, follow: bool, now: float) -> None:
        if follow:
            if self._path is not None and not (self._following and self._joined):
                self._turns = self._nearest_turn(self._path, now)
                self._joined = True
        elif self._waiting is not None and automatic != NO_AXIS:
            heading = self.generator.position[2]
            north, east, goal = self._waiting
            self._waiting = None
            self._target = _carried((north, east, heading + wrap_angle(goal - heading)), vessel, automatic)
        elif self._following:
            self._target = vessel
        self._following = follow

    def _nearest_turn(self, path: TimedPath, now: float) -> float:
        """Return the multiple of 2 pi that brings the heading of the path nearest to that of the reference."""
        return _TWO_PI * round((self.generator.position[2] - path.at(now)[0][2]) / _TWO_PI)

    def _advance(self, now: float, dt: float) -> None:
        generator = self.generator
        count = generator.steps_in(dt)
        step = dt / count
        if not self._following or self._path is None:
            for _ in range(count):
                generator.step(self._target, ZERO, self._target, ZERO, step)
            return
        begin = self._on_path(self._path, now - dt)
        for i in range(count):
            end = self._on_path(self._path, now - (count - 1 - i) * step)
            generator.step(*begin, *end, step)
            begin = end

    def _on_path(self, path: TimedPath, time: float) -> tuple[Triple, Triple]:
        (north, east, heading), velocity = path.at(time)
        return (north, east, heading + self._turns), velocity


def _carried(point: Triple, vessel: Triple, keep: Mask) -> Triple:
    """Return ``point`` moved onto the vessel along the body axes that ``keep`` does not name."""
    if keep == (True, True, True):
        return point
    away = to_body(vessel[2], (point[0] - vessel[0], point[1] - vessel[1], point[2] - vessel[2]))
    shift = to_ned(vessel[2], masked(away, keep))
    return vessel[0] + shift[0], vessel[1] + shift[1], vessel[2] + shift[2]
