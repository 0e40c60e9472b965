"""Which topics of a bag are replayed, and under which names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from rclpy.exceptions import InvalidTopicNameException
from rclpy.validate_full_topic_name import validate_full_topic_name

from dp_tools.bags.errors import BagError

# Every node publishes there, whatever its namespace: a namespace for the replay leaves them where they are.
_SHARED = frozenset(("/diagnostics", "/rosout", "/parameter_events"))


@dataclass(frozen=True)
class Selection:
    """What to replay under which name.

    Parameters
    ----------
    topics
        Names to replay, with ``*`` and ``?`` as in file names; a leading slash may be left out. Empty for all.
    exclude
        Names to leave out, likewise.
    remap
        New name by recorded name.
    namespace
        Put before all names but those that all graphs share.
    """

    topics: Sequence[str] = ()
    exclude: Sequence[str] = ()
    remap: Sequence[tuple[str, str]] = ()
    namespace: str = ""

    def names(self, recorded: Iterable[str]) -> dict[str, str]:
        """Return the name to publish on by recorded name.

        Raises
        ------
        BagError
            If a word matches no topic, a new name is no topic name, two topics get one name, or none is left.
        """
        there = list(dict.fromkeys(recorded))
        wanted = _matching(there, self.topics, "--topics") if self.topics else set(there)
        left_out = _matching(there, self.exclude, "--exclude")
        new = {_full(old): _full(new) for old, new in self.remap}
        for old in new:
            if old not in there:
                raise BagError(f"--remap: expected a topic of the bag, found {old}; it holds {', '.join(there)}")
        names = {}
        for name in there:
            if name in wanted and name not in left_out:
                names[name] = self._below(new.get(name, name))
        if not names:
            raise BagError("expected at least one topic to replay, found none")
        for old, name in names.items():
            try:
                validate_full_topic_name(name)
            except InvalidTopicNameException as error:
                raise BagError(f"{old}: expected the name of a topic, found '{name}'") from error
            twin = next((other for other in names if other != old and names[other] == name), None)
            if twin is not None:
                raise BagError(f"expected different names, found {name} for both {old} and {twin}")
        return names

    def _below(self, name: str) -> str:
        space = self.namespace.strip("/")
        return name if not space or name in _SHARED else f"/{space}{name}"


def parse_remap(text: str) -> tuple[str, str]:
    """Return old and new name out of ``old:=new``. Raises BagError."""
    old, sign, new = text.partition(":=")
    if not (old and sign and new):
        raise BagError(f"--remap: expected old:=new, found '{text}'")
    return old, new


def _full(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"


def _matching(there: Sequence[str], patterns: Iterable[str], option: str) -> set[str]:
    found: set[str] = set()
    for pattern in patterns:
        matched = {name for name in there if fnmatchcase(name, _full(pattern))}
        if not matched:
            raise BagError(f"{option}: expected a topic of the bag, found {pattern}; it holds {', '.join(there)}")
        found |= matched
    return found
