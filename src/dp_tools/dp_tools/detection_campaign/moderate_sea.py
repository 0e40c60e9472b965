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
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from vessel_sim.waves import Jonswap

_HEIGHT, _PERIOD, _PEAKEDNESS, _CURRENT = 2.0, 5.9, 3.3, 1.0  # m, s, -, m/s
_CUTOFF = 5.0  # of the peak frequency, as of ``IrregularSea``


def moderate_sea(vessel: Vessel) -> Jonswap:
    """Return the spectrum at the scale of ``vessel``."""
    return Jonswap(_HEIGHT / vessel.scale, _PERIOD / math.sqrt(vessel.scale), _PEAKEDNESS)


def current_speed(vessel: Vessel) -> float:
    """Return the current at the scale of ``vessel``, m/s."""
    return _CURRENT / math.sqrt(vessel.scale)


def orbital_motion(vessel: Vessel) -> tuple[FloatArray, FloatArray]:
    """Return standard deviation (m/s) and zero-crossing period (s) of the orbital velocity at the shafts, (n,) each.

    From the moments of S(omega) omega^2 exp(-2 omega^2 z / g) at the depth z of the shaft.
    """
    spectrum = moderate_sea(vessel)
    depths = vessel.shaft_depth.tolist()
    variance = np.array([_moment(spectrum, 2, depth) for depth in depths])
    acceleration = np.array([_moment(spectrum, 4, depth) for depth in depths])
    return np.sqrt(variance), 2.0 * math.pi * np.sqrt(variance / acceleration)


def least_shaft_speed(vessel: Vessel, torque_slope: FloatArray, on: float, noise: float, interval: float) -> FloatArray:
    """Return the n_min (Hz) above which this sea raises one false alarm in ``interval``, shape (n,).

    beta_Q = 1 - (B + C x) / n + noise, with B = |a_Q / K_Q0| V_c / D, C the same with sigma_u in the place of the
    current, and x Gaussian. Their sum goes below ``on`` once in ``interval`` where a = sqrt(2 ln(interval / T_z))
    standard deviations are between, [Rice 1944]:

        (m - B / n)^2 = a^2 ((C / n)^2 + noise^2),      m = 1 - on,

    which is quadratic in 1/n. At a shaft that always turns at n_min; the faster it turns, the rarer they are.

    Parameters
    ----------
    vessel
        Scale, depths of the shafts and diameters.
    torque_slope
        a_Q / K_Q0, shape (n,).
    on
        Threshold of (5.14).
    noise
        Standard deviation of beta_Q from noise of the sensors.
    interval
        s.

    Raises
    ------
    InputError
        If the noise alone raises more false alarms.
    """
    sigma, period = orbital_motion(vessel)
    a2 = 2.0 * np.log(np.maximum(1.0, interval / period))
    margin = 1.0 - on
    rest = margin**2 - a2 * noise**2
    if np.any(rest <= 0.0):
        raise InputError(f"noise: expected less than {margin / math.sqrt(a2.max()):.3g} of beta_Q, found {noise}")
    factor = np.abs(torque_slope) / np.array([model.diameter for model in vessel.propeller_models])
    mean, swing = factor * current_speed(vessel), factor * sigma
    square = (margin * mean) ** 2 - (mean**2 - a2 * swing**2) * rest
    return np.asarray((margin * mean + np.sqrt(square)) / rest)


def _moment(spectrum: Jonswap, power: int, depth: float) -> float:
    """Return the integral of S omega^power exp(-2 k depth)."""
    peak = spectrum.peak_frequency

    def integrand(omega: float) -> float:
        return float(spectrum.density(omega)) * omega**power * math.exp(-2.0 * omega**2 / GRAVITY * depth)

    # The width of the peak jumps at it.
    return float(sum(quad(integrand, a * peak, b * peak)[0] for a, b in ((0.1, 1.0), (1.0, 2.0), (2.0, _CUTOFF))))
