import pytest
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st

from dp_node import StampSequence, from_nanoseconds, seconds_between, to_nanoseconds
from marine_model.errors import InputError


@given(st.integers(0, 2**31 * 10**9 - 1))
def test_nanoseconds_survive_the_round_trip(nanoseconds: int) -> None:
    assert to_nanoseconds(from_nanoseconds(nanoseconds)) == nanoseconds


def test_the_first_stamp_takes_the_given_time_and_the_next_its_difference() -> None:
    sequence = StampSequence("pose")
    assert sequence.step(Time(sec=5), first=0.2) == 0.2
    assert sequence.step(Time(sec=5, nanosec=200_000_000), first=0.2) == seconds_between(0, 200_000_000)


@pytest.mark.parametrize("stamp", [Time(sec=4), Time(sec=5)])
def test_a_stamp_that_repeats_or_jumps_back_is_refused_and_changes_nothing(stamp: Time) -> None:
    sequence = StampSequence("pose")
    sequence.step(Time(sec=5), first=0.2)
    with pytest.raises(InputError, match=r"pose: expected a time stamp after 5\.000 s, found [45]\.000 s"):
        sequence.step(stamp, first=0.2)
    assert sequence.step(Time(sec=6), first=0.2) == 1.0


def test_after_a_reset_any_stamp_is_the_first() -> None:
    sequence = StampSequence("pose")
    sequence.step(Time(sec=5), first=0.2)
    sequence.reset()
    assert sequence.step(Time(sec=1), first=0.3) == 0.3
