"""The step of a great many thrusters in portions, for a caller that has threads for them."""

from __future__ import annotations

from collections.abc import Callable

from marine_model.guards import FloatArray
from vessel_sim.propulsion.columns import INPUTS
from vessel_sim.propulsion.step import GOOD, advance, advance_rows_unlocked, first_bad

# Rows at a time: some 0.1 ms, several times what it takes to wake a thread.
_PORTION = 1000

Spread = Callable[[Callable[[], None]], None]


def advance_shared(
    spread: Spread | None,
    tables: tuple[FloatArray, FloatArray, FloatArray],
    state: FloatArray,
    inputs: FloatArray,
    before: FloatArray,
    unchecked: int,
    ventilates: bool,
    dt: float,
) -> int:
    """Do what ``step.advance`` does, with the help of ``spread`` where there is more than one portion.

    Rows know nothing of each other: the result is the same to the last bit for any number of threads.
    """
    rows = len(state)
    if spread is None or rows <= _PORTION:
        return advance(*tables, state, inputs, before, unchecked, ventilates, dt)
    bad = first_bad(tables[0], state, inputs, before, unchecked, INPUTS)
    if bad != GOOD:
        return bad
    portions = iter(range(0, rows, _PORTION))

    def work() -> None:
        for first in portions:  # one after the other, in whichever thread is free: next() is atomic
            end = min(first + _PORTION, rows)
            advance_rows_unlocked(*tables, state, inputs, ventilates, dt, first, end)

    spread(work)
    return GOOD
