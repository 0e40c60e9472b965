"""A moderate sea at the scale of a vessel, and the advance speed it gives the propellers.

The sea of [Ruth] 3.7, H_s = 2 m and T_p = 5.9 s with gamma = 3.3 and a current of 1 m/s at full scale, in the middle of
what the WMO calls moderate (1.25 m to 2.5 m), brought to the scale of the vessel by Froude's law.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad

from marine_model import Vessel
from marine_model.constants import GRAVITY
from marine_model.guards import FloatArray, positive_number
from vessel_sim.waves import Jonswap

_HEIGHT, _PERIOD, _PEAKEDNESS, _CURRENT = 2.0, 5.9, 3.3, 1.0  # m, s, -, m/s
_CUTOFF = 5.0  # of the peak frequency, as of ``IrregularSea``


def moderate_sea(vessel: Vessel) -> Jonswap:
    """Return the spectrum at the scale of ``vessel``."""
    return Jonswap(_HEIGHT / vessel.scale, _PERIOD / math.sqrt(vessel.scale), _PEAKEDNESS)


def current_speed(vessel: Vessel) -> float:
    """Return the current at the scale of ``vessel``, m/s."""
    return _CURRENT / math.sqrt(vessel.scale)


def largest_advance_speed(vessel: Vessel, interval: float) -> FloatArray:
    """Return the V_A (m/s) that a shaft meets once in ``interval`` (s) on average, shape (n,).

    Current and orbital velocity u at the depth z of the shaft, both along the propeller. u is Gaussian with the
    spectrum S(omega) omega^2 exp(-2 omega^2 z / g), so that it goes over v once in T_z exp(v^2 / (2 sigma_u^2)),
    [Rice 1944]: V_A = V_c + sigma_u sqrt(2 ln(interval / T_z)).

    Raises
    ------
    InputError
        If ``interval`` is not above 0.
    """
    positive_number("interval", interval)
    spectrum = moderate_sea(vessel)
    found = []
    for depth in vessel.shaft_depth.tolist():
        variance, acceleration = (_moment(spectrum, power, depth) for power in (2, 4))
        period = 2.0 * math.pi * math.sqrt(variance / acceleration)
        found.append(math.sqrt(2.0 * variance * math.log(max(1.0, interval / period))))
    return current_speed(vessel) + np.array(found)


def _moment(spectrum: Jonswap, power: int, depth: float) -> float:
    """Return the integral of S omega^power exp(-2 k depth)."""
    peak = spectrum.peak_frequency

    def integrand(omega: float) -> float:
        return float(spectrum.density(omega)) * omega**power * math.exp(-2.0 * omega**2 / GRAVITY * depth)

    # The width of the peak jumps at it.
    return float(sum(quad(integrand, a * peak, b * peak)[0] for a, b in ((0.1, 1.0), (1.0, 2.0), (2.0, _CUTOFF))))
