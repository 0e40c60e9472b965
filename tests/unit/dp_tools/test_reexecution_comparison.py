"""What differs between recorded and re-executed messages: where, when, how much."""

from __future__ import annotations

import math
from typing import Any

import pytest
from dp_msgs.msg import ThrusterCommand
from rclpy.serialization import serialize_message

from dp_node import from_nanoseconds
from dp_tools.reexecution.canonical import canonical
from dp_tools.reexecution.comparison import Judge, aligned
from dp_tools.reexecution.detached import Caught
from dp_tools.reexecution.fields import distance
from dp_tools.reexecution.known_fields import whole
from dp_tools.reexecution.recording import Recorded

START = 7_000_000_000


def command(stamp: float, thrust: list[float], names: tuple[str, ...] = ("bow", "stern")) -> ThrusterCommand:
    message = ThrusterCommand(name=list(names), thrust=thrust, azimuth=[0.0, 0.0])
    message.header.stamp = from_nanoseconds(round(stamp * 1e9))
    return message


def recorded(message: Any, bag: float) -> Recorded:
    time = START + round(bag * 1e9)
    return Recorded(time, time, 1, serialize_message(message))


def caught(message: Any) -> Caught:
    return Caught("thruster_command", serialize_message(message), canonical(message), START, "tau_desired")


def compare(old: list[Any], new: list[Any], **options: Any) -> Any:
    judge = Judge(START, **options)
    told = [recorded(message, 10.0 + i) for i, message in enumerate(old)]
    return judge.compare("thruster_command", ThrusterCommand, whole, told, [caught(message) for message in new])


def test_equal_messages_agree_nan_included() -> None:
    messages = [command(0.2 * i, [1.0, math.nan]) for i in range(3)]
    found = compare(messages, messages)
    assert found.agrees
    assert (found.recorded, found.found, found.same) == (3, 3, 3)
    assert found.first is None


def test_a_difference_is_told_with_its_place_time_and_size() -> None:
    old = [command(0.2 * i, [1.0, 2.0]) for i in range(5)]
    new = [command(0.2 * i, [1.0, 2.0 + (0.25, 0.0, -0.5)[i - 2] if i >= 2 else 2.0]) for i in range(5)]
    found = compare(old, new)
    assert not found.agrees
    assert found.same == 3
    (difference,) = found.fields.values()
    first, largest = difference.first, difference.largest
    assert (difference.path, difference.count) == ("thrust", 2)
    assert (first.index, first.path, first.recorded, first.found, first.size) == (2, "thrust[1]", 2.0, 2.25, 0.25)
    assert (first.simulated, first.bag) == pytest.approx((0.4, 12.0), abs=1e-12)
    assert (largest.index, largest.size) == (4, 0.5)
    assert found.first is first


def test_the_last_bit_counts_and_so_does_the_sign_of_zero() -> None:
    assert not compare([command(0.2, [1.0, 2.0])], [command(0.2, [1.0, math.nextafter(2.0, 3.0)])]).agrees
    assert not compare([command(0.2, [1.0, 0.0])], [command(0.2, [1.0, -0.0])]).agrees


def test_a_tolerance_forgives_numbers_and_no_texts() -> None:
    near = [command(0.2, [1.0, 2.05])]
    assert compare([command(0.2, [1.0, 2.0])], near, tolerance=0.1).agrees
    assert not compare([command(0.2, [1.0, 2.0])], near, tolerance=0.01).agrees
    other = [command(0.2, [1.0, 2.0], ("bow", "aft"))]
    assert not compare([command(0.2, [1.0, 2.0])], other, tolerance=1e9).agrees


def test_a_missing_and_an_extra_message_do_not_shift_the_others() -> None:
    old = [command(0.2 * i, [float(i), 0.0]) for i in range(6)]
    new = [*old[:2], *old[3:5], command(0.9, [9.0, 9.0]), old[5]]
    found = compare(old, new)
    assert (found.missing, len(found.extra), found.same) == ([2], 1, 5)
    assert found.missing_from.index == 2
    assert found.missing_from.simulated == pytest.approx(0.4, abs=1e-12)
    assert found.first is found.missing_from


def test_what_comes_after_the_end_of_the_recording_is_not_judged() -> None:
    old = [command(0.2 * i, [1.0, 0.0]) for i in range(3)]
    found = compare(old[:2], old)
    assert found.agrees
    assert found.after_end == 1


def test_stamps_that_repeat_are_paired_in_order() -> None:
    assert aligned([1, 2, 2, 3], [1, 2, 2, 3]) == ([(0, 0), (1, 1), (2, 2), (3, 3)], [], [])
    assert aligned([1, 2, 2, 3], [1, 2, 3]) == ([(0, 0), (1, 1), (3, 2)], [2], [])
    assert aligned([1], [2]) == ([], [0], [0])


def test_distances() -> None:
    assert distance(1.0, 1.5) == 0.5
    assert distance(math.nan, math.nan) == 0.0
    assert distance(1.0, math.nan) == math.inf
    assert distance("nominal", "stale") == math.inf
    assert distance(None, 1.0) == math.inf
    assert 0.0 < distance(0.0, -0.0) < 1e-300


def test_only_the_first_difference() -> None:
    old = [command(0.2 * i, [1.0, 2.0]) for i in range(5)]
    new = [command(0.2 * i, [1.0, 3.0]) for i in range(5)]
    (difference,) = compare(old, new, only_first=True).fields.values()
    assert (difference.first.index, difference.count) == (0, 1)
