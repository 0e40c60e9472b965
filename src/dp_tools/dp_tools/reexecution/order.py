"""The order in which a node took what came to it, worked out of publish times.

A bag does not say when a node took a message. But a node does one thing at a time, and publishes what it makes of a
message before it takes the next: the publish time of an answer says when the message that it answers had been worked
on. So there are

- *acts*: messages with a recorded answer, changes of parameters, whose event the node itself publishes, and what it did
  by itself. Their order is that of the answers, and certain;
- *loose* messages, which the node only kept, or refused. One comes before an act if it was published before the node
  can have begun with that act: before the message that set it off was published, or before the act before was over.

That is what the node does while it has time. Where its process stood still, a loose message may have waited with what
came later, and be taken after it: ``range`` says between which acts. Nodes in lockstep answer the same either way.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

T = TypeVar("T")

# A process that is not given a processor takes what is waiting no later than that.
PATIENCE = 1_000_000_000  # ns


@dataclass(frozen=True, slots=True)
class Act(Generic[T]):
    """Something with an answer.

    Parameters
    ----------
    item
        What is fed.
    published
        When it was published, ns.
    answered, finished
        Publish times of the first and the last message of the answer, ns.
    """

    item: T
    published: int
    answered: int
    finished: int


@dataclass(frozen=True, slots=True)
class Loose(Generic[T]):
    """A message without an answer of its own."""

    item: T
    published: int  # ns


@dataclass
class Order(Generic[T]):
    """Acts and loose messages merged.

    Attributes
    ----------
    acts, loose
        Each in its own order.
    begun
        For every act the earliest time (ns) at which it can have begun.
    place
        For every loose message the number of acts before it.
    range
        The least and the largest that this number can be.
    """

    acts: list[Act[T]]
    loose: list[Loose[T]]
    begun: list[int]
    place: list[int]
    range: list[tuple[int, int]]
    _at: dict[int, list[int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for i, number in enumerate(self.place):
            self._at.setdefault(number, []).append(i)

    def __len__(self) -> int:
        """Return how many items there are."""
        return len(self.acts) + len(self.loose)

    def between(self, number: int) -> list[int]:
        """Return the loose messages that come after ``number`` acts, before the next."""
        return self._at.get(number, [])

    def unsure(self, act: int) -> list[int]:
        """Return the loose messages that may come on either side of an act, and not before the one before it."""
        # Later ones were sent after it, but for one that was sent while it was under way.
        after = (*self._at.get(act, ()), *self._at.get(act + 1, ()))
        return sorted(i for i in after if self.range[i][0] <= act < self.range[i][1])

    def move(self, loose: int, number: int) -> None:
        """Put a loose message after ``number`` acts."""
        self._at[self.place[loose]].remove(loose)
        self.place[loose] = number
        there = self._at.setdefault(number, [])
        there.append(loose)
        there.sort()


def merge(acts: Sequence[Act[T]], loose: Sequence[Loose[T]]) -> Order[T]:
    """Return acts and loose messages in the order in which the node took them, as far as publish times tell."""
    ordered = sorted(acts, key=lambda act: act.answered)
    kept = sorted(loose, key=lambda one: one.published)
    begun: list[int] = []
    finished = 0
    for act in ordered:
        begun.append(max(act.published, finished))
        finished = max(finished, act.finished)
    answered = [act.answered for act in ordered]
    place = [bisect_left(begun, one.published) for one in kept]
    limits = []
    for one, number in zip(kept, place, strict=True):
        # An act that was answered before it was sent came before it.
        free = max(one.published, ordered[number - 1].finished if number else 0)
        limits.append((bisect_left(answered, one.published), bisect_left(begun, free + PATIENCE)))
    return Order(ordered, kept, begun, place, limits)
