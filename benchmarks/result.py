"""One row of results.json, and the file."""

from __future__ import annotations

import json
import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

# Unit of a real-time factor: simulated seconds in a second.
REAL_TIME = "x real time"


@dataclass(frozen=True, slots=True)
class Aim:
    """What the project wants of one figure: its value, or its ratio to the peer's, on one side of a limit."""

    of: Literal["value", "ratio"]
    relation: Literal["<=", ">="]
    limit: float

    def met(self, value: float | None) -> bool:
        """Return whether ``value`` is on the wanted side. A figure that could not be had is not."""
        if value is None:
            return False
        return bool(operator.le(value, self.limit) if self.relation == "<=" else operator.ge(value, self.limit))

    def __str__(self) -> str:
        return f"{self.of} {self.relation} {self.limit:g}"


@dataclass(frozen=True, slots=True)
class Result:
    """One figure.

    Parameters
    ----------
    name
        Stable name, snake case.
    value, unit
        What was measured.
    peer, peer_value
        What it is compared with, and what that one showed in the same run; a peer without a value was not measured,
        and its text says why.
    aim
        What is wanted; None for information.
    note
        Repetitions, spread and the like; printed, not part of results.json.

    Raises
    ------
    ValueError
        If a number is not finite.
    """

    name: str
    value: float
    unit: str
    peer: str | None = None
    peer_value: float | None = None
    aim: Aim | None = None
    note: str = ""

    def __post_init__(self) -> None:
        for quantity, number in (("value", self.value), ("peer_value", self.peer_value)):
            if number is not None and not math.isfinite(number):
                raise ValueError(f"{self.name}.{quantity}: expected a finite number, found {number}")

    @property
    def ratio(self) -> float | None:
        """Value over the peer's value."""
        return self.value / self.peer_value if self.peer_value else None

    @property
    def met(self) -> bool | None:
        """Whether the aim is met; None without an aim."""
        if self.aim is None:
            return None
        return self.aim.met(self.value if self.aim.of == "value" else self.ratio)

    def row(self) -> dict[str, Any]:
        """Return what results.json holds of this figure."""
        return {
            "name": self.name,
            "value": self.value,
            "unit": self.unit,
            "peer": self.peer,
            "peer_value": self.peer_value,
            "ratio": self.ratio,
            "aim": None if self.aim is None else str(self.aim),
            "met": self.met,
        }


def write_results(path: Path, results: Sequence[Result]) -> None:
    """Write results.json: a list with one object a figure."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [result.row() for result in results]
    path.write_text(json.dumps(rows, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
