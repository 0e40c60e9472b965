"""Regular waves at the ship: elevation, first-order motion of the hull and mean drift force."""

from __future__ import annotations

import math

import numpy as np

from marine_model.guards import FloatArray
from vessel_sim.settings import WaveSettings
from vessel_sim.waves.components import WIDTH
from vessel_sim.waves.hull_form import HullForm, Triple, box_motion
from vessel_sim.waves.sea import Sea
from vessel_sim.waves.train import WaveTrain


class Waves(Sea):
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
        self._tabulate()

    def _tabulate(self) -> None:
        rows = [train.component for train in self._trains]
        self._components = np.array(rows, dtype=np.float64).reshape(len(rows), WIDTH)

    @property
    def components(self) -> FloatArray:
        """Components now, shape (number of trains, ``components.WIDTH``)."""
        return self._components

    def advance(self, dt: float) -> None:
        """Move the amplitudes on by ``dt`` (s)."""
        changed = False
        for train in self._trains:
            if train.ramping():
                train.advance(dt)
                changed = True
        if changed:
            self._drop_the_dead()

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
        """Return the first-order displacement (m, m, rad in NED) and its rate of change; heave, roll, pitch left out.

        Parameters
        ----------
        position
            Low-frequency position: north (m), east (m), heading (rad).
        velocity
            Low-frequency velocity over ground: north, east (m/s).
        time
            s.
        """
        moved, rate = box_motion(self._components, self._form.box, position, velocity, time)
        c, s = math.cos(position[2]), math.sin(position[2])
        return (
            (c * moved[0] - s * moved[1], s * moved[0] + c * moved[1], moved[5]),
            (c * rate[0] - s * rate[1], s * rate[0] + c * rate[1], rate[5]),
        )
