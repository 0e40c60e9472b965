"""Timing in turn: who is called with what, in which order."""

import gc

import numpy as np
import pytest

from benchmarks.blocks import Candidate, in_turn
from benchmarks.demands import Step, demand_in_waves, record
from marine_model import load_vessel
from thrust_allocator import AllocatorSettings

VESSEL = load_vessel("cybership3")
STEPS = record(VESSEL, AllocatorSettings(), demand_in_waves(VESSEL, 12, 1), 0.2)


def test_blocks_alternate_and_the_order_turns_round() -> None:
    order: list[tuple[str, int]] = []

    def candidate(name: str, share: float) -> Candidate:
        return Candidate(
            lambda step: next(i for i, one in enumerate(STEPS) if one is step),
            lambda place: order.append((name, place)),
            share,
        )

    calls = in_turn({"a": candidate("a", 1.0), "b": candidate("b", 0.5)}, STEPS, blocks=3)
    counted = order[6:]  # three calls each to warm up
    assert [name for name, _ in counted] == list("aaaabb" + "bbaaaa" + "aaaabb")
    assert calls["a"].places == list(range(12))
    assert calls["b"].places == [0, 1, 4, 5, 8, 9]
    # The first of four calls is cold; two are too few to leave one out.
    assert (len(calls["a"].times), len(calls["a"].cold), len(calls["b"].times)) == (9, 3, 6)
    assert min(calls["b"].times) > 0.0


def test_what_raises_is_kept_as_its_answer_and_the_rest_is_read() -> None:
    def call(step: Step) -> float:
        if step is STEPS[1]:
            raise ValueError("no")
        return float(step.tau[0])

    calls = in_turn({"a": Candidate(lambda step: step, call)}, STEPS, 1, read=lambda name, step, answer: (name, answer))
    answers = calls["a"].answers
    assert isinstance(answers[1], ValueError)
    assert answers[2] == ("a", float(STEPS[2].tau[0]))


@pytest.mark.parametrize("enabled", [True, False])
def test_no_garbage_is_collected_within_a_block_and_all_is_as_before(enabled: bool) -> None:
    seen: list[bool] = []
    was = gc.isenabled()
    try:
        (gc.enable if enabled else gc.disable)()
        in_turn({"a": Candidate(lambda step: step, lambda step: seen.append(gc.isenabled()))}, STEPS, 2)
        assert gc.isenabled() is enabled
    finally:
        (gc.enable if was else gc.disable)()
    assert not np.any(seen)
