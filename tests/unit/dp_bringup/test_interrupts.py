"""Interrupts end a run, but never in the middle of what must be whole."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from dp_bringup.interrupts import Interrupts

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def send(number: signal.Signals) -> None:
    os.kill(os.getpid(), number)
    signal.sigpending()  # a system call: Python's handler has run when it returns


@pytest.mark.parametrize("number", NUMBERS)
def test_every_way_to_end_is_a_keyboard_interrupt(number: signal.Signals) -> None:
    before = [signal.getsignal(one) for one in NUMBERS]
    with pytest.raises(KeyboardInterrupt), Interrupts():
        send(number)
    assert [signal.getsignal(one) for one in NUMBERS] == before


def test_an_interrupt_is_held_back_and_raised_afterwards() -> None:
    done = []
    with Interrupts() as interrupts:
        with pytest.raises(KeyboardInterrupt), interrupts.held_back():  # noqa: PT012
            send(signal.SIGINT)
            send(signal.SIGTERM)
            done.append("whole")
        with interrupts.held_back():
            done.append("nothing is raised twice")
    assert done == ["whole", "nothing is raised twice"]


def test_an_error_inside_comes_before_the_interrupt() -> None:
    with Interrupts() as interrupts, pytest.raises(ValueError, match="why"), interrupts.held_back():  # noqa: PT012
        send(signal.SIGINT)
        raise ValueError("why")


def test_an_interrupt_is_ignored() -> None:
    done = []
    with Interrupts() as interrupts:
        with interrupts.ignored():
            send(signal.SIGINT)
            with interrupts.held_back():
                send(signal.SIGHUP)
            done.append("whole")
        done.append("and goes on")
    assert done == ["whole", "and goes on"]


def test_other_threads_are_left_alone() -> None:
    before = signal.getsignal(signal.SIGINT)
    seen = []

    def use() -> None:
        with Interrupts():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert seen == [before]
