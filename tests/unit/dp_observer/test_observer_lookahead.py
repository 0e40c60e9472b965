"""Estimates ahead of fixes that are late: kept if the fix is later still, taken back if it comes."""

from __future__ import annotations

import numpy as np
import pytest

from dp_observer import Observer, ObserverEstimate, ObserverInputs, ObserverSettings, ObserverStatus
from dp_observer.lookahead import Lookahead
from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray

VESSEL = load_vessel("cybership3")
SAMPLE = 200_000_000  # ns
FORCE = np.array([1.0, -0.5, 0.1])


def place(k: float) -> FloatArray:
    return np.array([0.01 * k, 1.0, 0.5])


def start(samples: int = 50) -> tuple[Lookahead, Observer]:
    """A lookahead, and a plain observer that has seen the same."""
    lookahead, plain = Lookahead(Observer(VESSEL, ObserverSettings()), SAMPLE), Observer(VESSEL, ObserverSettings())
    for k in range(samples):
        inputs = ObserverInputs(place(k), FORCE)
        same(lookahead.measure(inputs, k * SAMPLE), plain.step(inputs, 0.2))
    return lookahead, plain


def same(a: ObserverEstimate, b: ObserverEstimate) -> None:
    for name in ("position", "velocity", "bias", "wave_frequency_position", "innovation"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert (a.status, a.valid, a.time_since_measurement) == (b.status, b.valid, b.time_since_measurement)


def test_nothing_ahead_of_the_first_message() -> None:
    lookahead = Lookahead(Observer(VESSEL, ObserverSettings()), SAMPLE)
    assert lookahead.run_ahead(ObserverInputs(None, FORCE)) is None
    assert lookahead.stamp is None


def test_running_ahead_is_dead_reckoning() -> None:
    lookahead, plain = start()
    for k in range(50, 53):
        found = lookahead.run_ahead(ObserverInputs(None, FORCE * k))
        assert found is not None
        estimate, stamp = found
        assert stamp == lookahead.stamp == k * SAMPLE
        assert estimate.status is ObserverStatus.DEAD_RECKONING
        same(estimate, plain.step(ObserverInputs(None, FORCE * k), 0.2))


def test_a_fix_after_the_time_run_ahead_keeps_it() -> None:
    lookahead, plain = start()
    for k in (50, 51):
        lookahead.run_ahead(ObserverInputs(None, FORCE * k))
        plain.step(ObserverInputs(None, FORCE * k), 0.2)
    inputs = ObserverInputs(place(52), FORCE)
    same(lookahead.measure(inputs, 52 * SAMPLE), plain.step(inputs, 0.2))


def test_a_fix_within_the_time_run_ahead_is_used_as_if_nothing_had_been() -> None:
    lookahead, plain = start()
    for _ in range(4):
        lookahead.run_ahead(ObserverInputs(None, FORCE))
    for k in (50, 51, 52):
        inputs = ObserverInputs(place(k), FORCE)
        same(lookahead.measure(inputs, k * SAMPLE), plain.step(inputs, 0.2))
        assert lookahead.stamp == k * SAMPLE


def test_bad_input_leaves_everything_as_it_was() -> None:
    lookahead, plain = start()
    with pytest.raises(InputError):
        lookahead.measure(ObserverInputs(np.array([np.nan, 0.0, 0.0]), FORCE), 50 * SAMPLE)
    inputs = ObserverInputs(place(50), FORCE)
    same(lookahead.measure(inputs, 50 * SAMPLE), plain.step(inputs, 0.2))


def test_new_settings_reach_both() -> None:
    lookahead, _ = start()
    assert len(lookahead.observers()) == 1
    lookahead.run_ahead(ObserverInputs(None, FORCE))
    assert len(lookahead.observers()) == 2
