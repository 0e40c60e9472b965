"""What `dp design` prints."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.markup import escape
from rich.table import Table

from marine_model import Vessel
from thrust_allocator.design.loop import BusLoss, Split, Study


def numbers(thrusters: Sequence[int]) -> str:
    """Return thrusters as the tables of the thesis name them: 1 is the first of the vessel file."""
    return " ".join(str(j + 1) for j in thrusters)


def buses(split: Split) -> str:
    """Return a split such as '1 3 | 2 4'."""
    return " | ".join(numbers(bus) for bus in split.buses)


def _gain(gain: float) -> str:
    return f"{gain:.2f}" if gain > 0.0 else "–"


def combination_table(vessel: Vessel, found: Study) -> Table:
    """Return every combination of working thrusters, in the manner of [Ruth] Tables 7.1 and 7.2."""
    if found.azimuth is None:
        title = "Minimum gain and attainable ball, thrusters rotating freely (Table 7.2)"
    else:
        degrees = [f"{math.degrees(angle):.0f}" for angle in found.azimuth]
        title = f"Minimum gain and attainable ball, fixed at {', '.join(degrees)} deg (Table 7.1)"
    table = Table(title=title, title_justify="left")
    table.add_column("working", no_wrap=True)
    table.add_column("single failure", no_wrap=True)
    table.add_column("rank", justify="right", no_wrap=True)
    table.add_column("gain\nown", justify="right", no_wrap=True)
    table.add_column("gain\nequal", justify="right", no_wrap=True)
    table.add_column("ball\nscaled", justify="right", no_wrap=True)
    table.add_column(escape("ball\n[N, N m]"), justify="right", no_wrap=True)
    for row in found.combinations:
        table.add_row(
            numbers(row.thrusters),
            "" if row.lost is None else f"- {vessel.thruster_names[row.lost].replace('_', ' ')}",
            str(row.rank),
            *(_gain(value) for value in (row.gain, row.equal_gain, row.scaled_ball, row.ball)),
            end_section=len(row.thrusters) == len(vessel.thrusters) or row is _last_single(found),
        )
    return table


def _last_single(found: Study) -> object:
    singles = [row for row in found.combinations if row.lost is not None]
    return singles[-1] if singles else None


def split_table(found: Study) -> Table:
    """Return every split into two power buses with the minimum gain of the worse bus."""
    table = Table(title="Two power buses, gain of the worse", title_justify="left")
    table.add_column("buses")
    table.add_column("gain, own", justify="right")
    table.add_column("gain, equal", justify="right")
    own, equal = found.best_splits(equal_thrust=False), found.best_splits(equal_thrust=True)
    for split in found.splits:
        cells = [
            f"[bold green]{_gain(gain)} best[/]" if split in best else f"{_gain(gain)}     "
            for gain, best in ((split.gain, own), (split.equal_gain, equal))
        ]
        table.add_row(buses(split), *cells)
    return table


def split_lines(found: Study) -> tuple[str, ...]:
    """Return the best splits in words."""
    lines = []
    for words, equal in (("with its own thrusts", False), ("with equal thrusts", True)):
        best = found.best_splits(equal)
        if best:
            gain = min(split.equal_gain if equal else split.gain for split in best)
            names = " or ".join(buses(split) for split in best)
            lines.append(f"Best split {words}: {names}, minimum gain {gain:.2f} after the loss of either bus")
        else:
            lines.append(f"Best split {words}: none; whichever way, one bus alone cannot produce every force")
    return tuple(lines)


def bus_lines(losses: Sequence[BusLoss]) -> tuple[str, ...]:
    """Return what the loss of each bus of the vessel file leaves, in words."""
    lines = []
    for loss in losses:
        left = loss.left
        if left is None:
            lines.append(f"Loss of {loss.bus}: leaves nothing")
        else:
            gains = f"minimum gain {_gain(left.gain)}, {_gain(left.equal_gain)} with equal thrusts"
            lines.append(f"Loss of {loss.bus}, as the vessel file has it: leaves {numbers(left.thrusters)}, {gains}")
    return tuple(lines)


def ball_lines(found: Study) -> tuple[str, ...]:
    """Return the radius of the attainable ball: bounds of the thesis beside the exact value."""
    ball = found.ball
    exact = f"exact {ball.exact:.2f} ({ball.reversible:.2f} if reverse thrust were as strong as forward thrust)"
    if ball.without_root is None:
        bound = f"Theorem 7.3 {ball.printed:.2f}"
    else:
        bound = f"Lemma 7.2 as printed {ball.printed:.2f}, without its 1/√2 {ball.without_root:.2f}"
    return (f"Attainable ball, all thrusters, N and N m alike: {bound}, {exact}",)
