"""The vessel about its reference, seen from above, in characters."""

from __future__ import annotations

import math

from rich.text import Text

_ARROWS = "↑↗→↘↓↙←↖"
_HEIGHT, _WIDTH = 7, 15  # a character is about twice as high as it is wide


def watch_circle(north: float, east: float, heading: float) -> tuple[Text, float]:
    """Return a picture, north up, and the distance from its centre to its edge (m).

    Parameters
    ----------
    north, east
        Vessel from the reference, finite, m.
    heading
        rad; the vessel is the one of eight arrows that comes closest.
    """
    radius = _scale(math.hypot(north, east))
    middle_row, middle_column = _HEIGHT // 2, _WIDTH // 2
    rows = [[" "] * _WIDTH for _ in range(_HEIGHT)]
    for k in range(48):
        angle = 2.0 * math.pi * k / 48
        row = middle_row - round(middle_row * math.cos(angle))
        rows[row][middle_column + round(middle_column * math.sin(angle))] = "·"
    rows[middle_row][middle_column] = "+"
    rows[0][middle_column] = "N"
    row = middle_row - round(middle_row * north / radius)
    column = middle_column + round(middle_column * east / radius)
    arrow = _ARROWS[round(heading / (math.pi / 4.0)) % 8]
    text = Text()
    for i, line in enumerate(rows):
        for j, character in enumerate(line):
            if (i, j) == (row, column):
                text.append(arrow, "bold cyan")
            else:
                text.append(character, "dim")
        if i < _HEIGHT - 1:
            text.append("\n")
    return text, radius


def _scale(distance: float) -> float:
    """Return the least of 0.1, 0.2, 0.5, 1, 2, 5 ... m that is not less than ``distance``, at most 500 km."""
    steps = [base * 10.0**power for power in range(-1, 6) for base in (1.0, 2.0, 5.0)]
    return next((step for step in steps if step >= distance), steps[-1])
