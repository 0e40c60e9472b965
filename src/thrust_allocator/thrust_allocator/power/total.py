"""Total power: prediction, correction by measurement, and equal phase-back, [Ruth] (4.43)-(4.49)."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray

# Range that the correction of (4.44) is held to. A plant that draws less than half or more than twice of what its
# propellers should is measured wrongly, or has changed since the sample before; neither may open or shut the limit.
CORRECTION_LOWEST = 0.5
CORRECTION_HIGHEST = 2.0
# Least power of the step before, as a share of the vessel's full power, from which a ratio says anything: below it
# friction and the noise of the measurement are as large as the power of the propellers.
CORRECTION_LEAST_SHARE = 0.01


class CorrectionSource(IntEnum):
    """Where a correction factor comes from."""

    MEASURED = 0
    CLAMPED = 1  # measured, and brought into its range
    NO_MEASUREMENT = 2  # missing, not finite, below 0 or too old: 1
    NO_REFERENCE = 3  # next to no power was commanded the step before: 1


class Correction(NamedTuple):
    """Factor on predicted power, and why."""

    factor: float
    source: CorrectionSource


@compiled
def total_power(coefficient: FloatArray, thrust: FloatArray) -> float:
    """Return sum_j m_j |T_j|^(3/2), W: [Ruth] (4.43), which prints T without the absolute value.

    Parameters
    ----------
    coefficient
        m, shape (n,), W / N^(3/2): ``vessel.propellers.power_per_thrust_3_2``.
    thrust
        Shape (n,), N.
    """
    total = 0.0
    for j in range(thrust.size):
        size = abs(thrust[j])
        total += coefficient[j] * size * math.sqrt(size)
    return total


def full_power(coefficient: FloatArray, thrust_min: FloatArray, thrust_max: FloatArray) -> float:
    """Return the power with every thruster at the larger of its limits, W."""
    return total_power(coefficient, np.maximum(thrust_max, -thrust_min))


def measured_correction(
    measured: float | None, commanded_before: float, age: float, longest_age: float, full: float
) -> Correction:
    """Return P_meas,k-1 / P_c,k-1 of [Ruth] (4.44) within its range, or 1 when it cannot be told.

    Parameters
    ----------
    measured
        Measured power of all thrusters, W; None when there is none.
    commanded_before
        P_c,k-1: power of the commands of the step before, after all limits, W, by :func:`total_power`.
    age, longest_age
        Age of the measurement and the largest one at which it is used, s.
    full
        :func:`full_power` of the vessel, W.
    """
    if measured is None or not math.isfinite(measured) or measured < 0.0 or not 0.0 <= age <= longest_age:
        return Correction(1.0, CorrectionSource.NO_MEASUREMENT)
    if not math.isfinite(commanded_before) or commanded_before < CORRECTION_LEAST_SHARE * full or full <= 0.0:
        return Correction(1.0, CorrectionSource.NO_REFERENCE)
    ratio = measured / commanded_before
    factor = min(max(ratio, CORRECTION_LOWEST), CORRECTION_HIGHEST)
    return Correction(factor, CorrectionSource.MEASURED if factor == ratio else CorrectionSource.CLAMPED)


def phase_back_factor(available: float, demanded: float) -> float:
    """Return u in [0, 1] of [Ruth] (4.49): all thrusts times u take ``available`` in place of ``demanded`` power (W).

    ``demanded`` is the corrected power P_T,k of (4.44), so that P_AV / P_Td P_c,k-1 / P_meas,k-1 is their ratio.
    ``available`` may be infinite; below 0 counts as 0.
    """
    if demanded <= available:
        return 1.0
    return math.pow(max(available / demanded, 0.0), 2.0 / 3.0)


@compiled
def phase_back(
    coefficient: FloatArray,
    member: FloatArray,
    thrust: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    available: float,
    out: FloatArray,
) -> float:
    """Scale thrusts back by one factor u until they take ``available`` power, as far as one step can.

    The thrust of thruster j becomes u T_j, but stays within its window of this step: where u T_j is less than the rate
    limit can reach, it goes as far as that, and the others make up for it. The powers then add up to
    sum_j m_j |T_j|^(3/2) max(u, c_j)^(3/2), where c_j is the share of T_j that the window holds on to, and u follows by
    fixing the thrusters with c_j > u one after the other: at most n rounds, exact. With no window in the way this is
    [Ruth] (4.49).

    Parameters
    ----------
    coefficient
        m, shape (n,), W / N^(3/2), times the correction of (4.44) where there is one.
    member
        Shape (n,): thrusters with 1 are scaled and counted, those with 0 are passed through.
    thrust
        Answer of this step, shape (n,), N, within the windows.
    lower, upper
        T_- and T_+ of this step, shape (n,), N.
    available
        W; infinite for no limit.
    out
        Scaled thrusts, shape (n,), N; may be ``thrust`` itself.

    Returns
    -------
    float
        u in [0, 1]; 0 when even the least that the windows allow takes ``available`` power or more.
    """
    n = thrust.size
    power = np.empty(n)
    held = np.empty(n)
    total, free = 0.0, 0.0
    for j in range(n):
        size = abs(thrust[j])
        power[j] = coefficient[j] * size * math.sqrt(size) if member[j] > 0.0 else 0.0
        held[j] = 0.0
        if thrust[j] > 0.0 and lower[j] > 0.0:
            held[j] = min(lower[j] / thrust[j], 1.0)
        elif thrust[j] < 0.0 and upper[j] < 0.0:
            held[j] = min(upper[j] / thrust[j], 1.0)
        total += power[j]
    u = 1.0
    if total > available:
        for _ in range(n + 1):
            free, rest = 0.0, available
            for j in range(n):
                if held[j] >= u:
                    rest -= power[j] * held[j] ** 1.5
                else:
                    free += power[j]
            if free <= 0.0:
                break
            lowered = (max(rest, 0.0) / free) ** (2.0 / 3.0)
            if lowered >= u:
                break
            u = lowered
        if free <= 0.0:
            u = 0.0
    for j in range(n):
        out[j] = thrust[j] * max(u, held[j]) if member[j] > 0.0 else thrust[j]
    return u
