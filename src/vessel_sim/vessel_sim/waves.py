"""Regular deep-water waves: elevation, first-order motion of the hull and mean drift force.

A train travels towards direction beta (NED). With k = omega^2 / g and phase

    theta = k (north cos beta + east sin beta) - omega t,

the elevation is a cos(theta) and a water particle at depth z is displaced by -a exp(k z) sin(theta) along the
direction of travel (linear wave theory). Since theta is taken at the position of the ship, a ship under way meets
the waves at the frequency of encounter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from marine_model.constants import GRAVITY
from marine_model.vessel import Vessel
from vessel_sim.settings import WaveSettings

Triple = tuple[float, float, float]


def _j0(x: float) -> float:
    """Spherical Bessel function of order 0: the mean of cos(2 x s) over -1/2 < s < 1/2."""
    return math.sin(x) / x if abs(x) > 1e-4 else 1.0 - x * x / 6.0


def _j1(x: float) -> float:
    """Spherical Bessel function of order 1; below 0.01 by its series, where the two terms cancel."""
    if abs(x) < 0.01:
        return x / 3.0 * (1.0 - x * x / 10.0)
    return (math.sin(x) / x - math.cos(x)) / x


@dataclass(frozen=True, slots=True)
class HullForm:
    """A box of the length, beam and draught of the hull, and what waves do to it.

    First-order motion: the box is carried with the water that it displaces (Froude-Krylov forces; diffraction left
    out). Surge and sway are the mean of the horizontal particle displacement over the box, yaw is the rotation
    that fits the displacements best, integral(x xi_y - y xi_x) / integral(x^2 + y^2). With b the direction of the
    waves relative to the heading, X = k L cos b / 2, Y = k B sin b / 2 and e = (1 - exp(-k T)) / (k T):

        surge = -a e j0(X) j0(Y) cos b sin(theta)
        sway  = -a e j0(X) j0(Y) sin b sin(theta)
        yaw   = -a e 6 [L j1(X) j0(Y) sin b - B j0(X) j1(Y) cos b] / (L^2 + B^2) cos(theta)

    Mean drift: see ``marine_model.hull.WaveForces``.
    """

    length: float
    beam: float
    draught: float
    drift: Triple  # N/m^2, N/m^2, N/m: force per amplitude squared at the heading where each is largest

    @classmethod
    def of(cls, vessel: Vessel) -> HullForm:
        """Return the box of ``vessel``."""
        hull = vessel.hull
        c0, c1, c2 = vessel.wave_forces.drift_coefficient
        half = 0.5 * vessel.density * GRAVITY
        return cls(
            hull.length,
            hull.beam,
            hull.draught,
            (
                c0 * half * hull.beam,
                c1 * half * hull.length,
                c2 * half * hull.length * hull.beam,
            ),
        )

    def response(self, wave_number: float, cos_b: float, sin_b: float) -> Triple:
        """Return amplitudes per metre of wave: surge and sway as -sin(theta), yaw (rad/m) as -cos(theta)."""
        kt = wave_number * self.draught
        depth = -math.expm1(-kt) / kt
        x = 0.5 * wave_number * self.length * cos_b
        y = 0.5 * wave_number * self.beam * sin_b
        j0x, j0y = _j0(x), _j0(y)
        mean = depth * j0x * j0y
        lever = self.length * _j1(x) * j0y * sin_b - self.beam * j0x * _j1(y) * cos_b
        return (
            mean * cos_b,
            mean * sin_b,
            depth * 6.0 * lever / (self.length**2 + self.beam**2),
        )


class WaveTrain:
    """Waves of one period and direction whose amplitude moves linearly to a target."""

    __slots__ = ("_rate", "amplitude", "cos_beta", "omega", "settings", "sin_beta", "target", "wave_number")

    def __init__(self, settings: WaveSettings) -> None:
        self.settings = settings
        self.omega = 2.0 * math.pi / settings.period
        self.wave_number = settings.wave_number
        self.cos_beta = math.cos(settings.direction)
        self.sin_beta = math.sin(settings.direction)
        self.amplitude = 0.0
        self.target = 0.0
        self._rate = 0.0

    @property
    def growth(self) -> float:
        """Rate of change of the amplitude now, m/s."""
        return math.copysign(self._rate, self.target - self.amplitude) if self.ramping() else 0.0

    def ramping(self) -> bool:
        """True until the amplitude has reached its target."""
        return self.amplitude != self.target

    def aim(self, amplitude: float, ramp: float) -> None:
        """Let the amplitude reach ``amplitude`` (m) in ``ramp`` (s); at once if that is 0."""
        self.target = amplitude
        if ramp > 0.0:
            self._rate = abs(amplitude - self.amplitude) / ramp
        else:
            self.amplitude = amplitude

    def advance(self, dt: float) -> None:
        """Move the amplitude on by ``dt`` (s)."""
        change = self._rate * dt
        if abs(self.target - self.amplitude) <= change:
            self.amplitude = self.target
        else:
            self.amplitude += math.copysign(change, self.target - self.amplitude)

    def phase(self, north: float, east: float, time: float) -> float:
        """Return theta, rad."""
        return self.wave_number * (north * self.cos_beta + east * self.sin_beta) - self.omega * time


class Waves:
    """The sea at the ship. Usually one train; while a change of period or direction is under way, the old one too."""

    def __init__(self, form: HullForm, settings: WaveSettings) -> None:
        self._form = form
        self._trains: list[WaveTrain] = []
        self.apply(settings)

    def apply(self, settings: WaveSettings) -> None:
        """Go over to other waves within the ramp of ``settings``."""
        kept = None
        for train in self._trains:
            same = (train.settings.period, train.settings.direction) == (settings.period, settings.direction)
            if same:
                kept = train
            train.aim(settings.amplitude if same else 0.0, settings.ramp)
        if kept is None and settings.amplitude > 0.0:
            train = WaveTrain(settings)
            train.aim(settings.amplitude, settings.ramp)
            self._trains.append(train)
        self._drop_the_dead()

    def _drop_the_dead(self) -> None:
        self._trains = [t for t in self._trains if t.ramping() or t.target > 0.0]

    def advance(self, dt: float) -> None:
        """Move the amplitudes on by ``dt`` (s)."""
        for train in self._trains:
            if train.ramping():
                train.advance(dt)
                if not train.ramping() and train.target == 0.0:
                    self._drop_the_dead()

    def elevation(self, north: float, east: float, time: float) -> float:
        """Return the undisturbed elevation (m, positive up) at a point at ``time`` (s)."""
        return sum(t.amplitude * math.cos(t.phase(north, east, time)) for t in self._trains)

    def drift_force(self, cos_heading: float, sin_heading: float) -> Triple:
        """Return the mean second-order force: N, N, N m in the body frame; trains add without interaction."""
        x = y = n = 0.0
        dx, dy, dn = self._form.drift
        for train in self._trains:
            squared = train.amplitude * train.amplitude
            cos_b = train.cos_beta * cos_heading + train.sin_beta * sin_heading
            sin_b = train.sin_beta * cos_heading - train.cos_beta * sin_heading
            x += dx * squared * cos_b
            y += dy * squared * sin_b * abs(sin_b)
            n += dn * squared * 2.0 * sin_b * cos_b
        return x, y, n

    def motion(self, position: Triple, velocity: tuple[float, float], time: float) -> tuple[Triple, Triple]:
        """Return the first-order displacement (m, m, rad in NED) and its rate of change.

        Parameters
        ----------
        position
            Low-frequency position: north (m), east (m), heading (rad).
        velocity
            Low-frequency velocity over ground: north, east (m/s). It shifts the frequency to that of encounter.
            The slow turn of the hull relative to the waves is left out of the rate of change.
        time
            s.
        """
        north, east, heading = position
        c, s = math.cos(heading), math.sin(heading)
        px = py = pn = vx = vy = vn = 0.0
        for train in self._trains:
            cos_b = train.cos_beta * c + train.sin_beta * s
            sin_b = train.sin_beta * c - train.cos_beta * s
            surge, sway, yaw = self._form.response(train.wave_number, cos_b, sin_b)
            theta = train.phase(north, east, time)
            theta_dot = train.wave_number * (velocity[0] * train.cos_beta + velocity[1] * train.sin_beta) - train.omega
            sin_t, cos_t = math.sin(theta), math.cos(theta)
            a, a_dot = train.amplitude, train.growth
            along = -a * sin_t
            along_dot = -a * cos_t * theta_dot - a_dot * sin_t
            px += surge * along
            py += sway * along
            pn -= yaw * a * cos_t
            vx += surge * along_dot
            vy += sway * along_dot
            vn += yaw * (a * sin_t * theta_dot - a_dot * cos_t)
        return (c * px - s * py, s * px + c * py, pn), (c * vx - s * vy, s * vx + c * vy, vn)
