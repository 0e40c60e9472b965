"""Numerical examples of the papers, to show beside ours where a vessel has the propulsion they are worked out for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from marine_model.guards import FloatArray

# By how much largest forces may differ from the printed ones: 332 N m are 329.7 by the paper's own angles.
_SAME = 0.01


@dataclass(frozen=True)
class PaperExample:
    """A demand that a paper works out.

    Attributes
    ----------
    source
        Where it stands.
    demand
        Surge, sway, yaw: N, N, N m.
    reduced
        What the paper makes of it; None where it has been printed for another demand.
    """

    source: str
    demand: tuple[float, float, float]
    reduced: tuple[float, float, float] | None


# [Garus-F] before (3.1), [Garus-N] (7).
_LARGEST = np.array([875.0, 485.0, 332.0])
_SKEWED = (
    PaperExample("[Garus-F] section 4", (700.0, -120.0, 30.0), (614.6, -105.4, 26.3)),
    # It computes with 30 N m what it says of 50.
    PaperExample("[Garus-N] section 4", (700.0, -120.0, 50.0), None),
)

# [Garus-A], numerical example: thrust, distance, bearing; reduced forces and angle.
_AZIMUTH_SQUARE = (250.0, 0.4, np.radians(30.0))
AZIMUTH_EXAMPLE = PaperExample("[Garus-A] numerical example", (700.0, -120.0, 50.0), (501.0, -85.9, 50.0))
AZIMUTH_ANGLE_DEGREES = 29.1
AZIMUTH_LIMIT = 750.0  # tau_1max, N: by it demands grow with the propellers
# Derived: within the asteroid of that example, and beyond the thrust there is at its angle.
AZIMUTH_COUNTEREXAMPLE = (100.0, 400.0)


def examples_for(axes: tuple[str, ...], limits: FloatArray) -> tuple[PaperExample, ...]:
    """Return the examples for thrusters that are skewed, if ``limits`` (m,) over ``axes`` are those of the papers."""
    fits = axes == ("surge", "sway", "yaw") and bool((np.abs(limits - _LARGEST) <= _SAME * _LARGEST).all())
    return _SKEWED if fits else ()


def is_azimuth_example(thrust: float, distance: float, bearing: float) -> bool:
    """Return whether four azimuth propellers are those of the example: N, m, rad."""
    return bool(np.allclose((thrust, distance, bearing), _AZIMUTH_SQUARE, rtol=_SAME))
