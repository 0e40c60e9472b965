"""Keeps thrusters out of forbidden sectors: every step, chooses the windows and says what they leave of the circle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.phase import Limit
from thrust_allocator.polar import Command
from thrust_allocator.sectors.geometry import factor_at, vessel_sectors
from thrust_allocator.sectors.path import Reach, nearest_window, path_into, reach_table, sector_table
from thrust_allocator.sectors.pieces import Pieces
from thrust_allocator.sectors.search import best_combination, sub_problem_cost
from thrust_allocator.sectors.supervisor import (
    Candidate,
    SupervisorState,
    SwitchingRule,
    advance,
    cost_limits,
    decide,
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
        self._unlimited = [thruster.windows[0].disc for thruster in self._thrusters]
        self._force = np.zeros((len(self._thrusters), 2))
        self.reset()

    @property
    def combinations(self) -> int:
        """Number of sub-problems."""
        return int(np.prod(self._counts))

    def reset(self) -> None:
        """Forget what was chosen."""
        n = len(self._thrusters)
        self._state = SupervisorState((0,) * n)
        self._rotates = [False] * n
        self._multiplier = np.zeros(3)

    def apply(self, limits: FloatArray, rule: SwitchingRule) -> None:
        """Take the table of limits, shape (n, 14), and the rule of the supervisor; they hold from the next step on."""
        self._rule = rule
        self._pieces.limit(limits)

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
        azimuth = np.ascontiguousarray(before[:, Command.AZIMUTH])
        angles: list[float] = azimuth.tolist()
        rotates = ((limits[:, Limit.ENABLED] * limits[:, Limit.MAY_ROTATE] * limits[:, Limit.ROTATING]) != 0.0).tolist()
        state = self._entered(rotates, angles, limits)
        table, pieces = self._table, self._pieces
        choice = np.array(state.windows, dtype=np.int64)
        reach = reach_table(azimuth, choice, *table)
        for j, may in enumerate(rotates):
            if not may:
                first = int(pieces.first[j])
                reach[first : first + self._counts[j]] = _OUT_OF_REACH
                reach[first + state.windows[j]] = Reach.FREE
        state = advance(state, dt)
        what = (self._columns, weight, self._compliance, tau, pieces.corners, pieces.count, pieces.first)
        cost = sub_problem_cost(*what, choice, self._multiplier, self._force)
        # First what needs no turn, for it is taken at once and becomes what the rest is measured by.
        solved = 1
        candidates: list[Candidate] = []
        for furthest in (Reach.FREE, Reach.CROSS):
            limits_of_cost = cost_limits(state, self._rule, candidates[0].cost if candidates else cost)
            if furthest is Reach.FREE:
                limit = limits_of_cost.free
            else:
                limit = limits_of_cost.turn
                if limits_of_cost.cross < limit:
                    furthest = Reach.TURN
            least, more = best_combination(*what, reach, int(furthest), limit, self._multiplier, choice)
            solved += more
            if least < limit:
                windows = tuple(choice.tolist())
                hardest = max(int(reach[pieces.first[j] + i]) for j, i in enumerate(windows))
                candidates.append(Candidate(windows, least, hardest))
        chosen = decide(state, self._rule, cost, candidates)
        for candidate in candidates:
            if candidate.windows == chosen.windows:
                cost = candidate.cost
        self._state = chosen
        crossing = self._narrow(limits, angles, rotates)
        number = 0
        for count, index in zip(self._counts, chosen.windows, strict=True):
            number = number * count + index
        return SectorReport(number + 1, chosen.windows, cost, crossing, solved)

    def _entered(self, rotates: list[bool], angles: list[float], limits: FloatArray) -> SupervisorState:
        """Return the state with the windows of thrusters that rotate from now on, or no longer."""
        state = self._state
        windows = list(state.windows)
        for j, may in enumerate(rotates):
            if not may:
                windows[j] = 0
                self._pieces.hold(j, limits, angles[j])
            elif not self._rotates[j]:
                windows[j] = nearest_window(self._thrusters[j], angles[j], windows[j])
                self._pieces.limit_one(j, limits)
        self._rotates = rotates
        return SupervisorState(tuple(windows), state.since_crossing)

    def _narrow(self, limits: FloatArray, angles: list[float], rotates: list[bool]) -> tuple[bool, ...]:
        crossing = []
        table = self._table
        for j, thruster in enumerate(self._thrusters):
            limits[j, Limit.REACH_LOW], limits[j, Limit.REACH_HIGH] = -np.inf, np.inf
            limits[j, Limit.TO_WINDOW], limits[j, Limit.FACTOR] = 0.0, 1.0
            turn = 0.0
            if rotates[j] and not self._unlimited[j]:
                window = thruster.windows[self._state.windows[j]]
                first, last = table.first_forbidden[j], table.first_forbidden[j + 1]
                _, turn, _ = path_into(angles[j], window.centre, window.half_width, table.forbidden, first, last)
                offset = (angles[j] - window.centre + np.pi) % (2.0 * np.pi) - np.pi
                limits[j, Limit.REACH_LOW] = -window.half_width - offset
                limits[j, Limit.REACH_HIGH] = window.half_width - offset
                limits[j, Limit.TO_WINDOW] = turn
            if rotates[j] and thruster.limited:
                limits[j, Limit.FACTOR] = factor_at(thruster, angles[j])
            crossing.append(turn != 0.0)
        return tuple(crossing)
