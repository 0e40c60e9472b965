"""One line that shows where a replay is."""

from __future__ import annotations

from rich.console import Console
from rich.live import Live
from rich.text import Text

from dp_tools.replay.player import Player

# Between two looks, ns: faster than that nobody reads.
_PERIOD = 100_000_000
KEYS = "space pause · → one message · s one sample · ↑↓ rate · q end"


class Screen:
    """Shows position, rate and state while it is open; nothing where there is no terminal.

    Parameters
    ----------
    console
        Where to.
    player
        What to show.
    end
        Of the replayed part, bag time, ns.
    keys
        Whether to show the keys.
    """

    def __init__(self, console: Console, player: Player, end: int, keys: bool) -> None:
        self._player = player
        self._end = end
        self._keys = keys
        self._next = 0
        self.live = Live(console=console, auto_refresh=False, transient=True) if console.is_terminal else None

    def line(self) -> str:
        """Return the line."""
        player = self._player
        state = "ended" if player.ended else "paused" if player.timeline.paused else "playing"
        late = player.lateness * 1e-9
        parts = [
            f"{state:<7} {player.position * 1e-9:9.3f} of {self._end * 1e-9:.3f} s",
            f"x {player.timeline.rate:g}",
            f"{player.sent} messages",
        ]
        if late > 0.1:
            parts.append(f"{late:.1f} s late")
        if self._keys:
            parts.append(KEYS)
        return "   ".join(parts)

    def show(self, now: int) -> None:
        """Bring the line up to date, a few times a second; ``now`` in ns."""
        if self.live is None or now < self._next:
            return
        self._next = now + _PERIOD
        self.live.update(Text(self.line(), no_wrap=True, overflow="ellipsis"), refresh=True)
