"""What a run left behind, whoever sailed it: named time series, and who, what and when.

The in-process loop and the bag reader both make a :class:`RunData`; figures and report know nothing else.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from marine_model.axes import HORIZONTAL
from marine_model.errors import DocumentError, InputError
from marine_model.guards import FloatArray

# Name of every series: width, unit by column, where it comes from.
# One row a pose (control rate):
#   pose                    m, m, rad       measured, map_ned; NaN where there was no fix
#   estimate_position       m, m, rad       low-frequency estimate, map_ned
#   estimate_velocity       m/s, m/s, rad/s body frame
#   wave_position           m, m, rad       wave-frequency estimate, map_ned
#   bias                    N, N, N m       map_ned
#   reference_position      m, m, rad       map_ned
#   reference_velocity      m/s, m/s, rad/s body frame
#   proportional, integral, derivative, joystick, transfer, tau_desired, tau_achieved, slack    N, N, N m, body frame
#   wind_feedforward        N, N, N m       body frame
#   wind                    m/s             velocity of the air relative to the vessel, body frame; where it is measured
#   thrust_command          N               azimuth_command   rad          allocation_cost   -
#   torque_loss             1               beta_Q2 in use by the allocator; where anti-spin was on at any time
#   minimum_gain            1               at the commanded angles, scaled; rotating thrusters push only
#   minimum_gain_both_ways  1               if every thruster could reverse
#   minimum_gain_free       1               what it would be without singularity avoidance; where that is on
#   performance_measure     N               filtered surge-sway demand; where azimuth_mode is auto
#   sub_problem             1               chosen combination of windows, 0 without sectors
#   rotating, crossing      0 or 1          allocated as a rotating thruster; on the way to its window
# One row a feedback (drivers' rate):
#   shaft_speed  Hz         motor_torque  N m          power  W         azimuth  rad
#   torque_setpoint  N m    azimuth_rate_setpoint  rad/s    pitch_ratio  1    pitch_ratio_setpoint  1
#   ventilating  0 or 1     beta_q  1              beta_q2  1    where the drivers look for ventilation
#   code  1                 asked of torque-controlled drives that take codes, 0 of others
# Of submerged vehicles, besides: depth, roll and pitch (m, rad, rad; map_ned) and forces along heave, roll and pitch
# (N, N m, N m; body frame)
#   vertical_pose, vertical_estimate, vertical_reference, vertical_truth    m, rad, rad
#   vertical_velocity       m/s, rad/s, rad/s
#   vertical_bias, vertical_desired, vertical_achieved    N, N m, N m
# Where the method of the allocator is another than the quadratic program, over the degrees of freedom:
#   tau_feasible            what the method reduced the demand to
#   tau_qp                  what the quadratic program would have achieved
#   feasible_load           1               the demand on the method's own region, whose edge is 1
# True state, where a simulator sailed:
#   truth_position          m, m, rad       with wave motion, map_ned; at the times of the poses
#   truth_thrust  N   truth_thrust_loss  1   truth_torque_loss  1   truth_submergence  m   truth_advance_speed  m/s
PER_THRUSTER, PER_AXIS = 0, -1  # in place of a width: one column a thruster, or a degree of freedom
WIDTHS: Mapping[str, int] = {
    "pose": 3,
    "estimate_position": 3,
    "estimate_velocity": 3,
    "wave_position": 3,
    "bias": 3,
    "reference_position": 3,
    "reference_velocity": 3,
    "proportional": 3,
    "integral": 3,
    "derivative": 3,
    "wind_feedforward": 3,
    "wind": 2,
    "joystick": 3,
    "transfer": 3,
    "tau_desired": 3,
    "tau_achieved": 3,
    "slack": PER_AXIS,
    "allocation_cost": 1,
    "thrust_command": 0,
    "azimuth_command": 0,
    "shaft_speed": 0,
    "motor_torque": 0,
    "power": 0,
    "azimuth": 0,
    "torque_setpoint": 0,
    "azimuth_rate_setpoint": 0,
    "pitch_ratio": 0,
    "pitch_ratio_setpoint": 0,
    "ventilating": 0,
    "beta_q": 0,
    "beta_q2": 0,
    "torque_loss": 0,
    "minimum_gain": 1,
    "minimum_gain_both_ways": 1,
    "minimum_gain_free": 1,
    "performance_measure": 1,
    "sub_problem": 1,
    "rotating": 0,
    "crossing": 0,
    "truth_position": 3,
    "truth_thrust": 0,
    "truth_thrust_loss": 0,
    "truth_torque_loss": 0,
    "truth_submergence": 0,
    "truth_advance_speed": 0,
    "code": 0,
    "vertical_pose": 3,
    "vertical_estimate": 3,
    "vertical_velocity": 3,
    "vertical_bias": 3,
    "vertical_reference": 3,
    "vertical_desired": 3,
    "vertical_achieved": 3,
    "vertical_truth": 3,
    "tau_feasible": PER_AXIS,
    "tau_qp": PER_AXIS,
    "feasible_load": 1,
}
# Series of submerged vehicles only.
VERTICAL = frozenset(name for name in WIDTHS if name.startswith("vertical_"))
# Fields of propulsion_truth; their series begin with truth_.
PROPULSION_TRUTH = ("thrust", "thrust_loss", "torque_loss", "submergence", "advance_speed")
# Series that are there only while what they tell of is switched on.
SOMETIMES = (
    frozenset(
        (
            "ventilating",
            "beta_q",
            "beta_q2",
            "torque_loss",
            "minimum_gain",
            "minimum_gain_both_ways",
            "minimum_gain_free",
            "performance_measure",
            "crossing",
            "wind",
            "code",
            "tau_feasible",
            "tau_qp",
            "feasible_load",
        )
    )
    | VERTICAL
)


def width(series: str, thrusters: int, axes: int) -> int:
    """Return how many columns a series has with so many thrusters and degrees of freedom."""
    return {PER_THRUSTER: thrusters, PER_AXIS: axes}.get(WIDTHS[series], WIDTHS[series])


@dataclass(frozen=True, slots=True)
class Series:
    """One signal over time.

    Parameters
    ----------
    t
        Simulated time, shape (k,), s, increasing.
    values
        Shape (k, width).
    """

    t: FloatArray
    values: FloatArray

    def window(self, start: float, end: float) -> Series:
        """Return the part with start <= t < end (s)."""
        # Half a microsecond: stamps are whole nanoseconds, their sums in s are not exact.
        first, last = np.searchsorted(self.t, [start - 5e-7, end - 5e-7])
        return Series(self.t[first:last], self.values[first:last])

    def at(self, t: FloatArray) -> FloatArray:
        """Return the newest value at every time of ``t`` (hold), shape (len(t), width); NaN before the first."""
        index = np.searchsorted(self.t, t + 5e-7, side="right") - 1
        held = self.values[np.maximum(index, 0)].astype(np.float64)
        held[index < 0] = np.nan
        return held


@dataclass(frozen=True, slots=True)
class Labels:
    """A word that changes over time, e.g. a mode: one entry a change.

    Parameters
    ----------
    t
        Time of each change, shape (k,), s, increasing; the first is the first sample.
    words
        The word from then on.
    """

    t: FloatArray
    words: tuple[str, ...]


@dataclass(frozen=True)
class RunInfo:
    """Who sailed what, how and how long.

    Parameters
    ----------
    scenario, vessel
        Name or path; an empty scenario means a run without one.
    how
        "in process", "lockstep graph", ...
    seed
        Of the simulator's noise.
    versions
        Version by name of what took part.
    started
        Wall-clock start as ISO 8601 text; empty when not known.
    simulated_time, wall_time
        s; wall time 0 when not known.
    """

    scenario: str
    vessel: str
    how: str
    seed: int = 0
    versions: Mapping[str, str] = field(default_factory=dict)
    started: str = ""
    simulated_time: float = 0.0
    wall_time: float = 0.0

    @property
    def real_time_factor(self) -> float | None:
        """Simulated over wall time; None when wall time is not known."""
        return self.simulated_time / self.wall_time if self.wall_time > 0.0 else None

    def write(self, path: Path) -> None:
        """Write this as JSON."""
        path.write_text(json.dumps(asdict(self), indent=2) + "\n", encoding="utf-8")

    @classmethod
    def read(cls, path: Path) -> RunInfo:
        """Return what :meth:`write` wrote.

        Raises
        ------
        DocumentError
            If the file cannot be read or is not such a file.
        """
        try:
            content: Any = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise DocumentError(f"{path}: cannot be read: {error}") from error
        try:
            return cls(**content)
        except TypeError as error:
            raise DocumentError(f"{path}: expected the fields of a run, found {error}") from error


@dataclass(frozen=True)
class RunData:
    """One run. A series that the run does not have is absent.

    Parameters
    ----------
    info
        Who sailed what.
    thrusters
        Names, in the order of the vessel file.
    series
        By name; names and widths as in ``WIDTHS``.
    labels
        By name: observer_status, controller_mode, controller_status, allocation_status, azimuth_mode, method.
    degrees_of_freedom
        Of the vessel.

    Raises
    ------
    InputError
        If a series has an unknown name, the wrong shape, or time that does not increase.
    """

    info: RunInfo
    thrusters: tuple[str, ...]
    series: Mapping[str, Series]
    labels: Mapping[str, Labels] = field(default_factory=dict)
    degrees_of_freedom: tuple[str, ...] = HORIZONTAL

    def __post_init__(self) -> None:
        for name, entry in self.series.items():
            if name not in WIDTHS:
                raise InputError(f"series: expected one of {', '.join(WIDTHS)}, found '{name}'")
            expected = (len(entry.t), width(name, len(self.thrusters), len(self.degrees_of_freedom)))
            if entry.values.shape != expected:
                raise InputError(f"series {name}: expected shape {expected}, found {entry.values.shape}")
            if len(entry.t) > 1 and not (np.diff(entry.t) > 0.0).all():
                raise InputError(f"series {name}: expected increasing time")

    def __contains__(self, name: str) -> bool:
        return name in self.series and len(self.series[name].t) > 0

    def __getitem__(self, name: str) -> Series:
        """Return a series. Raises InputError if the run has none of that name."""
        if name not in self:
            raise InputError(f"series: expected one of {', '.join(self.series)}, found '{name}'")
        return self.series[name]

    @property
    def duration(self) -> float:
        """End of the last series, s."""
        return max((float(entry.t[-1]) for entry in self.series.values() if len(entry.t)), default=0.0)
