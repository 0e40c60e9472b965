"""Signals worked out from those that were recorded."""

from __future__ import annotations

import math

import numpy as np

from dp_tools.run_data import RunData, Series
from marine_model import Vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray


def total_power(run: RunData) -> Series:
    """Return the developed power of all thrusters together, shape (k, 1), W."""
    power = run["power"]
    return Series(power.t, power.values.sum(axis=1, keepdims=True))


def measured_thrust(run: RunData, vessel: Vessel) -> Series:
    """Return thrust from measured shaft speed by (3.8) of [Ruth], T_RAW, shape (k, n), N."""
    speed = run["shaft_speed"]
    return Series(speed.t, vessel.propellers.thrust(speed.values))


def measured_force(run: RunData, vessel: Vessel) -> Series:
    """Return the generalized force from measured shaft speed and azimuth, tau_RAW of [Ruth] 4.5.2, shape (k, 3)."""
    thrust = measured_thrust(run, vessel)
    azimuth = run["azimuth"].at(thrust.t)
    x = thrust.values * np.cos(azimuth)
    y = thrust.values * np.sin(azimuth)
    moment = vessel.lever_x * y - vessel.lever_y * x
    return Series(thrust.t, np.column_stack([x.sum(axis=1), y.sum(axis=1), moment.sum(axis=1)]))


def position_error(run: RunData, of: str) -> Series:
    """Return position minus reference, shape (k, 3): m north, m east, rad of heading.

    Parameters
    ----------
    run
        The run.
    of
        Name of the series: estimate_position or truth_position.
    """
    position = run[of]
    error = position.values - run["reference_position"].at(position.t)
    error[:, 2] = wrap_angles(error[:, 2])
    return Series(position.t, error)


def unwrapped_degrees(heading: FloatArray) -> FloatArray:
    """Return angles (rad) as degrees without jumps of a turn; NaN is left where it is."""
    degrees = np.full(heading.shape, math.nan)
    known = np.isfinite(heading)
    degrees[known] = np.degrees(np.unwrap(heading[known]))
    return degrees
