"""Confidence intervals of statistics of one autocorrelated signal.

A window is cut into batches of equal length. Each batch in turn is left out and the statistic computed from the
others; the spread of these values is the jackknife's standard error (Quenouille, Tukey), and Student's t with one
degree of freedom fewer than batches gives the interval. Batches much longer than the signal's memory are nearly
independent, which is what makes this right for autocorrelated samples (method of batch means). For a mean it is the
batch-means interval itself. Nothing is drawn at random.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np

from marine_model.errors import InputError
from marine_model.guards import FloatArray

BATCHES = 10
CONFIDENCE = 0.95

Statistic = Callable[..., float]


def batch_jackknife(
    statistic: Statistic,
    samples: Sequence[FloatArray],
    batches: int = BATCHES,
    confidence: float = CONFIDENCE,
) -> tuple[float, float]:
    """Return (low, high) of ``statistic(*samples)``.

    Parameters
    ----------
    statistic
        Smooth function of one or more independent windows, each of shape (k,) or (k, m): mean, standard deviation, root
        mean square, ratio of means. Not for extremes, whose jackknife is not consistent.
    samples
        The windows.
    batches
        Number of batches a window.
    confidence
        Chance that the interval holds the true value.

    Raises
    ------
    InputError
        If a window has fewer than two samples a batch.
    """
    from scipy.special import stdtrit  # here: its import is slow

    for window in samples:
        if len(window) < 2 * batches:
            raise InputError(f"window: expected at least {2 * batches} samples, found {len(window)}")
    value = statistic(*samples)
    variance = 0.0
    for i, window in enumerate(samples):
        edges = np.linspace(0, len(window), batches + 1).round().astype(int)
        left_out = np.array(
            [
                statistic(
                    *samples[:i],
                    np.concatenate([window[:first], window[last:]]),
                    *samples[i + 1 :],
                )
                for first, last in itertools.pairwise(edges)
            ]
        )
        variance += (batches - 1) / batches * float(((left_out - left_out.mean()) ** 2).sum())
    half = float(stdtrit(batches - 1, 0.5 + 0.5 * confidence)) * math.sqrt(variance)
    return value - half, value + half
