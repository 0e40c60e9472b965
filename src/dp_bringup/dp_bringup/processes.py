"""Child processes of one run: start them, notice which one dies and why, stop them all cleanly."""

from __future__ import annotations

import collections
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO

from dp_node.run import PARENT_VARIABLE
from marine_model.errors import DpError

_TAIL_LINES = 8


class ChildDiedError(DpError):
    """A process of the graph ended by itself; the message names it, its exit code and its last words."""


class Child:
    """One process, its output kept in a log file and its last lines at hand.

    Parameters
    ----------
    name
        For messages.
    command
        What to run.
    log_file
        For its output.
    heard
        Called with every line of its output, in a thread of its own.
    again
        True to go on in a log that is there.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str | Path],
        log_file: Path,
        heard: Callable[[str], None] = lambda line: None,
        again: bool = False,
    ) -> None:
        self.name = name
        self._heard = heard
        self._tail: collections.deque[str] = collections.deque(maxlen=_TAIL_LINES)
        self._process = subprocess.Popen(
            [str(part) for part in command],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            text=True,
            errors="replace",
            # Ctrl-C in the terminal reaches the parent alone, which stops the children in order.
            start_new_session=True,
            # Unbuffered: last words count most when there is no time left to flush them.
            env=os.environ | {PARENT_VARIABLE: str(os.getpid()), "PYTHONUNBUFFERED": "1"},
        )
        self.log_file = log_file
        self._log = log_file.open("a" if again else "w", encoding="utf-8")
        stream = self._process.stdout
        if stream is None:
            raise ChildDiedError(f"{name}: no output pipe")
        self._reader = threading.Thread(target=self._read, args=(stream,), daemon=True)
        self._reader.start()

    def _read(self, stream: IO[str]) -> None:
        logged = True
        for line in stream:
            self._tail.append(line.rstrip())
            self._heard(line.rstrip())
            if logged:
                try:
                    self._log.write(line)
                    self._log.flush()
                except OSError as error:
                    # On a full disk: the process must not wait for somebody to read on.
                    logged = False
                    self._tail.append(f"(no more is kept: {error.strerror or error})")

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """Exit code, None while running."""
        return self._process.poll()

    def last_words(self) -> str:
        """Return where all output is, and its last lines."""
        self._reader.join(timeout=1.0)
        if not self._tail:
            return "without a word"
        return "\n".join([f"its last words ({self.log_file}):", *(f"    {line}" for line in self._tail)])

    def request_stop(self, number: int = signal.SIGINT) -> None:
        """Ask the process to end."""
        if self.exit_code is None:
            self._process.send_signal(number)

    def wait(self, deadline: float) -> bool:
        """Wait until the process has ended or ``deadline`` (monotonic, s); return True if it has ended."""
        try:
            self._process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            return False
        return True

    def close(self) -> None:
        """Close the log; the process must have ended."""
        self._reader.join(timeout=1.0)
        with suppress(OSError):  # what a full disk did not take has been said already
            self._log.close()


class Children:
    """The processes of one run, started in order and stopped in groups.

    Parameters
    ----------
    log_folder
        One log file a process is written here.
    patience
        A process has this long to end after SIGINT, s; then again after SIGTERM, before it is killed. A node may wait
        4 s of it for readers of its last messages.
    """

    def __init__(self, log_folder: Path, patience: float = 8.0) -> None:
        self._folder = log_folder
        self._patience = patience
        self._children: list[Child] = []
        log_folder.mkdir(parents=True, exist_ok=True)

    def start(
        self,
        name: str,
        command: Sequence[str | Path],
        heard: Callable[[str], None] = lambda line: None,
        again: bool = False,
    ) -> Child:
        """Start a process.

        Parameters
        ----------
        name, command
            See :class:`Child`.
        heard
            Called with every line of its output, in a thread.
        again
            True to go on in the log of one of the same name.
        """
        child = Child(name, command, self._folder / f"{name}.log", heard, again)
        self._children.append(child)
        return child

    @property
    def all(self) -> tuple[Child, ...]:
        """Processes not yet stopped, in the order of their start."""
        return tuple(self._children)

    @property
    def running(self) -> tuple[Child, ...]:
        """Processes that have not ended."""
        return tuple(child for child in self._children if child.exit_code is None)

    def check(self, leave_out: Collection[Child] = ()) -> None:
        """Raise ChildDiedError if a process has ended by itself; somebody else looks after those left out."""
        for child in self._children:
            if child in leave_out:
                continue
            code = child.exit_code
            if code is not None:
                raise ChildDiedError(f"{child.name} ended by itself ({explain_exit(code)}), {child.last_words()}")

    def stop(self, children: Sequence[Child] | None = None) -> list[str]:
        """Stop ``children`` (default: all): SIGINT, then SIGTERM, then SIGKILL; return what went wrong."""
        wanted = list(self._children if children is None else children)
        already_dead = [child for child in wanted if child.exit_code is not None]
        problems = []
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            remaining = [child for child in wanted if child.exit_code is None]
            if number == signal.SIGKILL:
                problems += [f"{child.name} did not stop and was killed" for child in remaining]
            for child in remaining:
                child.request_stop(number)
            deadline = time.monotonic() + self._patience
            for child in remaining:
                child.wait(deadline)
        for child in wanted:
            if child not in already_dead and child.exit_code not in (0, -signal.SIGKILL):
                problems.append(f"{child.name} stopped with {explain_exit(child.exit_code or 0)}, {child.last_words()}")
            child.close()
            self._children.remove(child)
        return problems


def explain_exit(code: int) -> str:
    """Return an exit code in words."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return f"killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"killed by signal {-code}"
