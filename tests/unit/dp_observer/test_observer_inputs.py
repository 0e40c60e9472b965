"""Bad input: refused with a reason, and nothing is lost."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from dp_observer import Observer, ObserverInputs, ObserverSettings
from marine_model import load_vessel
from marine_model.errors import DpError, InputError

VESSEL = load_vessel("cybership3")
SAMPLE = VESSEL.measurement.sample_time
GOOD = np.array([0.1, 0.2, 0.3])

CASES: list[tuple[dict[str, Any], str]] = [
    ({"position": [math.nan, 0.0, 0.0]}, "position: expected finite numbers, found [nan, 0.0, 0.0]"),
    ({"position": [0.0, math.inf, 0.0]}, "position: expected finite numbers, found [0.0, inf, 0.0]"),
    ({"position": [0.0, 0.0]}, "position: expected shape (3,), found (2,)"),
    ({"position": [[0.0, 0.0, 0.0]]}, "position: expected shape (3,), found (1, 3)"),
    ({"position": ["north", 0.0, 0.0]}, "position: expected 3 numbers, found ['north', 0.0, 0.0]"),
    ({"position": [1e9, 0.0, 0.0]}, "position: expected numbers within 1e+08, found [1000000000.0, 0.0, 0.0]"),
    ({"tau": [0.0, math.nan, 0.0]}, "tau: expected finite numbers, found [0.0, nan, 0.0]"),
    ({"tau": [0.0]}, "tau: expected shape (3,), found (1,)"),
    ({"tau": [0.0, 0.0, 1e300]}, "tau: expected numbers within 1e+12, found [0.0, 0.0, 1e+300]"),
    ({"dt": 0.0}, "dt: expected a number above 0, found 0.0"),
    ({"dt": -0.2}, "dt: expected a number above 0, found -0.2"),
    ({"dt": math.nan}, "dt: expected a finite number, found nan"),
    ({"dt": "soon"}, "dt: expected a number, found 'soon'"),
    ({"dt": 1e12}, "dt: expected at most 1e+10 s, found 1000000000000.0"),
]  # fmt: skip


@pytest.mark.parametrize(("bad", "message"), CASES)
def test_refused_with_the_reason_and_nothing_changed(bad: dict[str, Any], message: str) -> None:
    one, other = Observer(VESSEL, ObserverSettings()), Observer(VESSEL, ObserverSettings())
    for k in range(20):
        for observer in (one, other):
            observer.step(ObserverInputs(GOOD + 0.01 * np.sin(k), np.ones(3)), SAMPLE)
    inputs: Any = {"position": GOOD, "tau": np.zeros(3)} | bad
    with pytest.raises(InputError) as caught:
        one.step(ObserverInputs(inputs["position"], inputs["tau"]), inputs.get("dt", SAMPLE))
    assert str(caught.value) == message
    assert isinstance(caught.value, DpError)
    for _ in range(3):
        a, b = (o.step(ObserverInputs(GOOD, np.ones(3)), SAMPLE) for o in (one, other))
        for name in ("position", "velocity", "bias", "wave_frequency_position", "innovation"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_inputs_are_not_kept_or_changed() -> None:
    observer = Observer(VESSEL, ObserverSettings())
    position, tau = GOOD.copy(), np.ones(3)
    observer.step(ObserverInputs(position, tau), SAMPLE)
    first = observer.step(ObserverInputs(position, tau), SAMPLE)
    kept = first.position.copy()
    np.testing.assert_array_equal(position, GOOD)
    position[:] = 50.0  # the caller reuses its array
    observer.step(ObserverInputs(GOOD, tau), SAMPLE)
    np.testing.assert_array_equal(first.position, kept)


numbers = st.floats(allow_nan=True, allow_infinity=True)
fixes = st.one_of(
    st.none(),
    st.tuples(numbers, numbers, numbers),
    st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-9, 9)),
)


@given(
    steps=st.lists(
        st.tuples(fixes, st.tuples(numbers, numbers, numbers), st.floats(1e-6, 1e6)),
        min_size=1,
        max_size=30,
    )
)
@settings(max_examples=150, deadline=None)
def test_never_a_number_that_is_not_finite(
    steps: list[tuple[tuple[float, ...] | None, tuple[float, ...], float]],
) -> None:
    """Whatever comes in: an InputError or a finite estimate with a wrapped heading."""
    observer = Observer(VESSEL, ObserverSettings(innovation_limit=1000.0))
    for fix, tau, dt in steps:
        position = None if fix is None else np.array(fix)
        try:
            estimate = observer.step(ObserverInputs(position, np.array(tau)), dt)
        except InputError:
            continue
        for name in ("position", "velocity", "bias", "wave_frequency_position", "innovation"):
            assert np.isfinite(getattr(estimate, name)).all(), name
        assert -np.pi <= estimate.position[2] < np.pi
        assert estimate.time_since_measurement >= 0.0


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("dead_reckoning_limit", -1.0),
        ("dead_reckoning_limit", math.nan),
        ("innovation_limit", 0.0),
        ("heading_innovation_limit", 4.0),
        ("reacceptance_count", 0),
        ("reacceptance_count", 2.5),
        ("wave_frequncy", 1.0),
    ],
)
def test_bad_settings_are_refused_by_name(field: str, value: float) -> None:
    with pytest.raises(ValidationError, match=field):
        ObserverSettings.model_validate({field: value})
