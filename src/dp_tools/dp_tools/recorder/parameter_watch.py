"""Asks every node for its parameters as it appears, without ever waiting for an answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.node import Node

from dp_tools.recorder.parameter_snapshots import Snapshot, values_of
from dp_tools.recorder.selection import PARAMETER_EVENTS, is_hidden

# A service drops its answer if it has not heard of this client's reader yet: a request goes out again after so long, s.
_ASK_AGAIN = 1.0
# A node is warned about after so long, s, and then asked only now and then: it may be stopped and go on later.
_PATIENCE = 10.0
_ASK_SILENT_AGAIN = 5.0
# A node is known by name before its publisher of parameter events is; after so long, s, it has none.
_NO_EVENTS = 3.0

# Node by its full name, and which of its lives: the identity of its publisher of parameter events.
Instance = tuple[str, bytes]


class _Question:
    """One request to one service, sent again until it is answered."""

    def __init__(self, node: Node, kind: Any, service: str) -> None:
        self._node = node
        self._kind = kind
        self._client = node.create_client(kind, service)
        self._sent: dict[int, int] = {}

    def ready(self) -> bool:
        """Return whether there is somebody to ask."""
        return bool(self._client.service_is_ready())

    def ask(self, request: Any, wall_clock: int) -> None:
        """Send the request; ``wall_clock`` in ns."""
        with self._client.handle:
            self._sent[self._client.handle.send_request(request)] = wall_clock

    def answer(self) -> tuple[Any, int] | None:
        """Return an answer, if there is one, and when the request for it was sent, ns."""
        with self._client.handle:
            header, response = self._client.handle.take_response(self._kind.Response)
        if response is None:
            return None
        asked = self._sent.get(header.request_id.sequence_number)
        return None if asked is None else (response, asked)

    def close(self) -> None:
        self._node.destroy_client(self._client)


@dataclass
class _Inquiry:
    """What one node is being asked: first the names, then the values, group by group."""

    node: str
    since: float
    listing: _Question
    getting: _Question
    groups: list[list[str]] | None = None  # of names whose values are still to be asked; None before they are known
    snapshot: Snapshot | None = None
    next_ask: float = 0.0
    warned: bool = False

    @property
    def question(self) -> _Question:
        return self.listing if self.groups is None else self.getting

    def request(self) -> Any:
        return ListParameters.Request() if self.groups is None else GetParameters.Request(names=self.groups[0])

    def take(self, response: Any, asked: int) -> Snapshot | None:
        """Take an answer to the present question; return the snapshot once it is whole."""
        if self.groups is None:
            names = sorted(set(response.result.names))
            self.snapshot = Snapshot(self.node, asked)
            self.groups = [names] if names else []
        else:
            self._take_values(self.groups.pop(0), response.values)
        return None if self.groups else self.snapshot

    def _take_values(self, names: list[str], values: Sequence[Any]) -> None:
        if self.snapshot is None or self.groups is None:
            return
        if len(values) == len(names):
            self.snapshot.values.update(values_of(names, values))
        elif len(names) > 1:
            # rclpy answers nothing at all if one of them has no value: it is found by halves, and left out.
            half = len(names) // 2
            self.groups[:0] = [names[:half], names[half:]]

    def close(self) -> None:
        self.listing.close()
        self.getting.close()


class ParameterWatch:
    """Takes a snapshot of the parameters of every node, and another when a node of that name appears anew.

    Parameters
    ----------
    node
        Asks. No executor may spin it.
    wanted
        Says of a node, by its full name, whether its parameters are wanted.
    keep
        Called with every snapshot.
    warn
        Called with a line about a node that does not answer.
    """

    def __init__(
        self,
        node: Node,
        wanted: Callable[[str], bool],
        keep: Callable[[Snapshot], None],
        warn: Callable[[str], None],
    ) -> None:
        self._node = node
        self._wanted = wanted
        self._keep = keep
        self._warn = warn
        self._known: set[Instance] = set()
        self._first_seen: dict[str, float] = {}  # of nodes without parameter events
        self._inquiries: dict[str, _Inquiry] = {}

    @property
    def silent(self) -> list[str]:
        """Nodes that have been asked for long without an answer."""
        return sorted(name for name, inquiry in self._inquiries.items() if inquiry.warned)

    @property
    def unanswered(self) -> list[str]:
        """Nodes that have not answered yet."""
        return sorted(self._inquiries)

    def look(self, now: float) -> None:
        """Ask nodes that are new in the graph; ``now`` in s."""
        present = self._present(now)
        for instance in present - self._known:
            self._inquire(instance[0], now)
        self._known = present
        names = {name for name, _ in present}
        for name in [name for name in self._inquiries if name not in names]:
            self._inquiries.pop(name).close()  # it came and went

    def serve(self, now: float, wall_clock: int) -> None:
        """Send what is to be sent, and take what has arrived; ``now`` in s, ``wall_clock`` in ns."""
        for inquiry in list(self._inquiries.values()):
            self._serve(inquiry, now, wall_clock)

    def close(self) -> None:
        """Give the service clients back."""
        for inquiry in self._inquiries.values():
            inquiry.close()
        self._inquiries.clear()

    def _present(self, now: float) -> set[Instance]:
        """Return the nodes of the graph. A killed node stays known for a while; its next life has another identity."""
        events = self._node.get_publishers_info_by_topic(PARAMETER_EVENTS)
        lives = {(_full_name(info.node_name, info.node_namespace), bytes(info.endpoint_gid)) for info in events}
        speaking = {name for name, _ in lives}
        others = {_full_name(*pair) for pair in self._node.get_node_names_and_namespaces()} - speaking
        self._first_seen = {name: self._first_seen.get(name, now) for name in others}
        lives |= {(name, b"") for name, since in self._first_seen.items() if now - since > _NO_EVENTS}
        return {one for one in lives if not is_hidden(one[0]) and self._wanted(one[0])}

    def _inquire(self, name: str, now: float) -> None:
        previous = self._inquiries.pop(name, None)
        if previous is not None:
            previous.close()
        make = self._node
        self._inquiries[name] = _Inquiry(
            name,
            now,
            _Question(make, ListParameters, f"{name}/list_parameters"),
            _Question(make, GetParameters, f"{name}/get_parameters"),
        )

    def _serve(self, inquiry: _Inquiry, now: float, wall_clock: int) -> None:
        answer = inquiry.question.answer()
        if answer is not None:
            snapshot = inquiry.take(*answer)
            if snapshot is not None:
                self._finish(inquiry, snapshot)
                return
            inquiry.next_ask = now
        if now - inquiry.since > _PATIENCE and not inquiry.warned:
            inquiry.warned = True
            self._warn(f"node {inquiry.node} has not told its parameters for {_PATIENCE:g} s; they are not in the bag")
        if now >= inquiry.next_ask and inquiry.question.ready():
            inquiry.question.ask(inquiry.request(), wall_clock)
            inquiry.next_ask = now + (_ASK_SILENT_AGAIN if inquiry.warned else _ASK_AGAIN)

    def _finish(self, inquiry: _Inquiry, snapshot: Snapshot) -> None:
        del self._inquiries[inquiry.node]
        inquiry.close()
        self._keep(snapshot)


def _full_name(name: str, namespace: str) -> str:
    return f"{namespace.rstrip('/')}/{name}"
