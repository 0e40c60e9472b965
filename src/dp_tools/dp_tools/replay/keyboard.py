"""Single keys from a terminal, while this context lasts."""

from __future__ import annotations

import os
import select
import termios
import tty
from types import TracebackType
from typing import Any, Self

# What a terminal sends for keys that are no character.
_SEQUENCES = {
    b"\x1b[A": "up",
    b"\x1b[B": "down",
    b"\x1b[C": "right",
    b"\x1bOA": "up",
    b"\x1bOB": "down",
    b"\x1bOC": "right",
}


class Keyboard:
    """Reads keys as they are pressed; the terminal is as it was afterwards, however the context ends.

    Parameters
    ----------
    file
        Descriptor of the terminal. If it is none, no key is ever pressed.
    """

    def __init__(self, file: int = 0) -> None:
        self._file = file
        self._before: list[Any] | None = None

    @property
    def there(self) -> bool:
        """Whether keys can be pressed."""
        return self._before is not None

    def __enter__(self) -> Self:
        if os.isatty(self._file) and not _in_background(self._file):
            self._before = termios.tcgetattr(self._file)
            tty.setcbreak(self._file)  # Ctrl-C stays what it is
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._before is not None:
            termios.tcsetattr(self._file, termios.TCSADRAIN, self._before)
            self._before = None

    def pressed(self) -> list[str]:
        """Return the keys pressed since the last call: characters, or ``up``, ``down``, ``right``."""
        if not self.there or not select.select([self._file], [], [], 0.0)[0]:
            return []
        return keys_in(os.read(self._file, 1024))


def _in_background(file: int) -> bool:
    """Return whether this process would be stopped for changing the terminal."""
    try:
        return os.tcgetpgrp(file) != os.getpgrp()
    except OSError:  # a terminal that controls no process
        return False


def keys_in(data: bytes) -> list[str]:
    """Return the keys in what a terminal sent; sequences that are not known are left out."""
    keys = []
    while data:
        sequence = next((known for known in _SEQUENCES if data.startswith(known)), None)
        if sequence is not None:
            keys.append(_SEQUENCES[sequence])
            data = data[len(sequence) :]
        elif data[0] == 0x1B:  # another sequence: up to its final letter
            end = next(
                (i for i in range(1, len(data)) if chr(data[i]).isalpha() and data[i] != ord("O")), len(data) - 1
            )
            data = data[end + 1 :]
        else:
            keys.append(chr(data[0]))
            data = data[1:]
    return keys
