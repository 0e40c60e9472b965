"""Confidence intervals: against the closed form, and that they hold the truth as often as they say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dp_tools.interval import batch_jackknife
from marine_model.errors import InputError


def mean(x: np.ndarray) -> float:
    return float(x.mean())


def std(x: np.ndarray) -> float:
    return float(x.std())


def ratio(a: np.ndarray, b: np.ndarray) -> float:
    return float(b.mean() / a.mean()) - 1.0


def test_mean_of_ten_batches_is_the_batch_means_interval() -> None:
    # Batch means 0 ... 9: mean 4.5, standard error sqrt(82.5 / 9 / 10); Student's t(0.975, 9) = 2.262157.
    x = np.repeat(np.arange(10.0), 5)
    half = 2.262157 * math.sqrt(82.5 / 9.0 / 10.0)
    low, high = batch_jackknife(mean, [x])
    assert low == pytest.approx(4.5 - half, rel=1e-6)  # t has seven digits above
    assert high == pytest.approx(4.5 + half, rel=1e-6)


def test_constant_signal_has_no_width() -> None:
    low, high = batch_jackknife(mean, [np.full(100, 3.0)])
    assert low == high == 3.0


@given(scale=st.floats(0.1, 100.0), shift=st.floats(-100.0, 100.0))
@settings(max_examples=50, deadline=None)
def test_interval_of_a_mean_moves_and_scales_with_the_signal(scale: float, shift: float) -> None:
    x = np.sin(np.arange(200.0))
    low, high = batch_jackknife(mean, [x])
    moved = batch_jackknife(mean, [scale * x + shift])
    # Rounding only.
    assert moved == pytest.approx(
        (scale * low + shift, scale * high + shift), rel=1e-9, abs=1e-9 * (scale + abs(shift))
    )


def autoregressive(rng: np.random.Generator, runs: int, samples: int, memory: float) -> np.ndarray:
    """Unit variance, correlation exp(-k / memory), mean 5."""
    keep = math.exp(-1.0 / memory)
    x = np.empty((runs, samples))
    x[:, 0] = rng.normal(size=runs)
    noise = math.sqrt(1.0 - keep * keep) * rng.normal(size=(runs, samples))
    for k in range(1, samples):
        x[:, k] = keep * x[:, k - 1] + noise[:, k]
    return 5.0 + x


@pytest.mark.parametrize("statistic", [mean, std])
def test_interval_holds_the_truth_about_as_often_as_it_says(statistic: object) -> None:
    """500 samples with a memory of 5: batches of 50 are ten memories long, as in the runs that this serves."""
    truth = {mean: 5.0, std: 1.0}[statistic]  # type: ignore[index]
    runs = autoregressive(np.random.default_rng(3), runs=400, samples=500, memory=5.0)
    held = 0
    for x in runs:
        low, high = batch_jackknife(statistic, [x])
        held += low <= truth <= high
    # 400 trials of 0.95: standard deviation 0.011. Batches that remember their neighbours cost up to 0.05.
    assert 0.89 <= held / 400 <= 0.985


def test_ratio_of_two_windows_counts_the_scatter_of_both() -> None:
    rng = np.random.default_rng(5)
    quiet = 5.0 + 0.01 * rng.normal(size=500)
    noisy = 5.0 + rng.normal(size=500)
    width = {
        name: float(np.diff(batch_jackknife(ratio, windows))[0])
        for name, windows in {"one": [quiet, noisy], "other": [noisy, quiet], "both": [noisy, noisy[::-1]]}.items()
    }
    # The ratio is near 1, so that either window counts alike, and variances add.
    assert width["one"] == pytest.approx(width["other"], rel=0.1)
    assert width["both"] == pytest.approx(math.hypot(width["one"], width["other"]), rel=0.1)


def test_too_few_samples_are_refused() -> None:
    with pytest.raises(InputError, match="window: expected at least 20 samples, found 19"):
        batch_jackknife(mean, [np.zeros(19)])
