"""Which topics are recorded."""

from __future__ import annotations

import re
from collections.abc import Sequence

from dp_tools.recorder.errors import RecordingRefusedError

# Every change of a parameter of any node, told by the node itself: part of every bag.
PARAMETER_EVENTS = "/parameter_events"
# Absolute names: every node publishes there, whatever its namespace.
_SHARED = frozenset(("/diagnostics", "/rosout", PARAMETER_EVENTS))


class Selection:
    """Says of a topic whether it is wanted, as ``ros2 bag record`` would.

    Parameters
    ----------
    topics
        Names; those without a leading slash are below the namespace.
    regex
        A topic is wanted as well if this is found in its name. Empty for none.
    exclude
        A topic is never wanted if this is found in its name. Empty for none.
    namespace
        Without ``topics`` and ``regex``: all topics below it, and those that all graphs share; not hidden ones.

    Raises
    ------
    RecordingRefusedError
        If a regular expression is none.
    """

    def __init__(self, topics: Sequence[str] = (), regex: str = "", exclude: str = "", namespace: str = "/") -> None:
        self._below = namespace.rstrip("/") + "/"
        self._topics = frozenset(self.full_name(topic) for topic in topics)
        self._regex = _compiled("regex", regex)
        self._exclude = _compiled("exclude", exclude)

    def full_name(self, name: str) -> str:
        """Return a name with the namespace if it has no leading slash."""
        return name if name.startswith("/") else self._below + name

    def wants(self, topic: str) -> bool:
        """Return whether a topic, by its full name, is to be recorded."""
        if topic == PARAMETER_EVENTS:
            return True
        if self._exclude is not None and self._exclude.search(topic):
            return False
        if self._topics or self._regex is not None:
            return topic in self._topics or (self._regex is not None and self._regex.search(topic) is not None)
        if not self.is_below(topic) and topic not in _SHARED:
            return False
        return not is_hidden(topic)

    def is_below(self, name: str) -> bool:
        """Return whether a topic or node, by its full name, is in the namespace."""
        return name.startswith(self._below)


def is_hidden(name: str) -> bool:
    """Return whether a part of a name begins with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))


def _compiled(what: str, pattern: str) -> re.Pattern[str] | None:
    try:
        return re.compile(pattern) if pattern else None
    except re.error as error:
        raise RecordingRefusedError(f"{what}: expected a regular expression, found '{pattern}': {error}") from error
