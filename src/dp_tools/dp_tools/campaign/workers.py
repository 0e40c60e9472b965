"""Processes that sail one run after another, so that each pays for its start once."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from dp_bringup.interrupts import Interrupts
from dp_tools.campaign.order import Order, Outcome
from marine_model.errors import DpError

_STOP_SECONDS = 5.0
_TELL_SECONDS = 0.1
# Libraries that start threads of their own: the processes are as many as there are cores.
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class RunFailedError(DpError):
    """A run did not come to its end; the message says why."""


@dataclass
class _Worker:
    process: SpawnProcess
    line: Connection
    order: int | None = None


def fill_all(
    orders: Sequence[Order],
    jobs: int,
    progress: Callable[[int, float], None],
    done: Callable[[int, Outcome | RunFailedError], None],
) -> None:
    """Fill all orders, in their order, with ``jobs`` processes at once.

    Parameters
    ----------
    orders
        What to do.
    jobs
        Number of processes.
    progress
        Told which order has come to which simulated time (s).
    done
        Told which order is filled, or why it could not be. The others go on.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C; every process is stopped first.
    """
    workers: list[_Worker] = []
    waiting = list(range(len(orders)))[::-1]
    with Interrupts() as interrupts:
        try:
            with interrupts.held_back():
                workers.extend(_start() for _ in range(min(jobs, len(orders))))
            _supervise(workers, orders, waiting, progress, done)
        finally:
            # However often somebody asks for it: nothing is left running.
            with interrupts.ignored():
                _stop(workers)


def _supervise(
    workers: list[_Worker],
    orders: Sequence[Order],
    waiting: list[int],
    progress: Callable[[int, float], None],
    done: Callable[[int, Outcome | RunFailedError], None],
) -> None:
    for worker in workers:
        _hand_out(worker, orders, waiting)
    while busy := {worker.line: (worker, worker.order) for worker in workers if worker.order is not None}:
        for line in connection.wait(list(busy)):
            worker, number = busy[line]  # type: ignore[index]
            try:
                kind, value = worker.line.recv()
            except (EOFError, ConnectionError):
                worker.process.join(_STOP_SECONDS)
                code = worker.process.exitcode
                done(number, RunFailedError(f"the process that sailed it ended by itself, exit code {code}"))
                workers.remove(worker)
                worker.line.close()
                if waiting:
                    workers.append(_start())
                    _hand_out(workers[-1], orders, waiting)
                continue
            if kind == "at":
                progress(number, value)
            else:
                done(number, value if kind == "done" else RunFailedError(value))
                _hand_out(worker, orders, waiting)


def _hand_out(worker: _Worker, orders: Sequence[Order], waiting: list[int]) -> None:
    """Give a worker its next order, if there is one; it knows that None is the end."""
    worker.order = waiting.pop() if waiting else None
    with suppress(ConnectionError):  # it has died: found out when its answer is read
        worker.line.send(None if worker.order is None else orders[worker.order])


def _start() -> _Worker:
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_work, args=(theirs,), daemon=True)
    with _one_thread():
        process.start()
    theirs.close()
    return _Worker(process, ours)


def _stop(workers: Sequence[_Worker]) -> None:
    """End all processes: idle ones end by themselves, the others are in the middle of what nobody wants any more."""
    for worker in workers:
        if worker.order is not None:
            worker.process.terminate()
    for worker in workers:
        worker.line.close()
        worker.process.join(_STOP_SECONDS)
        if worker.process.is_alive():
            worker.process.kill()
            worker.process.join()


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes that are started inside use one thread each."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _work(line: Any) -> None:
    """Fill orders until there are no more."""
    # Ctrl-C goes to the whole group of processes; who started this one stops it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    from dp_tools.campaign.sail import fill

    with suppress(EOFError, ConnectionError):
        while (order := line.recv()) is not None:
            line.send(_answer(fill, order, line))


def _answer(fill: Callable[[Order, Callable[[float], None]], Outcome], order: Order, line: Any) -> tuple[str, Any]:
    told = 0.0

    def tell(simulated: float) -> None:
        nonlocal told
        now = time.monotonic()
        if now - told >= _TELL_SECONDS:
            told = now
            line.send(("at", simulated))

    try:
        return "done", fill(order, tell)
    except (DpError, OSError) as error:
        return "failed", str(error)
    except Exception as error:  # whatever it is: the other runs go on
        return "failed", f"{type(error).__name__}: {error}"
