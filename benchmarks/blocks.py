"""Times of single calls, in blocks that go to the candidates in turn."""

from __future__ import annotations

import gc
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from benchmarks.demands import Step

# Calls before the first that counts: caches, machine code, first allocations.
_WARM_UP = 3
# Calls at the start of a block whose times are not counted, a quarter of them at most: they find the processor's caches
# filled by the others and by the garbage collector. What the first of them takes is kept on its own.
_COLD = 5
_NANOSECOND = 1e-3  # us


@dataclass(frozen=True, slots=True)
class Candidate:
    """One way to answer steps.

    Attributes
    ----------
    prepare
        Makes the argument of ``call`` out of a step; not timed.
    call
        What is timed.
    share
        Share of the steps of each block that it is given, its first ones, in their order.
    """

    prepare: Callable[[Step], Any]
    call: Callable[[Any], Any]
    share: float = 1.0


@dataclass(slots=True)
class Calls:
    """What the calls of one candidate took and gave.

    Attributes
    ----------
    times
        us a call by the clock, calls that raised included, the first ones of a block not.
    busy
        us of this thread's processor time for the same calls: without what else the machine did meanwhile.
    cold
        us of the first call of every block, by the clock.
    places
        Index of the step of each call, all of them.
    answers
        What the calls returned; the exception for one that raised.
    """

    times: list[float] = field(default_factory=list)
    busy: list[float] = field(default_factory=list)
    cold: list[float] = field(default_factory=list)
    places: list[int] = field(default_factory=list)
    answers: list[Any] = field(default_factory=list)


def in_turn(
    candidates: Mapping[str, Candidate],
    steps: list[Step],
    blocks: int,
    read: Callable[[str, Step, Any], Any] | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, Calls]:
    """Give ``steps`` to all candidates, block by block, the order turning round from block to block.

    Garbage is collected before, not within, a candidate's share of a block. Warnings of libraries are not printed.

    Parameters
    ----------
    candidates
        By name.
    steps
        In their order.
    blocks
        Number of blocks.
    read
        Turns an answer into what is kept, right after the call and outside of its time, for libraries that overwrite
        their answers; kept as it is when None.
    progress
        Told blocks done and in all.
    """
    calls = {name: Calls() for name in candidates}
    length = max(1, len(steps) // blocks)
    for name, candidate in candidates.items():
        with _undisturbed():
            for step in steps[:_WARM_UP]:
                _call(candidate.call, candidate.prepare(step))
        calls[name] = Calls()
    for block in range(blocks):
        names = list(candidates) if block % 2 == 0 else list(candidates)[::-1]
        for name in names:
            candidate = candidates[name]
            first = block * length
            wanted = range(first, first + max(1, round(candidate.share * length)))
            with _undisturbed():
                _run(candidate, name, steps, wanted, calls[name], read)
        progress(block + 1, blocks)
    return calls


def _run(
    candidate: Candidate,
    name: str,
    steps: list[Step],
    wanted: range,
    calls: Calls,
    read: Callable[[str, Step, Any], Any] | None,
) -> None:
    uncounted = min(_COLD, len(wanted) // 4)
    for nth, place in enumerate(wanted):
        step = steps[place]
        task = candidate.prepare(step)
        spent, busy, answer = _call(candidate.call, task)
        if read is not None and not isinstance(answer, Exception):
            answer = read(name, step, answer)
        if nth == 0:
            calls.cold.append(spent)
        if nth >= uncounted:
            calls.times.append(spent)
            calls.busy.append(busy)
        calls.places.append(place)
        calls.answers.append(answer)


def _call(call: Callable[[Any], Any], task: Any) -> tuple[float, float, Any]:
    """Return time and processor time of one call, us, and its answer or exception."""
    busy = time.thread_time_ns()
    begin = time.perf_counter_ns()
    try:
        answer = call(task)
    except Exception as error:  # whatever a library raises is a failure of that call, and counted as one
        answer = error
    spent = time.perf_counter_ns() - begin
    return spent * _NANOSECOND, (time.thread_time_ns() - busy) * _NANOSECOND, answer


@contextmanager
def _undisturbed() -> Iterator[None]:
    gc.collect()
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        if was_enabled:
            gc.enable()
