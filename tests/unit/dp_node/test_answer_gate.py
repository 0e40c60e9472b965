import pytest
from hypothesis import given
from hypothesis import strategies as st

from dp_node import AnswerGate
from marine_model.errors import InputError


def test_an_open_gate_lets_every_action_through_at_once() -> None:
    gate, done = AnswerGate(synchronous=False), []
    for stamp in (1, 2, 3):
        gate.submit(stamp, lambda stamp=stamp: done.append(stamp))
    assert done == [1, 2, 3]


def test_the_second_action_waits_for_the_answer_to_the_first() -> None:
    gate, done = AnswerGate(synchronous=True), []
    gate.submit(10, lambda: done.append(10))
    gate.submit(20, lambda: done.append(20))
    assert done == [10]
    assert gate.held == 1
    gate.answer(10)
    assert done == [10, 20]
    assert gate.held == 0


@pytest.mark.parametrize("early", [True, False])
def test_an_answer_may_come_before_or_after_the_next_action(early: bool) -> None:
    gate, done = AnswerGate(synchronous=True), []
    gate.submit(10, lambda: done.append(10))
    if early:
        gate.answer(10)
    gate.submit(20, lambda: done.append(20))
    if not early:
        gate.answer(10)
    assert done == [10, 20]


@given(st.permutations(["s1", "s2", "s3", "a1", "a2", "a3"]))
def test_actions_keep_their_order_however_topics_interleave(order: list[str]) -> None:
    # Each topic keeps its own order; only the mix of the two is free.
    submits, answers = iter((1, 2, 3)), iter((1, 2, 3))
    gate, log = AnswerGate(synchronous=True), []
    for item in order:
        if item[0] == "s":
            stamp = next(submits)
            gate.submit(stamp, lambda stamp=stamp: log.append(("act", stamp)))
        else:
            stamp = next(answers)
            gate.answer(stamp)
            log.append(("answer", stamp))
    acts = [stamp for kind, stamp in log if kind == "act"]
    assert acts == [1, 2, 3]


def test_an_answer_from_the_future_opens_nothing() -> None:
    gate, done = AnswerGate(synchronous=True), []
    gate.submit(10, lambda: done.append(10))
    gate.answer(10**18)
    gate.submit(20, lambda: done.append(20))
    assert done == [10]
    gate.answer(10)
    assert done == [10, 20]


def test_what_waits_is_bounded_and_the_oldest_keep_their_turn() -> None:
    gate, done = AnswerGate(synchronous=True), []
    for stamp in range(65):
        gate.submit(stamp, lambda stamp=stamp: done.append(stamp))
    with pytest.raises(InputError, match=r"expected an answer to the sample at 0\.000 s, found none while 64 samples"):
        gate.submit(65, lambda: done.append(65))
    assert gate.held == 64
    for stamp in range(65):
        gate.answer(stamp)
    assert done == list(range(65))
