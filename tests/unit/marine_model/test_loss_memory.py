"""What a propeller has lost counts at once and is forgotten slowly, [Ruth] (5.16)-(5.17)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model.errors import InputError
from marine_model.loss_memory import LossMemory


def test_it_falls_at_once_and_rises_at_the_rate() -> None:
    memory = LossMemory(2, rate=0.5)
    assert memory.step([True, False], [0.3, 0.3], 0.1).tolist() == [0.3, 1.0]
    # No longer ventilating: 0.05 a step of 0.1 s, until all is forgotten.
    rising = [memory.step([False, False], [1.0, 1.0], 0.1)[0] for _ in range(20)]
    np.testing.assert_allclose(rising, np.minimum(0.3 + 0.05 * np.arange(1, 21), 1.0), rtol=1e-12)


def test_it_falls_again_while_it_rises() -> None:
    memory = LossMemory(1, rate=1.0)
    memory.step([True], [0.2], 0.1)
    assert memory.step([True], [0.6], 0.1)[0] == pytest.approx(0.3)
    assert memory.step([True], [0.1], 0.1)[0] == pytest.approx(0.1)


@given(
    st.lists(
        st.tuples(st.booleans(), st.floats(0.0, 1.5), st.floats(0.01, 2.0)),
        min_size=1,
        max_size=30,
    ),
    st.floats(0.01, 10.0),
)
def test_it_is_never_above_the_loss_now_and_never_rises_faster(
    steps: list[tuple[bool, float, float]], rate: float
) -> None:
    memory = LossMemory(1, rate)
    before = 1.0
    for ventilating, beta, dt in steps:
        after = float(memory.step([ventilating], [beta], dt)[0])
        assert after <= (min(beta, 1.0) if ventilating else 1.0)
        assert after <= before + rate * dt + 1e-12  # rounding of one addition
        before = after


def test_wrong_numbers_are_refused_and_change_nothing() -> None:
    memory = LossMemory(2, rate=1.0)
    memory.step([True, True], [0.5, 0.6], 0.1)
    for flags, beta, dt in (
        ([True], [0.5, 0.5], 0.1),
        ([True, True], [np.nan, 0.5], 0.1),
        ([True, True], [0.5, 0.5], 0.0),
    ):
        with pytest.raises(InputError):
            memory.step(flags, beta, dt)
    assert memory.value.tolist() == [0.5, 0.6]
    with pytest.raises(InputError, match="rate: expected"):
        LossMemory(1, 0.0)
