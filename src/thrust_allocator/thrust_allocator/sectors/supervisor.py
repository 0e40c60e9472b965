"""Which combination of windows is used: hysteresis and dwell time, [Ruth] (6.1)-(6.2)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.gains import SectorGains
from marine_model.guards import positive_number
from thrust_allocator.sectors.path import Reach

# s; sixty steps of 0.05 s add up to less than 3 s, by rounding.
_TIME_TOLERANCE = 1e-9
# Share of a cost that is rounding: where windows overlap their sub-problems are often the same, and must not alternate.
_COST_ROUNDING = 1e-10


class SwitchingRule(NamedTuple):
    """``cost_ratio``: share of the present cost below which another combination is worth a turn."""

    dwell_time: float  # s
    cost_ratio: float


class SupervisorState(NamedTuple):
    """All that the supervisor remembers: chosen window of each thruster, and time (s) since one began to cross."""

    windows: tuple[int, ...]
    since_crossing: float = math.inf


class Candidate(NamedTuple):
    """A combination of windows, what it costs, and the largest :class:`Reach` of its thrusters (or its number)."""

    windows: tuple[int, ...]
    cost: float
    reach: Reach | int


class CostLimits(NamedTuple):
    """What a candidate must cost less than, by its reach. No cost is below minus infinity."""

    free: float
    turn: float
    cross: float


def switching_rule(gains: SectorGains) -> SwitchingRule:
    """Return the rule with the logarithm taken out of (6.2): J < 10^-J_lim J_0, which needs no logarithm of zero."""
    return SwitchingRule(gains.dwell_time, 10.0**-gains.hysteresis)


def advance(state: SupervisorState, dt: float) -> SupervisorState:
    """Return the state ``dt`` (s) later, to be decided on. Raises InputError if ``dt`` is not above 0."""
    return SupervisorState(state.windows, state.since_crossing + positive_number("dt", dt))


def may_cross(state: SupervisorState, rule: SwitchingRule) -> bool:
    """Return whether the dwell time since the last crossing is over."""
    return state.since_crossing >= rule.dwell_time - _TIME_TOLERANCE


def cost_limits(state: SupervisorState, rule: SwitchingRule, free_cost: float) -> CostLimits:
    """Return what is worth switching for; a search may drop every candidate that has a lower bound above its limit.

    Parameters
    ----------
    state
        After :func:`advance`.
    rule
        Hysteresis and dwell time.
    free_cost
        The least cost found without a turn: of the present combination and all that are free. (N^2, at least 0: the
        constant part of (4.4) belongs to it, or a ratio of costs has no meaning.)

    Raises
    ------
    InputError
        If ``free_cost`` is NaN or negative.
    """
    if not free_cost >= 0.0:
        raise InputError(f"cost: expected a number of at least 0, found {free_cost}")
    return CostLimits(*limits_of_cost(free_cost, rule.cost_ratio, may_cross(state, rule)))


@compiled
def limits_of_cost(free_cost: float, cost_ratio: float, crossing: bool) -> tuple[float, float, float]:
    """Return :class:`CostLimits` for machine code; ``crossing``: the dwell time is over."""
    turn = free_cost * cost_ratio
    return free_cost * (1.0 - _COST_ROUNDING), turn, turn if crossing else -math.inf


def decide(
    state: SupervisorState, rule: SwitchingRule, present_cost: float, candidates: Iterable[Candidate]
) -> SupervisorState:
    """Return the combination to use from now on.

    The cheapest free candidate replaces the present combination at once, since no thruster has to turn for it. What
    needs a turn must then be cheaper than that by the hysteresis; what needs a crossing, after the dwell time too. The
    cheapest of all that pass is chosen; of two that cost the same, the one with the smaller reach, then the first by
    index. The order of the candidates does not matter, nor those that :func:`cost_limits` lets one drop.

    Parameters
    ----------
    state
        After :func:`advance`.
    rule
        Hysteresis and dwell time.
    present_cost
        J of ``state.windows`` in this step, at least 0; infinite if it has no solution.
    candidates
        The others; the present one is passed over. A cost of NaN (no solution) is never chosen.

    Raises
    ------
    InputError
        If ``present_cost`` is NaN or negative.
    """
    limit = cost_limits(state, rule, present_cost).free
    best = Candidate(state.windows, present_cost, Reach.FREE)
    free: list[Candidate] = []
    turning: list[Candidate] = []
    for candidate in candidates:
        if candidate.windows == state.windows:
            continue
        if candidate.reach:
            turning.append(candidate)
        elif candidate.cost < limit:
            free.append(candidate)
    if free:
        best = min(free, key=_rank)
    if turning:
        limits = cost_limits(state, rule, best.cost)
        best = min((c for c in turning if c.cost < limits[c.reach]), key=_rank, default=best)
    if best.windows is state.windows:
        return state
    return SupervisorState(best.windows, 0.0 if best.reach == Reach.CROSS else state.since_crossing)


def _rank(candidate: Candidate) -> tuple[float, int, tuple[int, ...]]:
    return candidate.cost, candidate.reach, candidate.windows
