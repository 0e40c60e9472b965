"""How patient the supervisor is."""

from __future__ import annotations

from dataclasses import dataclass, fields

from marine_model.errors import InputError


@dataclass(frozen=True)
class Rules:
    """Times in s of wall time.

    Parameters
    ----------
    first_delay, longest_delay
        Back-off before a restart: the first one, doubled for each death that follows, up to the longest.
    stable_after
        A process that was up for so long is in order again: the next back-off is the first one.
    attempts, window
        With more deaths than ``attempts`` within ``window`` it is given up.
    silent_after
        A node of which nothing has been heard for so long is said to be silent.
    hang_timeout
        It is killed after so long.
    start_timeout
        A process that is not up by then is killed as well; time that it waits for others does not count. Machine
        code that is not on disk yet takes a minute to compile on a busy machine.
    stop_timeout
        One that was asked to end, for a restart that somebody wants, is killed if it has not ended by then.

    Raises
    ------
    InputError
        If a number is not above 0, or a limit is below what comes before it.
    """

    first_delay: float = 1.0
    longest_delay: float = 30.0
    stable_after: float = 30.0
    attempts: int = 5
    window: float = 120.0
    silent_after: float = 3.0
    hang_timeout: float = 10.0
    start_timeout: float = 120.0
    stop_timeout: float = 8.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            # Written so that NaN is refused.
            if not value > 0:
                raise InputError(f"{field.name}: expected a number above 0, found {value}")
        for low, high in (("first_delay", "longest_delay"), ("silent_after", "hang_timeout")):
            if getattr(self, high) < getattr(self, low):
                raise InputError(
                    f"{high}: expected at least {low}, {getattr(self, low):g} s, found {getattr(self, high):g} s"
                )
