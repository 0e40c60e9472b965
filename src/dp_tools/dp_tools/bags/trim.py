"""A part of a bag as a bag of its own, which still says exactly what ran."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Attachment, Metadata
from numpy.typing import NDArray

from dp_bringup.parameter_file import to_parameter_file
from dp_tools.bags.bag import Bag
from dp_tools.bags.copy import BagCopy, custom_data
from dp_tools.bags.parameters import EVENTS, FOLDER, parameters_at
from dp_tools.replay.quality import replayed_quality
from dp_tools.replay.schedule import Schedule, TimeOf, make_schedule, message_times

# A latched topic of unknown depth that speaks within this time from the start needs no earlier message, ns.
_SOON = 1_000_000_000
TRIMMED_RECORD = "trimmed"


@dataclass
class Trimmed:
    """What is in a trimmed bag.

    Attributes
    ----------
    messages
        Number of messages, carried ones included.
    carried
        Topics with a message from before the start.
    nodes
        Nodes whose parameters at the start are attached.
    """

    messages: int = 0
    carried: list[str] = field(default_factory=list)
    nodes: list[str] = field(default_factory=list)


def trim(
    bag: Bag,
    output: Path,
    names: Collection[str],
    time_of: TimeOf = "publish",
    start: float | None = None,
    until: float | None = None,
    simulated: bool = False,
    overwrite: bool = False,
    progress: Callable[[int], None] = lambda done: None,
) -> Trimmed:
    """Write a part of a bag to a new one.

    The last message from before the start is carried over, with the start as its time, on topics that are kept for
    late readers with depth 1, or whose depth the bag does not tell and that are silent for a second from the start.
    Attachments stay; parameters are those at the start. Parameter events stay whichever topics are chosen.

    Parameters
    ----------
    bag
        Open.
    output
        Folder of the new bag.
    names
        Topics to keep.
    time_of, start, until, simulated
        As in :func:`dp_tools.replay.schedule.make_schedule`.
    overwrite
        True to replace a bag that is there.
    progress
        Called with the number of messages written.

    Raises
    ------
    BagError
        If nothing is left, or the bag cannot be read.
    RecordingRefusedError, RecordingStoppedError
        If the new bag cannot be written.
    """
    wanted = {*names, EVENTS}
    schedule = make_schedule(bag, names, time_of, start, until, simulated)
    begin = schedule.origin + schedule.begin
    first, last = begin, schedule.origin + schedule.end
    parameters = parameters_at(bag, first)
    times = message_times(bag, time_of)
    kept = _rows(bag, wanted, times, first, last)
    carried = _carried(bag, wanted, times, schedule)
    done = Trimmed()
    copy = BagCopy(output, overwrite)
    custom = custom_data(bag.files.metadata)
    try:
        for topic in bag.topics:
            if topic.name in wanted:
                copy.add_topic(topic)
        known = {snapshot.node for snapshot in parameters}
        for attachment in bag.attachments:
            if not _is_replaced(attachment, known, first, last):
                copy.attach(attachment)
        for snapshot in parameters:
            name = f"{FOLDER}{snapshot.node.strip('/')}.yaml"
            text = to_parameter_file({snapshot.node.rpartition("/")[2]: snapshot.values})
            copy.attach(Attachment(first, first, name, "application/yaml", text.encode()))
            done.nodes.append(snapshot.node)
        for record in bag.records:
            copy.describe(record)
        for row in carried:
            topic = bag.topics[bag.messages.topic[row]]
            copy.write(topic, int(bag.messages.sequence[row]), first, first, bag.data(row))
            done.carried.append(topic.name)
        words = _words(bag, schedule, done)
        copy.describe(Metadata(TRIMMED_RECORD, words))
        _write(bag, copy, kept, progress)
        custom["trimmed"] = f"{words['begin']} to {words['end']} s of {words['bag']}"
    finally:
        copy.close(custom)
    done.messages = copy.count
    return done


def _rows(bag: Bag, wanted: Collection[str], times: NDArray[np.int64], first: int, last: int) -> NDArray[np.int64]:
    chosen = np.array([topic.name in wanted for topic in bag.topics], dtype=np.bool_)
    return np.flatnonzero(chosen[bag.messages.topic] & (times >= first) & (times <= last))


def _carried(bag: Bag, wanted: Collection[str], times: NDArray[np.int64], schedule: Schedule) -> list[int]:
    """Return the rows from before the start that late readers would still hear, in order of time."""
    first = schedule.origin + schedule.begin
    rows = []
    for name in dict.fromkeys(topic.name for topic in bag.topics):
        if name not in wanted or name == EVENTS:
            continue
        numbers = [number for number, topic in enumerate(bag.topics) if topic.name == name]
        offered = [offer for number in numbers for offer in bag.topics[number].offered_quality]
        if replayed_quality(offered).durability.name != "TRANSIENT_LOCAL":
            continue
        depths = {offer.get("depth") for offer in offered if str(offer.get("history")) in ("keep_last", "1")}
        own = np.flatnonzero(np.isin(bag.messages.topic, numbers))
        before = own[times[own] < first]
        speaks = ((times[own] >= first) & (times[own] < first + _SOON)).any()
        if len(before) and (depths == {1} or (not depths and not speaks)):
            rows.append(int(before[np.argmax(times[before])]))
    return sorted(rows, key=lambda row: int(times[row]))


def _is_replaced(attachment: Any, known: Collection[str], first: int, last: int) -> bool:
    """Return whether an attachment is parameters that those at the start replace, or of a time behind the end."""
    name, time = str(attachment.name), int(attachment.log_time)
    if not name.startswith(FOLDER):
        return False
    if time > attachment.create_time:  # a further file of a split bag begins
        return True
    node = "/" + name.removeprefix(FOLDER).removesuffix(".yaml")
    return (node in known and time <= first) or time > last


def _words(bag: Bag, schedule: Schedule, done: Trimmed) -> dict[str, str]:
    return {
        "bag": bag.files.path.name,
        "begin": f"{schedule.begin * 1e-9:.9f}",
        "end": f"{schedule.end * 1e-9:.9f}",
        "carried": ", ".join(done.carried),
    }


def _write(bag: Bag, copy: BagCopy, rows: NDArray[np.int64], progress: Callable[[int], None]) -> None:
    messages = bag.messages
    for done, row in enumerate(rows.tolist()):
        topic = bag.topics[messages.topic[row]]
        log, publish = int(messages.log_time[row]), int(messages.publish_time[row])
        copy.write(topic, int(messages.sequence[row]), log, publish, bag.data(row))
        if done % 1000 == 0:
            progress(done)
