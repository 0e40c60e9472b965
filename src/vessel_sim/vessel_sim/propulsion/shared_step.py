"""The step of a great many thrusters on all processors: threads take portions of rows in turn."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property

from marine_model.guards import FloatArray
from vessel_sim.propulsion.columns import INPUTS
from vessel_sim.propulsion.step import GOOD, advance, advance_rows_unlocked, first_bad

# Rows at a time: some 0.1 ms, several times what it takes to wake a thread.
_PORTION = 1000


class SharedStep:
    """``step.advance``, shared among threads where there are rows enough.

    Rows know nothing of each other: the result is the same to the last bit for any number of threads.

    Parameters
    ----------
    rows
        Number of thrusters, n.
    threads
        Threads to share a step among; None: as many as there are processors, if there is a portion for each.
    """

    def __init__(self, rows: int, threads: int | None = None) -> None:
        if threads is None:
            threads = min(len(os.sched_getaffinity(0)), rows // _PORTION)
        self.threads = max(threads, 1)
        self._rows = rows

    def advance(
        self,
        tables: tuple[FloatArray, FloatArray, FloatArray],
        state: FloatArray,
        inputs: FloatArray,
        before: FloatArray,
        unchecked: int,
        ventilates: bool,
        dt: float,
    ) -> int:
        """Advance ``state``; see ``step.advance``."""
        if self.threads <= 1:
            return advance(*tables, state, inputs, before, unchecked, ventilates, dt)
        bad = first_bad(tables[0], state, inputs, before, unchecked, INPUTS)
        if bad != GOOD:
            return bad
        portions = iter(range(0, self._rows, _PORTION))

        def work() -> None:
            for first in portions:  # one after the other, in whichever thread is free: next() is atomic
                end = min(first + _PORTION, self._rows)
                advance_rows_unlocked(*tables, state, inputs, ventilates, dt, first, end)

        others = [self._pool.submit(work) for _ in range(self.threads - 1)]
        work()
        for other in others:
            if not other.cancel():  # what a busy processor has not begun is done already
                other.result()
        return GOOD

    @cached_property
    def _pool(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(self.threads - 1, thread_name_prefix="propulsion")
