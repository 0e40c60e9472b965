"""When which message of a bag is due."""

from __future__ import annotations

import struct
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from dp_tools.bags.bag import Bag
from dp_tools.bags.errors import BagError

_NANOSECONDS = 1_000_000_000
_CLOCK = "rosgraph_msgs/msg/Clock"
# A clock message is a head of four bytes and one time.
_CLOCK_TIME = struct.Struct("<4xiI")
# A sample of the graph begins with a measured position.
_SAMPLE_TOPIC = "pose"

TimeOf = Literal["publish", "log"]


@dataclass(frozen=True)
class Schedule:
    """Messages in the order in which they are sent.

    Attributes
    ----------
    rows
        Of :attr:`Bag.messages`.
    due
        ns from the beginning of the bag, not decreasing.
    begin, end
        Of the part to be replayed, ns from the beginning of the bag.
    origin
        The beginning of the bag, ns since 1970.
    sample_begins
        Places in ``rows`` at which a sample begins, increasing; empty if the bag knows no samples.
    """

    rows: NDArray[np.int64]
    due: NDArray[np.int64]
    begin: int
    end: int
    origin: int
    sample_begins: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.rows)

    def next_sample(self, place: int) -> int:
        """Return the place up to which (exclusive) to send from ``place``, so that one sample is sent."""
        if place >= len(self):
            return place
        after = np.searchsorted(self.sample_begins, place, side="right")
        if not len(self.sample_begins):
            return place + 1
        return int(self.sample_begins[after]) if after < len(self.sample_begins) else len(self)


def make_schedule(
    bag: Bag,
    names: Collection[str],
    time_of: TimeOf = "publish",
    start: float | None = None,
    until: float | None = None,
    simulated: bool = False,
) -> Schedule:
    """Return when the messages of the topics in ``names`` are due.

    Parameters
    ----------
    bag
        Where they are.
    names
        Recorded names to replay.
    time_of
        Whether publish or log times count. A message without publish time (0) has its log time.
    start, until
        Part to replay, s from the first message of the bag, both inclusive; None for all.
    simulated
        True if ``start`` and ``until`` are simulated time, s, as the bag's clock tells it.

    Raises
    ------
    BagError
        If nothing is to be replayed, or simulated time is asked for and the bag has no clock.
    """
    times = message_times(bag, time_of)
    if not len(times):
        raise BagError(f"{bag.files.path}: holds no message")
    origin = int(times.min())
    since = times - origin
    if simulated:
        begin, end = _by_clock(bag, since, start, until)
    else:
        begin = 0 if start is None else _ns(start)
        end = int(since.max()) if until is None else _ns(until)
    wanted = np.array([topic.name in names for topic in bag.topics], dtype=np.bool_)
    rows = np.flatnonzero(wanted[bag.messages.topic] & (since >= begin) & (since <= end))
    if not len(rows):
        length = since.max() * 1e-9
        raise BagError(f"{bag.files.path}: no message of these topics in that time; the bag is {length:.3f} s long")
    rows = rows[np.argsort(since[rows], kind="stable")]
    sampled = np.array([topic.name.rpartition("/")[2] == _SAMPLE_TOPIC for topic in bag.topics], dtype=np.bool_)
    begins = np.flatnonzero(sampled[bag.messages.topic[rows]])
    return Schedule(rows, since[rows], begin, min(end, int(since[rows].max())), origin, begins)


def message_times(bag: Bag, time_of: TimeOf) -> NDArray[np.int64]:
    """Return the time of every message, ns since 1970."""
    messages = bag.messages
    if time_of == "log":
        return messages.log_time
    return np.where(messages.publish_time == 0, messages.log_time, messages.publish_time)


def clock_times(bag: Bag) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return rows and simulated times (ns) of the bag's clock.

    Raises
    ------
    BagError
        If it has none, more than one (of several graphs), or one that cannot be read.
    """
    clocks = [number for number, topic in enumerate(bag.topics) if topic.kind == _CLOCK]
    if len({bag.topics[number].name for number in clocks}) != 1:
        found = ", ".join(bag.topics[number].name for number in clocks) or "none"
        raise BagError(f"{bag.files.path}: simulated time needs one clock, found {found}")
    rows = np.flatnonzero(np.isin(bag.messages.topic, clocks))
    try:
        told = [_CLOCK_TIME.unpack_from(bag.data(row)) for row in rows.tolist()]
    except struct.error as error:
        raise BagError(f"{bag.files.path}: the clock cannot be read: {error}") from error
    return rows, np.array([sec * _NANOSECONDS + nanosec for sec, nanosec in told], dtype=np.int64)


def _by_clock(bag: Bag, since: NDArray[np.int64], start: float | None, until: float | None) -> tuple[int, int]:
    """Return begin and end: from the clock's first telling of ``start`` or later to before that of more than ``until``.

    The clock tells a time before anything of that time is sent.
    """
    rows, told = clock_times(bag)
    begin, end = 0, int(since.max())
    if start is not None and start > 0.0:
        within = since[rows[told >= _ns(start)]]
        begin = int(within.min()) if len(within) else end + 1
    if until is not None:
        after = since[rows[told > _ns(until)]]
        end = int(after.min()) - 1 if len(after) else end
    return begin, end


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)
