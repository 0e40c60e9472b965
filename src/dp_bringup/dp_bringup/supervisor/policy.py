"""When one process is started, killed, restarted and given up: a state machine without processes, ROS or a clock."""

from __future__ import annotations

from collections import deque
from enum import StrEnum

from dp_bringup.supervisor.rules import Rules

# Time between two looks beyond this is time in which the supervisor itself slept, and heard nobody: it does not count.
_LONGEST_LOOK = 1.0  # s


class Phase(StrEnum):
    """What a process is about."""

    DUE = "due"  # to be started at once
    STARTING = "starting"
    UP = "up"
    ENDING = "ending"  # was told to end, or killed
    BACK_OFF = "back_off"
    GIVEN_UP = "given_up"


class Action(StrEnum):
    """What is to be done to a process now."""

    START = "start"
    STOP = "stop"
    KILL = "kill"


class Policy:
    """The state machine of one process; every time is wall time in s, from one steady clock.

    Whoever runs it calls :meth:`look` again and again, does what it returns, and reports what happens: :meth:`up`,
    :meth:`heard`, :meth:`died`, :meth:`asked`. A process that dies before it was up for the first time cannot be
    started: it is given up at once.

    Parameters
    ----------
    rules
        How patient it is.
    """

    def __init__(self, rules: Rules) -> None:
        self._rules = rules
        self.phase = Phase.DUE
        self.restarts = 0  # starts after the first
        self.reason = ""  # of the last end
        self.was_up = False
        self._starts = 0
        self._failures = 0  # deaths since it was last stable
        self._deaths: deque[float] = deque()
        self._since = 0.0  # when the present phase began
        self._heard = 0.0
        self._looked: float | None = None
        self._wanted = False  # the end was asked for
        self._killed = False
        self._died_at: float | None = None

    def look(self, now: float) -> Action | None:
        """Return what is to be done now, once."""
        if self._looked is not None and now - self._looked > _LONGEST_LOOK:
            asleep = now - self._looked - _LONGEST_LOOK
            self._heard += asleep
            if self.phase is Phase.STARTING:
                self._since += asleep
        self._looked = now
        if self.phase is Phase.DUE or (self.phase is Phase.BACK_OFF and now >= self.due):
            self._enter(Phase.STARTING, now)
            self._starts += 1
            self.restarts = self._starts - 1
            self._killed = self._wanted = False
            return Action.START
        if self.phase is Phase.STARTING and now - self._since >= self._rules.start_timeout:
            return self._kill(f"not up within {self._rules.start_timeout:g} s", now)
        if self.phase is Phase.UP and now - self._heard >= self._rules.hang_timeout:
            return self._kill(f"silent for {self._rules.hang_timeout:g} s", now)
        if self.phase is Phase.ENDING and not self._killed and now - self._since >= self._rules.stop_timeout:
            self._killed = True
            return Action.KILL
        return None

    def up(self, now: float) -> None:
        """Take note that the process does its work."""
        if self.phase is Phase.STARTING:
            self._enter(Phase.UP, now)
            self._heard = now
            self.was_up = True

    def heard(self, now: float) -> None:
        """Take note of a sign of life."""
        self._heard = now

    def waits(self, now: float) -> None:
        """Take note that it is others who keep the process from coming up."""
        if self.phase is Phase.STARTING:
            self._since = now

    def failed(self, reason: str, now: float) -> Action | None:
        """Take note that the process runs but will not come up, e.g. refuses to configure."""
        return self._kill(reason, now) if self.phase is Phase.STARTING else None

    def asked(self, now: float) -> Action | None:
        """Take note that somebody wants a restart, and return what is to be done for it now."""
        if self.phase in (Phase.BACK_OFF, Phase.GIVEN_UP):
            self._forgive()
            self._enter(Phase.DUE, now)
        elif self.phase in (Phase.STARTING, Phase.UP):
            self._forgive()
            self._wanted = True
            self._enter(Phase.ENDING, now)
            return Action.STOP
        return None

    def died(self, how: str, now: float) -> None:
        """Take note that the process has ended; ``how`` in words."""
        if self.phase not in (Phase.STARTING, Phase.UP, Phase.ENDING):
            return
        if self.phase is Phase.UP and now - self._since >= self._rules.stable_after:
            self._failures = 0
        if self._wanted:
            self.reason = "restart asked for"
            self._enter(Phase.DUE, now)
            return
        if not (self.phase is Phase.ENDING and self.reason):
            self.reason = how
        self._died_at = now
        self._deaths.append(now)
        while self._deaths[0] < now - self._rules.window:
            self._deaths.popleft()
        if not self.was_up or len(self._deaths) > self._rules.attempts:
            self._enter(Phase.GIVEN_UP, now)
            return
        self._enter(Phase.BACK_OFF, now)
        self._failures += 1

    @property
    def delay(self) -> float:
        """The back-off that belongs to the last death, s."""
        doublings = min(max(self._failures - 1, 0), 60)  # beyond, doubling is past any longest delay
        return min(self._rules.first_delay * 2.0**doublings, self._rules.longest_delay)

    @property
    def due(self) -> float:
        """When the back-off is over."""
        return self._since + self.delay

    @property
    def deaths(self) -> int:
        """Deaths within the window."""
        return len(self._deaths)

    def silent(self, now: float) -> bool:
        """Return whether the process is up but nothing has been heard of it for long."""
        return self.phase is Phase.UP and now - self._heard >= self._rules.silent_after

    def shaken(self, now: float) -> bool:
        """Return whether it died lately and has not been up for long enough since."""
        if self._died_at is None or self.phase is Phase.GIVEN_UP:
            return False
        return self.phase is not Phase.UP or (
            self._since >= self._died_at and now - self._since < self._rules.stable_after
        )

    def _kill(self, reason: str, now: float) -> Action:
        self.reason = reason
        self._enter(Phase.ENDING, now)
        self._killed = True
        return Action.KILL

    def _forgive(self) -> None:
        self._failures = 0
        self._deaths.clear()

    def _enter(self, phase: Phase, now: float) -> None:
        if phase is Phase.STARTING:
            self.reason = self.reason if self._starts else ""
        self.phase = phase
        self._since = now
