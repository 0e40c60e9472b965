import pytest
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st

from dp_node import SourceRestartError, StampSequence, from_nanoseconds, seconds_between, to_nanoseconds
from marine_model.errors import InputError

SAMPLE = 0.1  # s; the gap is ten times as long


def sequence_at(seconds: float) -> StampSequence:
    sequence = StampSequence("pose", SAMPLE)
    sequence.step(at(seconds), first=0.2)
    return sequence


def at(seconds: float) -> Time:
    return from_nanoseconds(round(seconds * 1e9))


@given(st.integers(0, 2**31 * 10**9 - 1))
def test_nanoseconds_survive_the_round_trip(nanoseconds: int) -> None:
    assert to_nanoseconds(from_nanoseconds(nanoseconds)) == nanoseconds


def test_the_first_stamp_takes_the_given_time_and_the_next_its_difference() -> None:
    sequence = StampSequence("pose", SAMPLE)
    assert sequence.step(at(5.0), first=0.2) == 0.2
    assert sequence.step(at(5.2), first=0.2) == seconds_between(0, 200_000_000)


@pytest.mark.parametrize("stamp", [4.0, 5.0])
def test_a_stamp_that_repeats_or_jumps_back_is_refused_and_changes_nothing(stamp: float) -> None:
    sequence = sequence_at(5.0)
    with pytest.raises(InputError, match=rf"pose: expected a time stamp after 5\.000 s, found {stamp:.0f}\.000 s"):
        sequence.step(at(stamp), first=0.2)
    assert sequence.step(at(6.0), first=0.2) == 1.0


def test_after_a_reset_any_stamp_is_the_first() -> None:
    sequence = sequence_at(5.0)
    sequence.reset()
    assert sequence.step(at(1.0), first=0.3) == 0.3


def refusals(sequence: StampSequence, stamps: list[float]) -> list[type[Exception] | None]:
    found: list[type[Exception] | None] = []
    for stamp in stamps:
        try:
            sequence.step(at(stamp), 0.0)
            found.append(None)
        except InputError as error:
            found.append(type(error))
    return found


def test_three_in_a_row_far_behind_that_increase_say_that_the_source_began_anew() -> None:
    sequence = sequence_at(50.0)
    assert refusals(sequence, [0.0, 0.1, 0.2]) == [InputError, InputError, SourceRestartError]
    assert sequence.step(at(0.2), first=0.7) == 0.7, "given again, the stamp is the first"
    assert refusals(sequence, [0.3, 0.4]) == [None, None]


@pytest.mark.parametrize(
    "stamps",
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],  # frozen
        [3.0, 2.0, 1.0, 0.5, 0.2],  # running backwards
        [0.0, 7.0, 14.0, 21.0, 28.0],  # at random
        [49.2, 49.3, 49.4, 49.5, 49.6],  # overtaken
    ],
)
def test_stamps_behind_that_are_no_new_beginning_are_all_refused(stamps: list[float]) -> None:
    sequence = sequence_at(50.0)
    assert refusals(sequence, stamps) == [InputError] * 5
    assert sequence.step(at(50.1), 0.0) == pytest.approx(0.1, abs=1e-12)


def test_one_good_stamp_between_them_ends_the_row() -> None:
    sequence = sequence_at(50.0)
    stamps = [0.0, 0.1, 50.1, 0.2, 0.3, 50.2]
    assert refusals(sequence, stamps) == [InputError, InputError, None, InputError, InputError, None]


def test_a_single_stamp_far_ahead_is_refused_and_the_next_one_goes_on() -> None:
    sequence = sequence_at(50.0)
    with pytest.raises(InputError, match=r"expected a time stamp at most 1 s after 50\.000 s, found 90\.000 s"):
        sequence.step(at(90.0), 0.0)
    assert sequence.step(at(50.1), 0.0) == pytest.approx(0.1, abs=1e-12)


def test_after_a_pause_the_third_stamp_in_a_row_is_believed() -> None:
    sequence = sequence_at(50.0)
    assert refusals(sequence, [80.0, 80.1]) == [InputError, InputError]
    assert sequence.step(at(80.2), 0.0) == pytest.approx(30.2, abs=1e-12)
    assert sequence.step(at(80.3), 0.0) == pytest.approx(0.1, abs=1e-12)


def test_who_keeps_nothing_of_the_past_follows_a_new_beginning() -> None:
    sequence = sequence_at(50.0)
    assert refusals(sequence, [0.0, 0.1]) == [InputError, InputError]
    sequence.follow(at(0.2))
    assert sequence.last == 200_000_000


def test_an_input_of_another_topic_may_not_be_far_ahead() -> None:
    sequence = sequence_at(50.0)
    sequence.check_ahead("joystick", to_nanoseconds(at(51.0)))
    with pytest.raises(InputError, match=r"joystick: .* at most 1 s after that of the last pose, 50\.000 s, found 52"):
        sequence.check_ahead("joystick", to_nanoseconds(at(52.0)))


@given(st.lists(st.integers(0, 2**31 * 10**9 - 1), max_size=60))
def test_whatever_comes_time_that_was_taken_only_increases_between_new_beginnings(stamps: list[int]) -> None:
    sequence = StampSequence("pose", SAMPLE)
    last: int | None = None
    for stamp in stamps:
        try:
            elapsed = sequence.step(from_nanoseconds(stamp), 0.0)
        except SourceRestartError:
            last = None
            continue
        except InputError:
            assert sequence.last == last
            continue
        assert last is None or elapsed == seconds_between(last, stamp) > 0.0
        last = stamp


@given(st.integers(0, 10**12), st.integers(0, 10**12))
def test_wherever_time_jumps_to_it_is_taken_up_again(before: int, after: int) -> None:
    sequence = StampSequence("pose", SAMPLE)
    step = round(SAMPLE * 1e9)
    for i in range(5):
        sequence.step(from_nanoseconds(before + i * step), 0.0)
    taken = 0
    for i in range(20):
        stamp = from_nanoseconds(after + i * step)
        try:
            sequence.step(stamp, 0.0)
        except SourceRestartError:
            sequence.step(stamp, 0.0)
        except InputError:
            continue
        taken += 1
    # A jump back within the gap costs the samples of the gap and those that were taken; any other costs two.
    assert taken >= 20 - 10 - 1
