"""Recorded messages of a topic beside those of re-execution: what differs, where, when, and how much."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from rclpy.serialization import deserialize_message

from dp_tools.reexecution.canonical import canonical
from dp_tools.reexecution.detached import Caught
from dp_tools.reexecution.fields import Value, distance
from dp_tools.reexecution.known_fields import Pick, tells
from dp_tools.reexecution.recording import Recorded
from dp_tools.reexecution.stamps import stamp_of

# Where one side lacks messages, the other is looked through this far for the next that both have.
_REACH = 100


@dataclass(frozen=True)
class Spot:
    """One value that differs.

    Parameters
    ----------
    index
        Number of the message among the recorded ones of its topic, from 0.
    path
        Field, with the element of an array.
    simulated
        Stamp of the message, s.
    bag
        Time since the beginning of the bag, s.
    recorded, found
        Both values.
    size
        Distance of them; infinite if they are not two numbers.
    """

    index: int
    path: str
    simulated: float
    bag: float
    recorded: Value | None
    found: Value | None
    size: float


@dataclass
class FieldDifference:
    """All differences in one field of a topic: the first, the largest, and in how many messages."""

    path: str
    first: Spot
    largest: Spot
    count: int = 0
    last: int = -1  # number of the message that was counted last

    def add(self, spot: Spot) -> None:
        """Take one more."""
        if spot.size > self.largest.size:
            self.largest = spot
        if spot.index != self.last:
            self.count += 1
            self.last = spot.index


@dataclass
class TopicComparison:
    """One topic.

    Attributes
    ----------
    recorded, found
        Number of messages on either side.
    same
        Pairs without a difference.
    missing, extra
        Recorded messages that re-execution did not give, by number; stamps (ns) of those that it gave besides.
    fields
        Differences by field.
    after_end
        Messages that re-execution gave after the last recorded one: the recording had ended.
    """

    topic: str
    recorded: int = 0
    found: int = 0
    same: int = 0
    missing: list[int] = field(default_factory=list)
    extra: list[int] = field(default_factory=list)
    fields: dict[str, FieldDifference] = field(default_factory=dict)
    after_end: int = 0
    missing_from: Spot | None = None
    extra_from: Spot | None = None

    @property
    def agrees(self) -> bool:
        """Whether nothing differs."""
        return not (self.missing or self.extra or self.fields)

    @property
    def first(self) -> Spot | None:
        """The difference that comes first in the bag."""
        spots = [one.first for one in self.fields.values()]
        spots += [spot for spot in (self.missing_from, self.extra_from) if spot is not None]
        return min(spots, key=lambda spot: (spot.index, spot.bag), default=None)


@dataclass(frozen=True)
class Judge:
    """How two messages are compared.

    Parameters
    ----------
    start
        Log time of the first message of the bag, ns.
    tolerance
        Numbers that are no further apart are the same; in the unit of the field.
    only_told
        True for a bag that does not tell every field.
    only_first
        True to stop at the first difference.
    """

    start: int
    tolerance: float = 0.0
    only_told: bool = False
    only_first: bool = False

    def compare(
        self, topic: str, kind: Any, pick: Pick, recorded: Sequence[Recorded], found: Sequence[Caught]
    ) -> TopicComparison:
        """Compare the messages of one topic."""
        result = TopicComparison(topic, len(recorded), len(found))
        pairs, result.missing, extra = aligned(
            [stamp_of(one.data) for one in recorded], [stamp_of(one.data) for one in found]
        )
        last = pairs[-1][1] if pairs else -1
        result.after_end = sum(i > last for i in extra)
        result.extra = [i for i in extra if i < last]
        if result.missing:
            i = result.missing[0]
            result.missing_from = self._spot(i, recorded[i], "(message)", "there", "missing", math.inf)
        if result.extra:
            i = result.extra[0]
            before = max((r for r, f in pairs if f < i), default=0)
            result.extra_from = Spot(
                before,
                "(message)",
                stamp_of(found[i].data) * 1e-9,
                (found[i].time - self.start) * 1e-9,
                "missing",
                "there",
                math.inf,
            )
        for r, f in pairs:
            if self._same(result, r, recorded[r], found[f], kind, pick):
                result.same += 1
            elif self.only_first:
                break
        return result

    def _same(
        self, result: TopicComparison, index: int, recorded: Recorded, found: Caught, kind: Any, pick: Pick
    ) -> bool:
        """Compare two messages field by field and note what differs."""
        old_message = deserialize_message(recorded.data, kind)
        if canonical(old_message) == found.form:
            return True
        a = pick(old_message)
        b = pick(deserialize_message(found.data, kind))
        same = True
        for path in a if self.only_told else dict.fromkeys([*a, *b]):
            old, new = a.get(path), b.get(path)
            if self.only_told and old is not None and not tells(old):
                continue
            size = distance(old, new)
            if size > self.tolerance:
                same = False
                spot = self._spot(index, recorded, path, old, new, size)
                field_path = path.partition("[")[0]
                known = result.fields.setdefault(field_path, FieldDifference(field_path, spot, spot))
                known.add(spot)
        return same

    def _spot(
        self, index: int, recorded: Recorded, path: str, old: Value | None, new: Value | None, size: float
    ) -> Spot:
        bag = (recorded.logged - self.start) * 1e-9
        return Spot(index, path, stamp_of(recorded.data) * 1e-9, bag, old, new, size)


def aligned(recorded: Sequence[int], found: Sequence[int]) -> tuple[list[tuple[int, int]], list[int], list[int]]:
    """Pair messages of two sides by their stamps, in order.

    Returns pairs of numbers, and the numbers of those that only the first and only the second side has.
    """
    pairs: list[tuple[int, int]] = []
    missing: list[int] = []
    extra: list[int] = []
    i = j = 0
    while i < len(recorded) and j < len(found):
        if recorded[i] == found[j]:
            pairs.append((i, j))
            i, j = i + 1, j + 1
            continue
        skip, other = _next_common(recorded[i : i + _REACH], found[j : j + _REACH])
        missing += range(i, i + skip)
        extra += range(j, j + other)
        i, j = i + skip, j + other
    missing += range(i, len(recorded))
    extra += range(j, len(found))
    return pairs, missing, extra


def _next_common(a: Sequence[int], b: Sequence[int]) -> tuple[int, int]:
    """Return how many to skip on either side to the nearest stamp that both have; all if there is none."""
    place = {}
    for j in range(len(b) - 1, -1, -1):
        place[b[j]] = j
    found = [(i + place[stamp], i, place[stamp]) for i, stamp in enumerate(a) if stamp in place]
    return min(found)[1:] if found else (len(a), len(b))
