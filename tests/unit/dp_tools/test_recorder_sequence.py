"""Gaps in sequence numbers."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dp_tools.recorder.sequence import SequenceCounter


def lost(numbers: list[int]) -> int:
    counter = SequenceCounter()
    for number in numbers:
        counter.note(number)
    for _ in range(2):
        counter.one_publisher()
    return counter.lost


def test_gaps_by_hand() -> None:
    assert lost([]) == 0
    assert lost([7, 8, 9]) == 0  # joined late
    assert lost([1, 2, 5, 6, 9]) == 4
    assert lost([5, 6, 1, 2]) == 0  # the publisher was started anew
    assert lost([5, 6, 1, 3]) == 1


@given(st.sets(st.integers(1, 200), max_size=150))
def test_what_is_missing_between_first_and_last_is_lost(dropped: set[int]) -> None:
    numbers = [n for n in range(202) if n not in dropped]
    assert lost(numbers) == len(dropped)


def test_several_publishers_are_not_counted() -> None:
    counter = SequenceCounter()
    counter.note(1)
    counter.note(3)
    counter.one_publisher()
    assert counter.lost == 0
    counter.one_publisher()
    counter.note(70)  # the second one, before the graph tells of it
    counter.one_publisher()
    counter.several_publishers()
    counter.note(4)
    counter.note(79)
    counter.one_publisher()  # the second one has gone; which number belongs to whom stays unknown
    assert counter.lost == 1
    assert not counter.countable


def test_a_middleware_without_numbers_is_not_counted() -> None:
    counter = SequenceCounter()
    counter.note(None)
    counter.note(5)
    assert counter.lost == 0
    assert not counter.countable
