"""Keys pressed in a terminal, one at a time and without Enter."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def pressed_keys() -> Iterator[Callable[[], str]]:
    """Give a function that returns the keys pressed since the last call; always none if input is not a terminal."""
    if not sys.stdin.isatty():
        yield lambda: ""
        return
    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    try:
        tty.setcbreak(descriptor)

        def keys() -> str:
            found = b""
            while select.select([descriptor], [], [], 0.0)[0]:
                read = os.read(descriptor, 64)
                if not read:
                    break  # the terminal is gone
                found += read
            return found.decode(errors="ignore")

        yield keys
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
