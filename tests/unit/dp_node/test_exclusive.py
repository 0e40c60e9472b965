"""Publishers of one topic, told apart by the numbers that the middleware gives their messages."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dp_node.exclusive import ExclusiveInput, Peer

SECOND = 10**9
PATIENCE = SECOND
TENTH = SECOND // 10


@dataclass
class Talker:
    """A publisher: numbers its messages from 1."""

    peer: Peer
    number: int = 0


@dataclass
class Topic:
    """A topic with its reader; ``ghosts`` are publishers that were killed and whose lease runs."""

    talkers: list[Talker] = field(default_factory=list)
    ghosts: list[Talker] = field(default_factory=list)
    now: int = 0
    made: int = 0

    def __post_init__(self) -> None:
        self.guard = ExclusiveInput(lambda: len(self._peers()), self._peers, PATIENCE)

    def _peers(self) -> list[Peer]:
        return [talker.peer for talker in (*self.talkers, *self.ghosts)]

    def join(self, node: str, sent: int = 0) -> Talker:
        self.made += 1
        talker = Talker(Peer((self.made,), node), sent)
        self.talkers.append(talker)
        return talker

    def kill(self, talker: Talker) -> None:
        self.talkers.remove(talker)
        self.ghosts.append(talker)

    def send(self, talker: Talker, count: int = 1, interval: int = TENTH) -> list[bool]:
        passed = []
        for _ in range(count):
            talker.number += 1
            passed.append(self.guard.passes(talker.number, self.now))
            self.now += interval
        return passed


def both(topic: Topic, first: Talker, per: int, second: Talker, rounds: int) -> tuple[int, int]:
    """Send ``rounds`` of ``first`` with ``per`` of ``second`` between each two; return how many of each passed."""
    passed = [0, 0]
    for _ in range(rounds):
        passed[0] += sum(topic.send(first, interval=0))
        for _ in range(per):
            topic.now += TENTH // (per + 1)
            passed[1] += sum(topic.send(second, interval=0))
        topic.now += TENTH // (per + 1)
    return passed[0], passed[1]


def test_who_is_alone_always_passes_and_so_does_who_comes_after() -> None:
    topic = Topic()
    first = topic.join("allocator")
    assert all(topic.send(first, 50))
    topic.talkers.remove(first)
    assert all(topic.send(topic.join("other"), 50))
    assert topic.guard.refused == 0


def test_messages_that_were_lost_on_the_way_are_nothing_to_who_is_alone() -> None:
    topic = Topic()
    first = topic.join("allocator")
    topic.send(first, 5)
    first.number += 7
    assert all(topic.send(first, 5))


def test_every_message_of_a_newcomer_is_refused_and_none_of_the_established_one() -> None:
    topic = Topic()
    first = topic.join("allocator")
    assert all(topic.send(first, 20))
    assert both(topic, first, 1, topic.join("intruder"), 200) == (200, 0)
    assert topic.guard.refused == 200
    assert topic.guard.established == "allocator"
    assert topic.guard.intruders() == ["intruder"]


@pytest.mark.parametrize("per", [3, 10, 100])
def test_a_faster_newcomer_does_not_slip_in_where_its_numbers_overtake(per: int) -> None:
    topic = Topic()
    first, rounds = topic.join("allocator"), 100
    topic.send(first, 30)
    intruder = topic.join("intruder")
    passed, slipped = both(topic, first, per, intruder, rounds)
    assert intruder.number > first.number + 10, "they crossed"
    assert slipped == 0
    # While the numbers cross, three samples of one in three of the other at most.
    assert passed >= rounds - 4
    assert not topic.guard.undistinguished


def test_two_that_start_together_at_the_same_rate_are_both_refused_until_one_goes() -> None:
    topic = Topic()
    first, second = topic.join("allocator"), topic.join("allocator")
    passed = both(topic, first, 1, second, 30)
    assert passed == (1, 0)
    assert topic.guard.undistinguished
    topic.talkers.remove(first)
    assert all(topic.send(second, 5))
    assert not topic.guard.undistinguished


def test_the_newcomer_passes_once_the_established_one_has_left() -> None:
    topic = Topic()
    first, intruder = topic.join("allocator"), topic.join("intruder")
    topic.send(first, 20)
    assert not any(topic.send(intruder, 5))
    topic.talkers.remove(first)
    assert all(topic.send(intruder, 5))


def test_a_node_that_was_killed_is_followed_by_its_like_before_its_lease_ends() -> None:
    topic = Topic()
    first = topic.join("allocator")
    topic.send(first, 20)
    topic.kill(first)
    again = topic.join("allocator")
    passed = topic.send(again, 30)
    assert passed.index(True) == 10, "after one second of silence"
    assert all(passed[10:])


def test_a_stranger_does_not_step_in_while_the_established_one_is_only_silent() -> None:
    topic = Topic()
    first, intruder = topic.join("allocator"), topic.join("intruder")
    topic.send(first, 20)
    assert not any(topic.send(intruder, 100))
    assert all(topic.send(first, 5))


def test_of_several_strangers_one_follows_when_the_established_one_is_gone() -> None:
    topic = Topic()
    first, second, third = topic.join("allocator"), topic.join("intruder", 500), topic.join("peer", 900)
    topic.send(first, 20)
    both(topic, second, 1, third, 5)
    topic.talkers.remove(first)
    passed = both(topic, second, 1, third, 50)
    assert passed[0] == 0 or passed[1] == 0, "one of them alone"
    assert max(passed) >= 38, "after the silence"


def test_a_middleware_without_numbers_tells_nothing_apart() -> None:
    guard = ExclusiveInput(lambda: 2, lambda: [Peer((1,), "a"), Peer((2,), "b")], PATIENCE)
    assert all(guard.passes(2**64 - 1, i * TENTH) for i in range(10))
    assert guard.refused == 0


@given(st.lists(st.tuples(st.integers(0, 2**64 - 1), st.integers(0, 3 * SECOND)), max_size=80), st.integers(1, 3))
def test_whatever_numbers_come_the_guard_answers_and_stays_small(messages: list[tuple[int, int]], peers: int) -> None:
    known = [Peer((i,), f"node{i}") for i in range(peers)]
    guard = ExclusiveInput(lambda: peers, lambda: known, PATIENCE)
    passed = [guard.passes(number, now) for number, now in messages]
    assert guard.refused == passed.count(False)
    assert len(guard._rivals) <= 17
    if peers == 1:
        assert all(passed)
