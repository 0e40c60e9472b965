"""One publisher for one input: who came first keeps it, and who comes to it is refused; without ROS.

A reader is not told who sent a message, but the middleware numbers the messages of each publisher, one after the
other, and over a reliable connection none is missing. The message with the number after the last one is from the
publisher that has the input, any other number is from somebody else, or there is only one publisher and it is new.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

# Numbers from here on are what a middleware gives that does not number messages.
_UNNUMBERED = 2**63
_NOBODY = -1
# Publishers beside the established one whose numbers are followed.
_RIVALS = 16
# Where the numbers of two publishers crossed, they are told apart once they are so far apart again.
_APART = 3
# Weight of the newest interval in the mean.
_NEWEST = 0.1


@dataclass(frozen=True)
class Peer:
    """A publisher of the input: identity of its endpoint, and full name of its node."""

    identity: tuple[int, ...]
    node: str


class ExclusiveInput:
    """Tells the messages of the established publisher of one topic from those of others.

    The first publisher that is heard is established. As long as it lives, messages of others do not pass. It has left
    if it is gone from the graph; or if it has been silent for ``patience`` and nobody but nodes of its own name
    publishes: a node that was killed stays in the graph until its lease ends, and the one started in its place need not
    wait for that. Who is alone always passes.

    Where numbers of two publishers cross, nothing passes until they are apart again; the one that is nearer to where
    the established one must have come by its mean interval is taken for it. Two that start together at the same rate
    stay undistinguished, and nothing passes until one of them is gone.

    Parameters
    ----------
    count
        Returns the number of publishers that are connected.
    peers
        Returns the publishers in the graph.
    patience
        Silence, ns.
    """

    def __init__(self, count: Callable[[], int], peers: Callable[[], list[Peer]], patience: int) -> None:
        self._count = count
        self._peers = peers
        self._patience = patience
        self._next: int | None = None  # number that the established one gives its next message
        self._heard = 0  # ns, when it was heard last
        self._interval = 0.0  # ns, its mean interval
        self._peer: Peer | None = None  # if it was alone once, or is by now
        self._among: list[Peer] = []  # those of whom it is one
        self._rivals: set[int] = set()  # numbers that others give their next message
        self._crossing: list[int] = []  # the next numbers of the two that cannot be told apart
        self._crossed_at = 0
        self._looked = 0
        self.refused = 0  # messages that did not pass

    def passes(self, number: int, now: int) -> bool:
        """Return whether message ``number`` of some publisher, received at ``now`` (ns), is the established one's."""
        if number == self._next and not self._rivals:
            self._go_on(number, now)
            return True
        if number >= _UNNUMBERED:
            return True
        if self._next is None or self._count() <= 1:
            self._establish(number, now)
            return True
        if self._crossing:
            passed = False
            self._follow_crossing(number, now)
        elif number == self._next and number not in self._rivals:
            passed = True
            self._go_on(number, now)
        elif number == self._next and now - self._heard <= self._patience:
            passed = False
            self._rivals.discard(number)
            self._crossing, self._crossed_at, self._next = [number + 1, number], number, _NOBODY
        else:
            passed = self._has_left(now)
            if passed:
                self._establish(number, now)
            else:
                self._follow_rival(number)
        self.refused += not passed
        return passed

    @property
    def undistinguished(self) -> bool:
        """Whether the established publisher cannot be told from another at present."""
        return bool(self._crossing)

    def intruders(self) -> list[str]:
        """Return the nodes that publish beside the established one, by name; nodes of its own name do not count."""
        peers = self._peers()
        if self._peer is None and len(peers) == 1 and self._next is not None:
            self._peer, self._among = peers[0], peers
        own = self._peer
        return sorted({peer.node for peer in peers if own is None or peer.node != own.node}) if len(peers) > 1 else []

    @property
    def established(self) -> str:
        """Name of the node of the established publisher; empty if it is not known."""
        return "" if self._peer is None else self._peer.node

    def _go_on(self, number: int, now: int) -> None:
        self._next = number + 1
        interval = now - self._heard
        self._interval += (_NEWEST if self._interval else 1.0) * (interval - self._interval)
        self._heard = now

    def _establish(self, number: int, now: int) -> None:
        self._among = self._peers()
        self._peer = self._among[0] if len(self._among) == 1 else None
        self._next, self._heard, self._interval = number + 1, now, 0.0
        self._rivals.clear()
        self._crossing.clear()

    def _has_left(self, now: int) -> bool:
        """Return whether the established publisher is gone, or silent with none but its like beside it."""
        if now - self._heard <= self._patience or now - self._looked <= self._patience // 10:
            return False
        self._looked = now
        peers = self._peers()
        one_name = len({peer.node for peer in (*self._among, *peers)}) <= 1
        return one_name or any(peer not in peers for peer in self._among)

    def _follow_rival(self, number: int) -> None:
        self._rivals.discard(number)
        if len(self._rivals) >= _RIVALS:
            self._rivals.discard(min(self._rivals))
        self._rivals.add(number + 1)

    def _follow_crossing(self, number: int, now: int) -> None:
        heads = self._crossing
        if number not in heads:
            self._follow_rival(number)
            return
        heads[heads.index(number)] += 1
        if abs(heads[0] - heads[1]) < _APART:
            return
        due = self._crossed_at + (now - self._heard) / max(self._interval, 1.0)
        near, far = sorted(heads, key=lambda head: abs(head - due))
        self._next, self._heard = near, now
        self._crossing = []
        self._rivals.add(far)
