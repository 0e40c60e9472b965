"""The disturber's core: what each fault makes of a stream of poses."""

from __future__ import annotations

import math
from typing import Any

import pytest

from dp_tools.disturber import Disturber, DisturberSettings, PoseSample
from marine_model.errors import InputError
from marine_model.settings import with_parameters

SAMPLE = 200_000_000  # ns


def stream(count: int) -> list[PoseSample]:
    return [PoseSample(SAMPLE * (k + 1), (float(k), -float(k), 0.01 * k)) for k in range(count)]


def relayed(count: int, **values: Any) -> list[list[PoseSample]]:
    named = {name.replace("__", "."): value for name, value in values.items()}
    disturber = Disturber(with_parameters(DisturberSettings(), named))
    return [disturber.step(sample) for sample in stream(count)]


def test_without_a_fault_every_message_goes_through_as_it_came() -> None:
    assert relayed(20) == [[sample] for sample in stream(20)]


@pytest.mark.parametrize("share", [0.01, 0.1, 0.5])
def test_loss_is_the_share_asked_for(share: float) -> None:
    lost = sum(not sent for sent in relayed(20_000, loss=share))
    # Five standard deviations of a binomial count.
    assert abs(lost - 20_000 * share) < 5.0 * math.sqrt(20_000 * share * (1.0 - share))


def test_equal_seeds_hit_the_same_messages_whatever_else_is_on() -> None:
    alone = [bool(sent) for sent in relayed(500, seed=3, loss=0.3)]
    assert alone == [bool(sent) for sent in relayed(500, seed=3, loss=0.3, duplicate=0.5, not_finite=0.5)]
    assert alone != [bool(sent) for sent in relayed(500, seed=4, loss=0.3)]


def test_delay_sends_each_message_when_one_so_much_later_comes() -> None:
    came = stream(10)
    assert relayed(10, delay=0.6) == [[], [], [], *([sample] for sample in came[:7])]


def test_duplicates_follow_at_once() -> None:
    assert relayed(5, duplicate=1.0) == [[sample, sample] for sample in stream(5)]


def test_a_message_is_overtaken_by_the_next() -> None:
    a, b, c, d = stream(4)
    assert relayed(4, reorder=1.0) == [[], [b, a], [], [d, c]]


def test_a_jump_moves_all_and_turns_the_heading() -> None:
    (sent,) = relayed(1, jump__north=10.0, jump__heading=1.0)[0]
    assert sent.position == (10.0, 0.0, 1.0)
    assert sent.stamp == SAMPLE


def test_a_frozen_value_has_stamps_that_go_on_and_a_frozen_message_has_not() -> None:
    for how, stamps in (("value", [SAMPLE, 2 * SAMPLE, 3 * SAMPLE]), ("message", [SAMPLE] * 3)):
        sent = [one for many in relayed(3, freeze=how) for one in many]
        assert [one.position for one in sent] == [(0.0, 0.0, 0.0)] * 3
        assert [one.stamp for one in sent] == stamps


def test_not_finite_time_offset_and_the_other_cover() -> None:
    (odd,) = relayed(1, not_finite=1.0)[0]
    assert all(map(math.isnan, odd.position))
    assert relayed(3, time_offset=-0.4)[2][0].stamp == SAMPLE
    assert relayed(1, time_offset=-5.0)[0][0].stamp == 0  # there is none before
    assert relayed(1, other_cover=True)[0][0].other_cover


def test_faults_change_while_messages_come_and_what_was_held_back_is_sent() -> None:
    disturber = Disturber(with_parameters(DisturberSettings(), {"delay": 0.4}))
    a, b, c = stream(3)
    assert [disturber.step(a), disturber.step(b)] == [[], []]
    assert disturber.held == 2
    disturber.apply(DisturberSettings())
    # In order: the new one waits for those before it.
    assert disturber.step(c) == [a]
    assert (disturber.counts.received, disturber.counts.sent, disturber.held) == (3, 1, 2)


@pytest.mark.parametrize(("name", "value"), [("loss", 1.1), ("delay", -1.0), ("freeze", "maybe"), ("jump.up", 1.0)])
def test_settings_out_of_range_are_refused(name: str, value: object) -> None:
    with pytest.raises(InputError, match=name.split(".")[0]):
        with_parameters(DisturberSettings(), {name: value})
