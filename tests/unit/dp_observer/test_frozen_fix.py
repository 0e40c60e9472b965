"""A position reference that has stopped."""

from __future__ import annotations

import numpy as np
import pytest

from dp_observer.frozen_fix import FrozenFix
from dp_observer.settings import ObserverSettings
from marine_model import load_vessel

NOISY = load_vessel("cybership3")


def test_counts_fixes_that_equal_the_one_before() -> None:
    frozen, settings = FrozenFix(NOISY), ObserverSettings(frozen_count=3)
    found = []
    for north in (1.0, 1.0, 1.0, 1.0, 1.0, np.nextafter(1.0, 2.0), 1.0):
        frozen.note(np.array([north, 2.0, 0.1]))
        found.append((frozen.count, frozen.is_frozen(settings)))
    assert found == [(0, False), (1, False), (2, False), (3, True), (4, True), (0, False), (0, False)]


@pytest.mark.parametrize(("noise", "count"), [(0.0, 3), (0.001, 0)])
def test_a_vessel_at_rest_without_noise_is_no_fault_and_zero_is_never(noise: float, count: int) -> None:
    quiet = NOISY.measurement.model_copy(update={"position_noise": noise, "heading_noise": 0.0})
    frozen = FrozenFix(NOISY.model_copy(update={"measurement": quiet}))
    for _ in range(10):
        frozen.note(np.zeros(3))
    assert frozen.count == 9
    assert not frozen.is_frozen(ObserverSettings(frozen_count=count))
