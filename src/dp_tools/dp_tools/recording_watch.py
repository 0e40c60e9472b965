"""An eye on the recorder of a run: the graph sails on without it, but not without a word."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from dp_bringup.processes import Child, explain_exit
from dp_tools.recorder import STOPPED_WORDS


class RecordingWatch:
    """Says at once that a recording has come to its end before the run has.

    Parameters
    ----------
    bag
        Where it goes.
    warn
        Called with what there is to say, once.
    """

    def __init__(self, bag: Path, warn: Callable[[str], None]) -> None:
        self._bag = bag
        self._warn = warn
        self._last_line = ""
        self.recorder: Child | None = None
        self.over = False
        """Whether nothing is recorded any more."""

    def hear(self, line: str) -> None:
        """Take a line of the recorder's output, in any thread."""
        if STOPPED_WORDS in line:
            self._last_line = line

    def look(self) -> None:
        """Warn if the recording is over."""
        if self.over or self.recorder is None:
            return
        dead = self.problems()
        if dead or self._last_line:
            self.over = True
            self._warn("\n".join([*(dead or [self._last_line]), "the graph sails on without a recording"]))

    def problems(self) -> list[str]:
        """Return what is wrong with a recorder that has died; ask before it is told to stop."""
        code = None if self.recorder is None else self.recorder.exit_code
        if self.recorder is None or code is None:
            return []
        return [
            f"recorder ended by itself ({explain_exit(code)}), {self.recorder.last_words()}\n"
            f"what it had written is in {self._bag}; dp bag check --repair makes a whole bag of it"
        ]
