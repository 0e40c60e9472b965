"""Numbers as bars of characters."""

from __future__ import annotations

import math

from rich.text import Text

_EIGHTHS = " ▏▎▍▌▋▊▉█"


def share_bar(share: float, width: int, style: str) -> Text:
    """Return a bar that fills ``share`` of ``width`` characters; beyond 0 and 1 it is empty or full."""
    eighths = round(8 * width * min(max(share, 0.0), 1.0)) if math.isfinite(share) else 0
    full, rest = divmod(eighths, 8)
    filled = "█" * full + (_EIGHTHS[rest] if rest else "")
    return Text().append(filled, style).append("·" * (width - len(filled)), "dim")


def thrust_bar(thrust: float, lowest: float, highest: float, width: int, style: str) -> Text:
    """Return a bar from the middle: to the right ahead, to the left astern, full at either limit (N)."""
    half = width // 2
    ahead = thrust / highest if thrust > 0.0 and highest > 0.0 else 0.0
    astern = thrust / lowest if thrust < 0.0 and lowest < 0.0 else 0.0
    left = round(half * min(astern, 1.0))
    bar = Text().append("·" * (half - left), "dim").append("█" * left, style).append("│", "dim")
    return bar.append_text(share_bar(ahead, half, style))
