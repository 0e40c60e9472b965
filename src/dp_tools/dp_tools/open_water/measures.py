"""What a trial measures of a case over a window: one function a kind of figure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from dp_tools.open_water.record import CaseRecord
from marine_model.guards import FloatArray

Kind = Literal[
    "corrected_mean_power",
    "mean_power",
    "power_max",
    "mean_thrust",
    "mean_thrust_over_demand",
    "thrust_std",
    "thrust_sensitivity_mean",
    "thrust_sensitivity_std",
    "shaft_speed_mean",
    "shaft_speed_max",
    "shaft_speed_std",
    "pitch_ratio_mean",
    "ventilated_share",
    "thrust_loss_mean",
    "thrust_loss_min",
]
KINDS: tuple[Kind, ...] = get_args(Kind)

# beta_T below which a propeller counts as ventilated in ``ventilated_share``: the higher of the two lines that the
# static map is fitted to, [Ruth] (2.40).
VENTILATED = 0.8


@dataclass(frozen=True)
class Measure:
    """One kind of figure."""

    title: str
    unit: str
    of: Callable[[CaseRecord], float]


def corrected_mean_power(motor_power: FloatArray, demanded: FloatArray, produced: FloatArray) -> float:
    """Return P_m,corr, W: mean power at the mean thrust that was asked for, [Ruth] (3.68).

    NaN where the mean thrust is 0 or has the other sign than the mean demand.

    Parameters
    ----------
    motor_power
        P_m = 2 pi n Q_m, W, (3.67).
    demanded, produced
        T_d and T, N.
    """
    ratio = _ratio(float(demanded.mean()), float(produced.mean()))
    return float(motor_power.mean()) * ratio**1.5 if ratio >= 0.0 else math.nan


def _ratio(value: float, base: float) -> float:
    return value / base if base else math.nan


def _sensitivity(case: CaseRecord) -> FloatArray:
    """St = T / T_d, [Ruth] (3.26), where thrust is asked for."""
    asked = case.thrust_demanded != 0.0
    return np.asarray(case.thrust[asked] / case.thrust_demanded[asked])


def _over(values: FloatArray, statistic: Callable[[FloatArray], np.floating | float]) -> float:
    return float(statistic(values)) if values.size else math.nan


MEASURES: dict[Kind, Measure] = {
    "corrected_mean_power": Measure(
        "corrected mean power", "W", lambda c: corrected_mean_power(c.power, c.thrust_demanded, c.thrust)
    ),
    "mean_power": Measure("mean power", "W", lambda c: float(c.power.mean())),
    "power_max": Measure("largest power", "W", lambda c: float(c.power.max())),
    "mean_thrust": Measure("mean thrust", "N", lambda c: float(c.thrust.mean())),
    "mean_thrust_over_demand": Measure(
        "mean thrust over mean demand", "1", lambda c: _ratio(float(c.thrust.mean()), float(c.thrust_demanded.mean()))
    ),
    "thrust_std": Measure("standard deviation of thrust", "N", lambda c: float(c.thrust.std())),
    "thrust_sensitivity_mean": Measure("mean thrust sensitivity", "1", lambda c: _over(_sensitivity(c), np.mean)),
    "thrust_sensitivity_std": Measure(
        "standard deviation of thrust sensitivity", "1", lambda c: _over(_sensitivity(c), np.std)
    ),
    "shaft_speed_mean": Measure("mean shaft speed", "Hz", lambda c: float(c.shaft_speed.mean())),
    "shaft_speed_max": Measure("largest shaft speed", "Hz", lambda c: float(c.shaft_speed.max())),
    "shaft_speed_std": Measure("standard deviation of shaft speed", "Hz", lambda c: float(c.shaft_speed.std())),
    "pitch_ratio_mean": Measure("mean pitch ratio", "1", lambda c: float(c.pitch_ratio.mean())),
    "ventilated_share": Measure(
        f"share of time with βT below {VENTILATED:g}", "1", lambda c: float((c.thrust_loss < VENTILATED).mean())
    ),
    "thrust_loss_mean": Measure("mean βT", "1", lambda c: float(c.thrust_loss.mean())),
    "thrust_loss_min": Measure("least βT", "1", lambda c: float(c.thrust_loss.min())),
}
