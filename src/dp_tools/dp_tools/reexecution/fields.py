"""Fields of a message by path, and how far two of them are apart."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator
from typing import Any

import numpy as np

Value = bool | int | float | str


def flat(message: Any, prefix: str = "") -> Iterator[tuple[str, Value]]:
    """Yield path and value of every field: ``pose.pose.position.x``, ``torque[2]``."""
    for name in message.get_fields_and_field_types():
        yield from _flat(getattr(message, name), prefix + name)


def _flat(value: Any, path: str) -> Iterator[tuple[str, Value]]:
    if hasattr(value, "get_fields_and_field_types"):
        yield from flat(value, f"{path}.")
    elif isinstance(value, list | tuple | array | np.ndarray):
        elements = value.tolist() if isinstance(value, array | np.ndarray) else value
        for i, element in enumerate(elements):
            yield from _flat(element, f"{path}[{i}]")
    else:
        yield path, value


def distance(recorded: Value | None, found: Value | None) -> float:
    """Return how far two values are apart: 0 if they are the same, infinite if they are not numbers or one is missing.

    NaN is the same as NaN.
    """
    if isinstance(recorded, str) or isinstance(found, str) or recorded is None or found is None:
        return 0.0 if recorded == found else math.inf
    a, b = float(recorded), float(found)
    if a == b or (math.isnan(a) and math.isnan(b)):
        # Zero has two signs, which a reader may see: the smallest number there is stands for that.
        return 0.0 if math.copysign(1.0, a) == math.copysign(1.0, b) or math.isnan(a) else math.ulp(0.0)
    gap = abs(a - b)
    return math.inf if math.isnan(gap) else gap
