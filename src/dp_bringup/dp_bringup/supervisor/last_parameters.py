"""What the parameters of every node were last, so that a restart keeps live changes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

# The supervisor decides about these itself.
_NOT_KEPT = frozenset({"autostart", "start_type_description_service"})


class LastParameters:
    """Values by node and name: those of the start, a snapshot of the node itself, and every change since.

    A snapshot takes time; changes that come meanwhile may or may not be in it, and stand above it.

    Parameters
    ----------
    start
        Values that the nodes are started with.
    """

    def __init__(self, start: Mapping[str, Mapping[str, Any]]) -> None:
        self._values = {node: dict(own) for node, own in start.items()}
        self._meanwhile: dict[str, dict[str, Any]] = {}

    def expect_snapshot(self, node: str) -> None:
        """Take note that a snapshot of ``node`` is asked for."""
        self._meanwhile[node] = {}

    def snapshot(self, node: str, values: Mapping[str, Any]) -> None:
        """Take all parameters that a node has."""
        self._values.setdefault(node, {}).update(values)
        self._values[node].update(self._meanwhile.pop(node, {}))

    def changed(self, node: str, values: Mapping[str, Any]) -> None:
        """Take changes that a node has told of."""
        self._values.setdefault(node, {}).update(values)
        if node in self._meanwhile:
            self._meanwhile[node].update(values)

    def of(self, node: str) -> dict[str, Any]:
        """Return what ``node`` is to be started with; no value, and an empty list, have no form in a file."""
        return {
            name: value
            for name, value in self._values.get(node, {}).items()
            if name not in _NOT_KEPT and value is not None and value != []
        }
