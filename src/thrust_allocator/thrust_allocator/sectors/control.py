"""Keeps thrusters out of forbidden sectors: every step, chooses the windows and says what they leave of the circle."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from marine_model import Vessel
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.sector import ANGLE_TOLERANCE
from thrust_allocator.plan.phase import FIXED, LOST, ROTATING, Limit, Plan
from thrust_allocator.plan.polar import Command
from thrust_allocator.program.active_set import IntArray
from thrust_allocator.program.problem import AllocationProblem, Weights
from thrust_allocator.sectors.geometry import combinations, factor_at, least_factor, vessel_sectors
from thrust_allocator.sectors.path import Reach, narrow, nearest_window, reach_table, sector_table
from thrust_allocator.sectors.pieces import Pieces
from thrust_allocator.sectors.search import best_combination, survey
from thrust_allocator.sectors.supervisor import (
    Candidate,
    SupervisorState,
    SwitchingRule,
    advance,
    decide,
    may_cross,
)

# Reach of a window that a thruster cannot be turned to at all.
_OUT_OF_REACH = int(Reach.CROSS) + 1


class SectorReport(NamedTuple):
    """What the supervisor decided in one step.

    Attributes
    ----------
    sub_problem
        Number of the chosen combination, from 1, as in Table 6.1.
    windows
        Index of the chosen window of every thruster.
    cost
        (4.20) of that combination, without rates.
    crossing
        Per thruster: outside its window, on the way to it.
    solved
        Combinations solved in this step, the present one included.
    """

    sub_problem: int
    windows: tuple[int, ...]
    cost: float
    crossing: tuple[bool, ...]
    solved: int


class SectorControl:
    """Supervisor and search for one vessel, [Ruth] 6.4.1.

    Parameters
    ----------
    vessel
        Sectors of its thrusters; it may have none.
    columns, compliance
        B, shape (n, 3, 2), and the diagonal of Q^-1, shape (3,), as in :func:`active_set.solve`.
    """

    def __init__(self, vessel: Vessel, columns: FloatArray, compliance: FloatArray) -> None:
        self._thrusters = vessel_sectors(vessel)
        self._table = sector_table(self._thrusters)
        self._pieces = Pieces(self._thrusters)
        self._columns, self._compliance = columns, compliance
        self._counts = [len(thruster.windows) for thruster in self._thrusters]
        self._reduced = [j for j, thruster in enumerate(self._thrusters) if thruster.limited]
        self._none_crossing = (False,) * len(self._thrusters)
        self._free: IntArray = np.zeros(len(self._thrusters), dtype=np.int64)
        self._far: IntArray = np.zeros(len(self._thrusters), dtype=np.int64)
        self.reset()

    def reset(self) -> None:
        """Forget what was chosen."""
        n = len(self._thrusters)
        self._state = SupervisorState((0,) * n)
        self._choose(self._state)
        self._rotates: list[bool] = [False] * n
        self._crossing = self._none_crossing
        self._limited = np.zeros(n, dtype=np.int64)
        self._barred: list[int] = []
        self._still: list[int] = []
        self._held_at = np.full(n, np.nan)
        self._key = b""
        self._multiplier = np.zeros(3)

    def apply(self, rule: SwitchingRule) -> None:
        """Take the rule of the supervisor; it holds from the next step on."""
        self._rule = rule
        self._key = b""

    def step(
        self, limits: FloatArray, before: FloatArray, weight: FloatArray, tau: FloatArray, dt: float
    ) -> SectorReport:
        """Choose the windows for a demand, and write into ``limits`` what they leave to every thruster in this step.

        Parameters
        ----------
        limits
            Table of limits, shape (n, 14); the columns from ``REACH_LOW`` on are written.
        before
            Commands of the step before, shape (n, 5).
        weight
            Diagonal of W_u^2, shape (n,).
        tau
            Demanded generalized force, shape (3,).
        dt
            Time step, s.
        """
        azimuth = before[:, Command.AZIMUTH].copy()
        # What a thruster may do seldom changes, and comparing bytes is quick.
        key = limits[:, : Limit.THRUST_RATE].tobytes()
        if key != self._key:
            self._key = key
            self._pieces.limit(limits)
            # Three columns that are 0 or 1.
            self._enter([all(row) for row in limits[:, : Limit.THRUST_MIN].tolist()], azimuth)
        for j in self._still:
            if azimuth[j] != self._held_at[j]:
                self._held_at[j] = azimuth[j]
                factor = factor_at(self._thrusters[j], float(azimuth[j]))
                self._pieces.hold(j, limits, float(azimuth[j]), factor)
        table, pieces, rule = self._table, self._pieces, self._rule
        reach = reach_table(azimuth, self._chosen, *table)
        reach[self._barred] = _OUT_OF_REACH
        state = advance(self._state, dt)
        cost, free_cost, far_cost, hardest, solved = survey(
            self._columns,
            weight,
            self._compliance,
            tau,
            pieces.corners,
            pieces.count,
            pieces.first,
            reach,
            rule.cost_ratio,
            may_cross(state, rule),
            self._multiplier,
            self._chosen,
            self._free,
            self._far,
        )
        if min(free_cost, far_cost) < np.inf:
            candidates = [
                candidate
                for candidate in (
                    Candidate(tuple(self._free.tolist()), free_cost, Reach.FREE),
                    Candidate(tuple(self._far.tolist()), far_cost, hardest),
                )
                if candidate.cost < np.inf
            ]
            state = decide(state, rule, cost, candidates)
            cost = next((candidate.cost for candidate in candidates if candidate.windows == state.windows), cost)
            self._choose(state)
        self._state = state
        outside = narrow(limits, azimuth, self._chosen, self._limited, *table)
        limits[:, Limit.FACTOR] = 1.0
        for j in self._reduced:
            limits[j, Limit.FACTOR] = self._factor(j, limits[j], float(azimuth[j]), dt)
        self._crossing = tuple((limits[:, Limit.TO_WINDOW] != 0.0).tolist()) if outside else self._none_crossing
        return SectorReport(self._number, state.windows, cost, self._crossing, solved)

    def optimum(self, weight: FloatArray, tau: FloatArray) -> tuple[float, tuple[int, ...]]:
        """Return the least cost of all combinations and its windows, however far they are; nothing is changed.

        Parameters
        ----------
        weight
            Diagonal of W_u^2, shape (n,).
        tau
            Demanded generalized force, shape (3,).
        """
        pieces, choice = self._pieces, self._chosen.copy()
        reach = np.zeros(len(pieces.count), dtype=np.int64)
        reach[self._barred] = _OUT_OF_REACH
        what = (self._columns, weight, self._compliance, tau, pieces.corners, pieces.count, pieces.first)
        cost, _ = best_combination(*what, reach, int(Reach.CROSS), np.inf, self._multiplier, choice)
        return cost, tuple(choice.tolist())

    def problems(self, weights: Weights, tau: FloatArray) -> list[AllocationProblem]:
        """Return the sub-problems of all combinations as objects, in the order of Table 6.1, as they stand.

        Parameters
        ----------
        weights
            Of the vessel.
        tau
            Demanded generalized force, shape (3,).
        """
        pieces = self._pieces
        found = []
        for windows in combinations(self._thrusters):
            rows = pieces.first[:-1] + np.array(windows)
            corners, count = pieces.corners[rows], pieces.count[rows]
            plans = np.zeros((len(windows), Plan.COLUMNS))
            for j, size in enumerate(count.tolist()):
                if size == 2:
                    # Along its direction, from the lower to the upper limit.
                    ends = corners[j, 1] - corners[j, 0]
                    azimuth = math.atan2(ends[1], ends[0])
                    along = corners[j, :2] @ np.array((math.cos(azimuth), math.sin(azimuth)))
                    plans[j, : Plan.AZIMUTH + 1] = FIXED, *along, azimuth
                else:
                    plans[j, Plan.PHASE] = ROTATING if size > 2 else LOST
            found.append(AllocationProblem(weights, plans, tau, polygons=(corners, count)))
        return found

    def _factor(self, j: int, limits: FloatArray, azimuth: float, dt: float) -> float:
        """Return the share of the largest thrust that thruster ``j`` may give in a step of ``dt`` (s)."""
        turn = float(limits[Limit.TO_WINDOW])
        if self._rotates[j] and turn == 0.0:
            # Wherever the step leads in the window, its end included, where another begins.
            return self._thrusters[j].windows[int(self._chosen[j])].thrust_factor
        reach = float(limits[Limit.AZIMUTH_RATE]) * dt
        return least_factor(self._thrusters[j], azimuth, min(max(turn, -reach), reach))

    def _choose(self, state: SupervisorState) -> None:
        self._chosen = np.array(state.windows, dtype=np.int64)
        number = 0
        for count, index in zip(self._counts, state.windows, strict=True):
            number = number * count + index
        self._number = number + 1

    def _inside(self, j: int, azimuth: float) -> bool:
        window = self._thrusters[j].windows[int(self._chosen[j])]
        return abs(wrap_angle(azimuth - window.centre)) <= window.half_width + ANGLE_TOLERANCE

    def _enter(self, rotates: list[bool], azimuth: FloatArray) -> None:
        """Choose windows for thrusters that rotate from now on, and leave those of the others alone.

        A thruster that is outside its window without having been on the way to it was moved meanwhile, with sectors
        switched off. It begins anew as well.
        """
        windows = list(self._state.windows)
        self._barred = []
        for j, may in enumerate(rotates):
            first = int(self._pieces.first[j])
            if not may:
                # Whatever it is held at is in the place of its first window.
                windows[j] = 0
                self._barred += range(first + 1, first + self._counts[j])
            elif not self._rotates[j] or (not self._crossing[j] and not self._inside(j, float(azimuth[j]))):
                windows[j] = nearest_window(self._thrusters[j], float(azimuth[j]), windows[j])
            self._limited[j] = may and not self._thrusters[j].windows[0].disc
        self._rotates = rotates
        self._still = [j for j, may in enumerate(rotates) if not may]
        self._held_at[:] = np.nan
        self._state = SupervisorState(tuple(windows), self._state.since_crossing)
        self._choose(self._state)
