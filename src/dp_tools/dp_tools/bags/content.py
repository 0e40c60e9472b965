"""Content of a bag: order of times, gaps in the publishers' numbers, header stamps, numbers that are none."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from dp_tools.bags.bag import Bag, BagTopic
from dp_tools.bags.decode import TopicDecoder, base_path, blocks
from dp_tools.bags.errors import BagError
from dp_tools.bags.finding import Finding
from dp_tools.recorder.attachments import SCENARIO_ATTACHMENT, VESSEL_ATTACHMENT

_STAMP = "header.stamp"
# What an operator sends at time 0 is stamped 1 ns, as 0 would mean none, and may be answered before the first sample.
_SAME_TIME = 1
# Every node publishes there: times and numbers of several publishers are mixed.
_SHARED = frozenset(("/diagnostics", "/rosout", "/parameter_events"))


def check_content(bag: Bag, progress: Callable[[int], None] = lambda done: None) -> list[Finding]:
    """Return what is wrong with the messages of a bag.

    Parameters
    ----------
    bag
        Whole as far as its structure goes.
    progress
        Called with the number of messages looked at.
    """
    findings: list[Finding] = []
    done = 0

    def show(count: int) -> None:
        progress(done + count)

    for number, topic in enumerate(bag.topics):
        rows = np.flatnonzero(bag.messages.topic == number)
        findings += _check_times(bag, topic, rows)
        findings += _check_fields(bag, number, show)
        done += len(rows)
    names = [attachment.name for attachment in bag.attachments]
    for name in (VESSEL_ATTACHMENT, SCENARIO_ATTACHMENT):
        if names.count(name) > len(bag.files.files):
            findings.append(Finding(name, f"attached {names.count(name)} times"))
    return findings


def several_publishers(topic: BagTopic) -> bool:
    """Return whether messages of a topic may be of several publishers at a time."""
    return topic.name in _SHARED or len(topic.offered_quality) > 1


def lost_messages(numbers: NDArray[np.int64]) -> int | None:
    """Return how many numbers are missing in those of one topic, in the order of the file.

    A number that begins again at 1 is a new publisher. None if the numbers are not of one publisher at a time.
    """
    steps = np.diff(numbers)
    anew = numbers[1:] == 1
    if (numbers == 0).any() or bool(((steps <= 0) & ~anew).any()):
        return None
    return int((steps - 1)[~anew].sum())


def _check_times(bag: Bag, topic: BagTopic, rows: NDArray[np.int64]) -> Iterator[Finding]:
    messages = bag.messages
    log, publish = messages.log_time[rows], messages.publish_time[rows]
    if len(rows) < 2:
        return
    back = np.flatnonzero(np.diff(log) < 0)
    if len(back):
        yield Finding(topic.name, f"log time goes back {len(back)} times, first at message {back[0] + 1}")
    if not several_publishers(topic):
        back = np.flatnonzero(np.diff(publish) < 0)
        if len(back):
            yield Finding(topic.name, f"publish time goes back {len(back)} times, first at message {back[0] + 1}")
        lost = lost_messages(messages.sequence[rows])
        if lost:
            yield Finding(topic.name, f"{lost} messages lost, by the publisher's numbers")
    early = int((publish > log).sum())
    if early:
        yield Finding(topic.name, f"{early} messages logged before they were published: two clocks", wrong=False)


def _check_fields(bag: Bag, number: int, progress: Callable[[int], None]) -> Iterator[Finding]:
    topic = bag.topics[number]
    bad: dict[str, tuple[int, int]] = {}  # by field: how many messages, the first of them
    stamps: list[NDArray[np.int64]] = []
    count = 0
    try:
        decoder = TopicDecoder(topic)
        for rows, data in blocks(bag, number):
            for path, cells in decoder.block(data).items():
                if path == _STAMP:
                    stamps.append(cells.values)
                if cells.values.dtype.kind != "f":
                    continue
                wrong = cells.there & ~np.isfinite(cells.values)
                if wrong.any() and not decoder.may_be_none(path):
                    before, first = bad.get(path, (0, count + int(np.argmax(wrong))))
                    bad[path] = before + int(wrong.sum()), first
            count += len(rows)
            progress(count)
    except BagError as error:
        yield Finding(topic.name, str(error).removeprefix(f"{topic.name}: "))
        return
    yield from _tell_of_numbers(topic, bad, count)
    if stamps and not several_publishers(topic):
        back = np.flatnonzero(np.diff(np.concatenate(stamps)) < -_SAME_TIME)
        if len(back):
            yield Finding(topic.name, f"{_STAMP} goes back {len(back)} times, first at message {back[0] + 1}")


def _tell_of_numbers(topic: BagTopic, bad: dict[str, tuple[int, int]], count: int) -> Iterator[Finding]:
    """Tell of numbers that are none; one finding for all elements of an array."""
    fields: dict[str, tuple[int, int]] = {}
    for path, (times, first) in bad.items():
        before, earliest = fields.get(base_path(path), (0, first))
        fields[base_path(path)] = max(before, times), min(earliest, first)
    never = sorted(path for path, (times, _) in fields.items() if times == count)
    if never:
        text = f"{', '.join(never)}: no number in any message, as in a run in process where it is not logged"
        yield Finding(topic.name, text, wrong=False)
    for path, (times, first) in fields.items():
        if path not in never:
            yield Finding(topic.name, f"{path}: NaN or infinite in {times} of {count} messages, first in {first}")
