"""Signals worked out from those that were recorded."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dp_tools.run_data import VERTICAL as VERTICAL_SERIES
from dp_tools.run_data import RunData, Series
from marine_model import Vessel
from marine_model.axes import HORIZONTAL, VERTICAL, axis_indices
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
    """Return the generalized force from measured shaft speed and azimuth, tau_RAW of [Ruth] 4.5.2.

    Shape (k, 3), surge, sway, yaw; of a submerged vehicle heave, roll and pitch are in :func:`measured_vertical_force`.
    """
    thrust = measured_thrust(run, vessel)
    azimuth = run["azimuth"].at(thrust.t)
    x = thrust.values * np.cos(azimuth)
    y = thrust.values * np.sin(azimuth)
    if vessel.is_submerged:
        return Series(thrust.t, _six(vessel, x, y)[:, axis_indices(HORIZONTAL)])
    moment = vessel.lever_x * y - vessel.lever_y * x
    return Series(thrust.t, np.column_stack([x.sum(axis=1), y.sum(axis=1), moment.sum(axis=1)]))


def measured_vertical_force(run: RunData, vessel: Vessel) -> Series:
    """Return the same along heave, roll and pitch, shape (k, 3)."""
    thrust = measured_thrust(run, vessel)
    azimuth = run["azimuth"].at(thrust.t)
    six = _six(vessel, thrust.values * np.cos(azimuth), thrust.values * np.sin(azimuth))
    return Series(thrust.t, six[:, axis_indices(VERTICAL)])


def _six(vessel: Vessel, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the generalized force in six degrees of freedom, shape (k, 6), of thrusts along n_1 and n_2, (k, n)."""
    columns = vessel.columns6
    return np.asarray(x @ columns[:, :, 0] + y @ columns[:, :, 1])


def position_error(run: RunData, of: str) -> Series:
    """Return position minus reference, shape (k, 3): m north, m east, rad of heading; or m of depth, rad, rad.

    Parameters
    ----------
    run
        The run.
    of
        Name of the series: estimate_position or truth_position; vertical_estimate or vertical_truth for depth, roll
        and pitch of a submerged vehicle.
    """
    position = run[of]
    reference = "vertical_reference" if of in VERTICAL_SERIES else "reference_position"
    error = position.values - run[reference].at(position.t)
    error[:, 2] = wrap_angles(error[:, 2])
    return Series(position.t, error)


def runs_of(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first and one past the last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flags, [False])).astype(np.int8)))
    return [(int(first), int(after)) for first, after in edges.reshape(-1, 2)]


def unwrapped_degrees(heading: FloatArray) -> FloatArray:
    """Return angles (rad) as degrees without jumps of a turn; NaN is left where it is."""
    degrees = np.full(heading.shape, math.nan)
    known = np.isfinite(heading)
    degrees[known] = np.degrees(np.unwrap(heading[known]))
    return degrees


def averaged(series: Series, interval: float) -> Series:
    """Return the means over successive intervals (s), each at the time of its first sample; a last part is left out."""
    if len(series.t) < 2:
        return series
    count = max(1, round(interval / float(series.t[1] - series.t[0])))
    whole = len(series.t) // count * count
    means = series.values[:whole].reshape(-1, count, series.values.shape[1]).mean(axis=1)
    return Series(series.t[:whole:count], means)


def low_frequency_truth(run: RunData, vessel: Vessel) -> Series:
    """Return the true position without wave motion, through a filter that needs the future and so has no delay.

    A Gaussian weight of 2.8 / omega_0 leaves exp(-2.8^2 / 2) = 2 % at the observer's wave frequency omega_0 and 96 % at
    a tenth of it. It stands in the report only, as something to hold the observer against.
    """
    from scipy.ndimage import gaussian_filter1d  # here: its import is slow

    truth = run["truth_position"]
    if len(truth.t) < 2:
        return truth
    width = 2.8 / min(vessel.observer.wave_frequency) / float(truth.t[1] - truth.t[0])
    position = truth.values.copy()
    position[:, 2] = np.unwrap(position[:, 2])
    return Series(truth.t, gaussian_filter1d(position, width, axis=0, mode="nearest"))
