"""Sends messages when they are due; knows neither ROS nor a keyboard."""

from __future__ import annotations

from collections.abc import Callable

from dp_tools.replay.schedule import Schedule
from dp_tools.replay.timeline import Timeline

# Longest time for which messages are sent without letting others have their turn, ns.
_BURST = 5_000_000


class Player:
    """Plays a schedule.

    Parameters
    ----------
    schedule
        What is due when.
    send
        Sends the message of a row.
    clock
        Wall time, ns, never going back.
    rate
        Bag seconds a wall second, above 0.
    loop
        True to begin anew at the end, for ever.
    paused
        True to wait for :meth:`resume` or a step before the first message.
    """

    def __init__(
        self,
        schedule: Schedule,
        send: Callable[[int], None],
        clock: Callable[[], int],
        rate: float = 1.0,
        loop: bool = False,
        paused: bool = False,
    ) -> None:
        self._schedule = schedule
        self._send = send
        self._clock = clock
        self._loop = loop
        self._rows: list[int] = schedule.rows.tolist()
        self._due: list[int] = schedule.due.tolist()
        self._place = 0
        self.timeline = Timeline(schedule.begin, clock(), rate, paused)
        self.sent = 0
        """Messages sent so far, in all rounds."""
        self.rounds = 0
        """Rounds that are over."""
        self.worst = 0
        """Largest lateness of a message, ns."""
        self.worst_at = 0
        """Bag time of that message, ns."""
        self.total_lateness = 0
        self.timed = 0
        """Messages that had a time to be sent at: all but those sent by a step."""

    @property
    def ended(self) -> bool:
        """True once everything has been sent and nothing begins anew."""
        return self._place >= len(self._rows)

    @property
    def position(self) -> int:
        """Bag time, ns; never beyond the end, and never beyond the next message while that is late."""
        if self.ended:
            return self._schedule.end
        return max(self._schedule.begin, min(self.timeline.at(self._clock()), self._due[self._place]))

    def begin(self) -> None:
        """Let the time run from now on, as making everything ready has taken some."""
        self.timeline.jump(self._schedule.begin, self._clock())

    @property
    def lateness(self) -> int:
        """By how much the next message is late at present, ns; 0 if it is not."""
        if self.ended or self.timeline.paused:
            return 0
        return max(0, self._clock() - self.timeline.due(self._due[self._place]))

    def advance(self) -> int | None:
        """Send what is due, for a few ms at most; return the wall time of what comes next, ns, None if nothing does.

        What is late is sent at once and in order, nothing is left out.
        """
        now = self._clock()
        give_way = now + _BURST
        timeline, due_at, rows, clock, send = self.timeline, self._due, self._rows, self._clock, self._send
        while not timeline.paused and self._place < len(rows):
            due = timeline.due(due_at[self._place])
            now = clock()
            if now < due:
                return due
            if now >= give_way:
                return now
            send(rows[self._place])
            late = now - due
            if late > self.worst:
                self.worst, self.worst_at = late, due_at[self._place]
            self.total_lateness += late
            self.timed += 1
            self.sent += 1
            self._place += 1
            if self._loop and self._place == len(rows):
                self._begin_anew(due)
        return None

    def pause(self) -> None:
        """Stand; what is late at this moment counts as not yet due."""
        if not self.timeline.paused:
            now = self._clock()
            position = self.position
            self.timeline.pause(now)
            self.timeline.jump(position, now)

    def resume(self) -> None:
        """Go on."""
        if self.timeline.paused:
            self.timeline.resume(self._clock())

    def set_rate(self, rate: float) -> None:
        """Go on faster or slower. Raises InputError if ``rate`` is not above 0."""
        now, position = self._clock(), self.position
        self.timeline.set_rate(rate, now)
        self.timeline.jump(position, now)

    def step(self) -> int:
        """Pause, and send the next message; return how many were sent."""
        return self._send_to(self._place + 1)

    def step_sample(self) -> int:
        """Pause, and send what is left of this sample; return how many messages that were."""
        return self._send_to(self._schedule.next_sample(self._place))

    def _send_to(self, place: int) -> int:
        self.pause()
        before = self._place
        while self._place < min(place, len(self._rows)):
            self._send(self._rows[self._place])
            self._place += 1
        count = self._place - before
        self.sent += count
        if count:
            now = self._clock()
            self.timeline.jump(self._due[self._place - 1], now)
            if self.ended and self._loop:
                self._begin_anew(now)
        return count

    def _begin_anew(self, wall: int) -> None:
        """Begin again as if the first message were due right behind the last, at wall time ``wall``."""
        self.rounds += 1
        self._place = 0
        self.timeline.jump(self._schedule.begin, wall)
