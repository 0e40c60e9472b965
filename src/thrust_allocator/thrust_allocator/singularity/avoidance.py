"""Real-time singularity avoidance: the three steps of [Ruth] 7.8.1, and two answers to the questions of 8.2.

Every method ends with the third step of the thesis: thrusters are allocated along directions that are given to them,
turn to them at full rate, and may reverse. The methods differ in the directions. See docs/singularity_avoidance.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from marine_model import Vessel
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray, positive_number
from thrust_allocator.engine import Answer, Engine
from thrust_allocator.plan.phase import Limit
from thrust_allocator.plan.polar import Command
from thrust_allocator.singularity.avoidance_descent import descend
from thrust_allocator.singularity.avoidance_detour import find_detour
from thrust_allocator.singularity.avoidance_route import Route, find_route, toll_of
from thrust_allocator.singularity.avoidance_search import Grid
from thrust_allocator.singularity.avoidance_thrusters import Thrusters, gain_at
from thrust_allocator.singularity.scaling import scaling_of
from thrust_allocator.singularity.settings import MOST_TURNING, SingularitySettings, limits_of
from thrust_allocator.step import Total

Run = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], Answer]
"""(limits, before, multiplier, tau) -> answer of the engine, with cost, power and all else that the allocator adds."""

_TIME_TOLERANCE = 1e-9  # s, rounding of sums of steps
_AT_LIMIT = 1e-6  # share of the gain limit that is rounding
# Limits of thrust count for the gain in steps of this share of the vessel's, so that a power limit that changes in
# every step does not have the map of gains computed anew each time.
_LIMIT_STEP = 0.05
# Costs are compared with that of every thruster at this share of its largest thrust added: what costs less is no
# reason to turn.
_IDLE_SHARE = 0.01
_DESCENT_STEPS = 6
# Where the best gain that can be reached is below this share of the limit, held thrusters control little in any
# configuration; rotating ones have two components of thrust each and are left alone.
_LEAST_USE = 0.5
# Weight of insufficient gain on a route that must not have any.
_CLOSED = 1e6
# Scaled generalized force that counts as none missing.
_NONE_MISSING = 0.01


class AvoidanceReport(NamedTuple):
    """What avoidance did in one step.

    Attributes
    ----------
    method
        As in the settings; 'none' where no thruster can turn, or no configuration has half the gain asked for.
    minimum_gain
        Smallest singular value of B_S at the angles commanded, reverse thrust counted.
    minimum_gain_free
        At the angles of the first step, which is free of avoidance.
    threshold
        Gain that was asked for.
    waiting
        Better angles are known and not used.
    locked
        three_step: they have not been used for long, and it costs.
    released
        On the way to the configuration chosen for a locked one, or for one of insufficient gain.
    cost_free, cost_kept
        (4.10) of the first step and of the commands.
    crossing
        On the way through insufficient gain.
    time_left
        Of the crossing, s.
    waited, toll
        Cost that waiting has had and crossing would have, N^2 s; NaN where none is considered.
    """

    method: str
    minimum_gain: float
    minimum_gain_free: float
    threshold: float
    waiting: bool
    locked: bool
    released: bool
    cost_free: float
    cost_kept: float
    crossing: bool
    time_left: float
    waited: float
    toll: float


class _Turn(NamedTuple):
    """What a step has to go on. Arrays have shape (n,)."""

    thrusters: Thrusters
    grid: Grid | None
    threshold: float
    azimuth: FloatArray  # present, rad
    low: FloatArray  # turns allowed from there, rad
    high: FloatArray
    rate: FloatArray  # rad/s
    tau: FloatArray
    dt: float


class Avoidance:
    """Chooses directions for the azimuth thrusters of one vessel, step after step.

    Parameters
    ----------
    vessel
        The vessel.
    engine
        Its engine: geometry and weights.
    settings
        Operator's choice.

    Raises
    ------
    InputError
        As :meth:`apply`.
    """

    def __init__(self, vessel: Vessel, engine: Engine, settings: SingularitySettings) -> None:
        self._vessel = vessel
        scaling = scaling_of(vessel)
        self._columns = engine.columns
        self._compliance = 1.0 / engine.weights.slack
        self._scale = np.array([1.0, 1.0, scaling.moment_scale]) / scaling.mean_thrust_max
        self._unit_columns = engine.columns * self._scale[:, None]
        self._idle = float(engine.weights.thrust @ (_IDLE_SHARE * vessel.thrust_max) ** 2)
        self._key: tuple[bytes, ...] = ()
        self._grid: Grid | None = None
        self._settings = SingularitySettings()
        self._route: Route | None = None
        self._no_detour: tuple[FloatArray, FloatArray] | None = None
        self._progress, self._waited = 0.0, 0.0
        self._crossing, self._waiting, self._recovering = False, False, False
        self._toll = math.nan
        self.reset()
        self.apply(settings)

    @property
    def settings(self) -> SingularitySettings:
        """The settings in force."""
        return self._settings

    def apply(self, settings: SingularitySettings) -> None:
        """Swap the settings whole; what has been decided stands. A change of method begins as :meth:`reset` does.

        Raises
        ------
        InputError
            If a number is missing that belongs to a vessel, or the method searches over the angles of more than four
            azimuth thrusters. The old settings stay in force.
        """
        if settings.method != "none":
            self._limits = limits_of(settings, self._vessel)
        changed = self._settings.method != settings.method
        self._settings = settings
        if changed:
            self.reset()

    def reset(self) -> None:
        """Begin anew at the next step: after another mode, or another operating point."""
        self._free_before: FloatArray | None = None
        self._free_multiplier, self._multiplier = np.zeros(3), np.zeros(3)
        self._kept: FloatArray | None = None  # alpha_B
        self._sufficient_for = 0.0  # t_2
        self._kept_for = 0.0
        self._ratio = 0.0
        self._releasing = False
        self._mean_demand: FloatArray | None = None  # scaled, filtered
        self._leave()

    def step(
        self, run: Run, limits: FloatArray, before: FloatArray, tau: FloatArray, dt: float
    ) -> tuple[Answer, AvoidanceReport]:
        """Allocate ``tau`` with singularity avoidance.

        Parameters
        ----------
        run
            Runs the engine.
        limits
            Table of limits for rotating thrusters, shape (n, 14); not changed.
        before
            Commands of the step before, shape (n, 5).
        tau
            Demand, shape (3,), N, N, N m.
        dt
            Time step, s.

        Raises
        ------
        InputError
            If ``dt`` is not a number above 0.
        """
        positive_number("dt", dt)
        if self._free_before is None:
            self._free_before = before
        free = run(limits, self._free_before, self._free_multiplier, tau)
        self._free_before, self._free_multiplier = free.commands, free.multiplier
        cost_free = float(free.totals[Total.COST])
        now = self._situation(limits, before, free.weight, tau, dt)
        if now is None:
            self._kept = None
            self._leave()
            answer = run(limits, before, self._multiplier, tau)
            self._multiplier = answer.multiplier
            cost = float(answer.totals[Total.COST])
            return answer, AvoidanceReport(
                "none", math.nan, math.nan, 0.0, False, False, False, cost_free, cost, False, 0.0, math.nan, math.nan
            )
        alpha_free = free.commands[:, Command.AZIMUTH]
        gain_free = gain_at(now.thrusters, alpha_free, np.empty(3))
        method = self._settings.method
        locked = released = False
        self._toll = math.nan
        if method == "three_step":
            self._three_step(now, alpha_free, gain_free)
            target = self._kept if self._kept is not None else now.azimuth
        else:
            target = self._follow(now, may_cross=method == "crossing")
        answer = run(_held(limits, before, target, now), before, self._multiplier, tau)
        self._multiplier = answer.multiplier
        cost = float(answer.totals[Total.COST])
        if method == "three_step":
            locked = self._watch_lock(now, cost, cost_free)
            released = self._releasing
        gain = gain_at(now.thrusters, answer.commands[:, Command.AZIMUTH], np.empty(3))
        crossing = self._route is not None and self._crossing
        return answer, AvoidanceReport(
            method,
            gain,
            gain_free,
            now.threshold,
            self._waiting,
            locked,
            released or self._recovering,
            cost_free,
            cost,
            crossing,
            self._route.duration - self._progress if self._route is not None and crossing else 0.0,
            self._waited,
            self._toll,
        )

    # What there is to turn.

    def _situation(
        self, limits: FloatArray, before: FloatArray, weight: FloatArray, tau: FloatArray, dt: float
    ) -> _Turn | None:
        """Return what the step has to go on; None where avoidance has no say."""
        azimuth = before[:, Command.AZIMUTH].copy()
        largest = limits[:, Limit.THRUST_MAX]
        used = (limits[:, Limit.ENABLED] != 0.0) & (largest > 0.0)
        turning = used & (limits[:, Limit.MAY_ROTATE] != 0.0) & (limits[:, Limit.ROTATING] != 0.0)
        if not turning.any():
            return None
        share = np.maximum(np.round(largest / self._vessel.thrust_max / _LIMIT_STEP), 1.0) * _LIMIT_STEP
        strength = np.where(used, share * self._vessel.thrust_max, 0.0)
        rate = limits[:, Limit.AZIMUTH_RATE].copy()
        key = (
            used.tobytes(),
            turning.tobytes(),
            strength.tobytes(),
            rate.tobytes(),
            np.where(used & ~turning, azimuth, 0.0).tobytes(),
        )
        thrusters = Thrusters(
            self._columns,
            self._unit_columns * strength[:, None, None],
            weight.copy(),
            self._compliance,
            limits[:, Limit.THRUST_MIN].copy(),
            limits[:, Limit.THRUST_MAX] * limits[:, Limit.FACTOR],
            np.flatnonzero(used),
            np.flatnonzero(turning),
        )
        if key != self._key:
            self._key = key
            self._grid = Grid(thrusters, azimuth) if turning.sum() <= MOST_TURNING else None
            self._leave()
        low = np.where(turning, limits[:, Limit.REACH_LOW], 0.0)
        high = np.where(turning, limits[:, Limit.REACH_HIGH], 0.0)
        threshold = self._limits.gain_limit
        if self._grid is not None:
            threshold = min(threshold, self._settings.reduced_share * self._grid.best_gain)
            if threshold < _LEAST_USE * self._limits.gain_limit:
                return None
        return _Turn(thrusters, self._grid, threshold, azimuth, low, high, rate, tau, dt)

    # [Ruth] (7.128).

    def _three_step(self, now: _Turn, alpha_free: FloatArray, gain_free: float) -> None:
        """Second step: choose alpha_B."""
        if self._kept is None:
            self._kept = now.azimuth.copy()
        self._sufficient_for = self._sufficient_for + now.dt if gain_free > now.threshold else 0.0
        if self._sufficient_for > self._limits.dwell_time - _TIME_TOLERANCE and gain_free > now.threshold:
            self._kept = alpha_free.copy()
            self._waiting, self._releasing, self._recovering = False, False, False
            self._kept_for, self._ratio = 0.0, 0.0
            return
        self._waiting = True
        fixed = np.ones(len(now.azimuth), dtype=np.bool_)
        fixed[now.thrusters.turning] = False
        self._kept = np.where(fixed, now.azimuth, self._kept)
        gain = gain_at(now.thrusters, self._kept, np.empty(3))
        if gain < now.threshold * (1.0 - _AT_LIMIT) and now.grid is not None:
            # Nothing is gained by keeping what is insufficient itself: the present angles at switching on, or what a
            # failure has left.
            self._kept = now.grid.nearest(now.thrusters, now.azimuth, now.low, now.high, now.rate, now.threshold)
            self._recovering = True
        elif self._recovering:
            self._recovering = bool(np.abs(_turns(now, self._kept)).max() > 0.0)

    def _watch_lock(self, now: _Turn, cost: float, cost_free: float) -> bool:
        """Compare first- and third-step cost; return whether the thrusters are locked, and release them."""
        if self._releasing and self._kept is not None:
            self._releasing = bool(np.abs(_turns(now, self._kept)).max() > 0.0)
        if not self._waiting:
            return False
        lock_time = self._limits.lock_time
        self._kept_for += now.dt
        self._ratio -= math.expm1(-now.dt / lock_time) * (self._advantage(cost, cost_free) - self._ratio)
        locked = self._ratio > self._settings.lock_ratio and self._kept_for > lock_time - _TIME_TOLERANCE
        if locked and self._settings.release and not self._releasing and now.grid is not None:
            best, cost_best = now.grid.best(now.thrusters, now.azimuth, now.low, now.high, now.tau, now.threshold)
            if self._advantage(cost, cost_best) > self._settings.lock_ratio:
                self._kept = best
                self._releasing = True
                self._kept_for, self._ratio = 0.0, 0.0
        return locked

    def _advantage(self, cost: float, other: float) -> float:
        """Return by how many decades ``other`` is better."""
        return math.log10((cost + self._idle) / (other + self._idle))

    # The questions of [Ruth] 8.2.

    def _follow(self, now: _Turn, may_cross: bool) -> FloatArray:
        """Return the directions for this step."""
        grid = now.grid
        if grid is None:  # refused by apply
            return now.azimuth
        demand = self._scale * now.tau
        if self._mean_demand is None:
            self._mean_demand = demand
        self._mean_demand = self._mean_demand - math.expm1(-now.dt / self._limits.lock_time) * (
            demand - self._mean_demand
        )
        if self._route is not None:
            return self._along(now)
        self._waiting = False
        gain = gain_at(now.thrusters, now.azimuth, np.empty(3))
        self._recovering = gain < now.threshold * (1.0 - _AT_LIMIT)
        if self._recovering:
            self._waited = 0.0
            return grid.nearest(now.thrusters, now.azimuth, now.low, now.high, now.rate, now.threshold)
        step = np.where(now.high > now.low, now.rate * now.dt, 0.0)
        target = now.azimuth.copy()
        here = descend(
            now.thrusters,
            now.tau,
            now.threshold,
            np.minimum(np.maximum(now.low, -step), 0.0),
            np.maximum(np.minimum(now.high, step), 0.0),
            _DESCENT_STEPS,
            target,
        )
        best, cost = grid.best(now.thrusters, now.azimuth, now.low, now.high, now.tau, now.threshold)
        if not self._advantage(here, cost) > self._settings.switch_ratio:
            self._waited = 0.0
            return target
        weight = self._settings.shortfall_price if may_cross else _CLOSED
        route = find_route(now.thrusters, now.azimuth, best, now.low, now.high, now.rate, now.threshold, weight, now.dt)
        self._waited += (here - cost) * now.dt
        self._waiting = True
        through = route is None or route.least_gain < now.threshold * (1.0 - _AT_LIMIT)
        detour = through and not may_cross
        if detour:
            free = np.isinf(now.low[now.thrusters.turning]).all() and np.isinf(now.high[now.thrusters.turning]).all()
            route = self._detour(now, grid, best) if free else None
        if route is None:
            return target
        # A demand that is moving will be elsewhere when the thrusters are half way.
        margin = self._settings.demand_margin + float(np.linalg.norm(demand - self._mean_demand))
        toll = toll_of(now.thrusters, route, now.tau, margin, self._scale)
        self._toll = toll.excess
        if toll.shortfall > _NONE_MISSING and self._waited < self._settings.patience * toll.excess:
            return target
        self._waiting = False
        self._waited = 0.0
        self._route, self._progress, self._crossing = route, 0.0, not detour
        target = self._along(now)
        if not through:
            # Another demand may turn it round at any point. A detour is kept to: from any point of it the way back
            # may look as good.
            self._route = None
        return target

    def _detour(self, now: _Turn, grid: Grid, best: FloatArray) -> Route | None:
        """Return a way round; one that was not found is looked for again when the demand or the place is another."""
        tried = (now.tau.copy(), now.azimuth.copy())
        if self._no_detour is not None and all(map(np.array_equal, tried, self._no_detour)):
            return None
        route = find_detour(now.thrusters, grid, now.azimuth, best, now.rate, now.threshold)
        self._no_detour = tried if route is None else None
        return route

    def _along(self, now: _Turn) -> FloatArray:
        """Return the next directions of the route; forget it where the rest of it needs no haste."""
        route = self._route
        if route is None:
            return now.azimuth
        self._progress = min(self._progress + now.dt, route.duration)
        at = self._progress / route.spacing if route.spacing > 0.0 else 0.0
        k = min(int(at), len(route.azimuth) - 1)
        following = min(k + 1, len(route.azimuth) - 1)
        target: FloatArray = route.azimuth[k] + (at - k) * (route.azimuth[following] - route.azimuth[k])
        unused = np.empty(3)
        rest = [target, *route.azimuth[following:]]
        done = self._progress >= route.duration
        if done or (
            self._crossing
            and all(gain_at(now.thrusters, row, unused) >= now.threshold * (1.0 - _AT_LIMIT) for row in rest)
        ):
            self._route = None
        return target

    def _leave(self) -> None:
        """Forget all that was under way."""
        self._route, self._no_detour = None, None
        self._progress, self._waited = 0.0, 0.0
        self._crossing, self._waiting, self._recovering = False, False, False
        self._toll = math.nan


def _turns(now: _Turn, target: FloatArray) -> FloatArray:
    """Return how far every thruster turns in this step towards ``target``, shape (n,), rad."""
    turns = np.zeros(len(target))
    for j in now.thrusters.turning.tolist():
        low, high = float(now.low[j]), float(now.high[j])
        turn = wrap_angle(float(target[j] - now.azimuth[j]))
        # The other way round where the window asks for it.
        ways = [t for t in (turn, turn - math.copysign(2.0 * math.pi, turn)) if low <= t <= high]
        turn = ways[0] if ways else min(max(turn, low), high)
        most = float(now.rate[j]) * now.dt
        turns[j] = min(max(turn, -most), most)
    return turns


def _held(limits: FloatArray, before: FloatArray, target: FloatArray, now: _Turn) -> FloatArray:
    """Return the limits of the third step: every thruster that can turn has its direction given."""
    held = limits.copy()
    turns = _turns(now, target)
    for j in now.thrusters.turning.tolist():
        held[j, Limit.ROTATING] = 0.0
        rest = limits[j, Limit.TO_WINDOW]
        turn = turns[j] if rest == 0.0 else rest
        held[j, Limit.DIRECTION] = wrap_angle(float(before[j, Command.AZIMUTH] + turn))
    return held
