"""The sea at the ship: waves that come and go, and what they do to the hull."""

from __future__ import annotations

import math

import numpy as np

from marine_model.constants import GRAVITY
from marine_model.guards import FloatArray
from vessel_sim.settings import WaveSettings
from vessel_sim.waves.components import (
    AMPLITUDE,
    BETA,
    COS_BETA,
    OMEGA,
    PHASE,
    RAMP,
    SIN_BETA,
    SLOWNESS,
    START,
    WIDTH,
)
from vessel_sim.waves.drift import drift_force
from vessel_sim.waves.from_settings import components_of
from vessel_sim.waves.hull_in_waves import HullInWaves
from vessel_sim.waves.hull_motion import Triple, hull_motion
from vessel_sim.waves.response_table import FUNCTIONS, NODES
from vessel_sim.waves.sea import Sea

_LENGTHS = 20.0  # of the hull that the end of a ramp is ahead of it before its step counts as one for ever
_LOOK = 1.0  # s between two looks for such steps

Key = tuple[float, ...]  # frequency, direction and phase of a component


class Waves(Sea):
    """The sea that settings ask for, with the fronts that changes send through it.

    A change at time t adds a step to the amplitude of every component that differs: from what the amplitude is at the
    wave maker then to what it shall be, over ``ramp``. The maker lies ``maker_distance`` before the map origin, on a
    line across the waves, and the step travels from there with the group velocity of its component. Without a distance
    there is no maker, and the step comes everywhere at once. Steps whose ramp has passed the ship by 20 lengths are
    put together.

    Parameters
    ----------
    hull
        What waves do to it.
    settings
        Waves from time 0 on; ``maker_distance`` is that of the run.
    seed
        Of irregular seas: an integer, or what numpy spawns from one.
    """

    def __init__(self, hull: HullInWaves, settings: WaveSettings, seed: int | np.random.SeedSequence = 0) -> None:
        self._hull = hull
        self._seed = seed
        self._horizon = _LENGTHS * hull.length
        self._distance = settings.maker_distance
        self._targets: dict[Key, float] = {}
        self._known: dict[Key, FloatArray] = {}
        self._components: FloatArray = np.zeros((0, WIDTH))
        self._response: FloatArray = np.zeros((0, NODES, 2 * FUNCTIONS))
        self.next_look = math.inf
        """Time from which ``tidy`` may find something, s."""
        self.apply(settings, 0.0)
        if settings.ramp == 0.0 and self._distance == 0.0:
            self._components[:, START] = -math.inf  # there since ever
            self.next_look = math.inf

    @property
    def components(self) -> FloatArray:
        """Steps of components, shape (m, ``components.WIDTH``); a new array after every change."""
        return self._components

    @property
    def response(self) -> FloatArray:
        """What each does to the hull, shape (m, NODES, 2 FUNCTIONS); see ``response_table``."""
        return self._response

    def apply(self, settings: WaveSettings, time: float) -> None:
        """Send out other waves from ``time`` (s) on."""
        wanted = components_of(settings, self._seed)
        rows = dict(zip(_keys(wanted), wanted, strict=True))
        goals = {key: float(row[AMPLITUDE]) for key, row in rows.items()}
        changed = [key for key in {**self._targets, **goals} if goals.get(key, 0.0) != self._targets.get(key, 0.0)]
        if not changed:
            return
        kept, reached = self._cut_short(frozenset(changed), time)
        steps = []
        for key in changed:
            goal = self._targets[key] = goals.get(key, 0.0)
            if goal == reached.get(key, 0.0):
                continue  # nothing of the last step has left the maker
            step = rows[key].copy() if key in rows else self._row(key)
            step[AMPLITUDE] = goal - reached.get(key, 0.0)
            step[SLOWNESS] = 2.0 * step[OMEGA] / GRAVITY if self._distance > 0.0 else 0.0
            step[START] = time + self._distance * step[SLOWNESS]
            step[RAMP] = settings.ramp
            steps.append(step)
        self._take(np.vstack([kept, *steps]))
        self.next_look = time

    def _cut_short(self, changed: frozenset[Key], time: float) -> tuple[FloatArray, dict[Key, float]]:
        """Return the table with what has left the maker of the steps of ``changed``, and what those add up to."""
        reached = {key: amplitude for key, amplitude in self._targets.items() if key in changed}
        kept = []
        for key, row in zip(_keys(self._components), self._components.copy(), strict=True):
            since = time - (row[START] - self._distance * row[SLOWNESS])
            if key in changed and since < row[RAMP]:
                share = since / row[RAMP]
                reached[key] -= (1.0 - share) * row[AMPLITUDE]
                row[AMPLITUDE] *= share
                row[RAMP] = since
                if since <= 0.0:
                    continue
            kept.append(row)
        return _table(kept), reached

    def tidy(self, north: float, east: float, time: float) -> None:
        """Put steps together whose fronts are far ahead of the ship at ``north``, ``east`` (m) at ``time`` (s)."""
        table = self._components
        ahead = north * table[:, COS_BETA] + east * table[:, SIN_BETA] + self._horizon
        passed = time - ahead * table[:, SLOWNESS] - table[:, START] >= table[:, RAMP]
        if (passed & (table[:, START] > -math.inf)).any():
            self._take(self._merged(passed))
        waiting = bool((self._components[:, START] > -math.inf).any())
        self.next_look = time + _LOOK if waiting else math.inf

    def _merged(self, passed: np.ndarray) -> FloatArray:
        """Return the table with one row for all passed steps of a component, and none where they cancel."""
        groups: dict[Key, list[int]] = {}
        for i, key in enumerate(_keys(self._components)):
            groups.setdefault(key, []).append(i)
        rows = []
        for key, members in groups.items():
            settled = [i for i in members if passed[i]]
            waiting = [i for i in members if not passed[i]]
            if settled:
                row = self._components[settled[0]].copy()
                # The target itself, as sums of changes round.
                row[AMPLITUDE] = self._components[settled, AMPLITUDE].sum() if waiting else self._targets[key]
                row[START], row[RAMP] = -math.inf, 0.0
                if row[AMPLITUDE] != 0.0:
                    rows.append(row)
            rows.extend(self._components[i] for i in waiting)
            if not waiting and self._targets[key] == 0.0:
                del self._targets[key]
        return _table(rows)

    def _row(self, key: Key) -> FloatArray:
        """Return a row of a component that is in the table."""
        row: FloatArray = self._components[_keys(self._components).index(key)]
        return row.copy()

    def _take(self, table: FloatArray) -> None:
        keys = _keys(table)
        new = [i for i, key in enumerate(keys) if key not in self._known]
        if new:
            self._known.update(zip([keys[i] for i in new], self._hull.table(table[new]), strict=True))
        self._known = {key: self._known[key] for key in keys}
        self._components = np.ascontiguousarray(table)
        if keys:
            self._response = np.stack([self._known[key] for key in keys])
        else:
            self._response = np.zeros((0, NODES, 2 * FUNCTIONS))

    def drift_force(self, position: Triple, time: float) -> Triple:
        """Return the mean and slowly varying second-order force: N, N, N m in the body frame; see ``drift``."""
        return drift_force(self._components, self._response, position, time)

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
        moved, rate = hull_motion(self._components, self._response, position, velocity, time)
        c, s = math.cos(position[2]), math.sin(position[2])
        return (
            (c * moved[0] - s * moved[1], s * moved[0] + c * moved[1], moved[5]),
            (c * rate[0] - s * rate[1], s * rate[0] + c * rate[1], rate[5]),
        )


def _table(rows: list[FloatArray]) -> FloatArray:
    table: FloatArray = np.array(rows, dtype=np.float64).reshape(len(rows), WIDTH)
    return table


def _keys(table: FloatArray) -> list[Key]:
    return [tuple(row) for row in table[:, [OMEGA, BETA, PHASE]].tolist()]
