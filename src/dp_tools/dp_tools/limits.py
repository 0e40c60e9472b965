"""Were the limits of the vessel held in every sample?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dp_tools.run_data import RunData
from marine_model import Vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray

# Commands are doubles worked out by a QP solver whose answer is clipped: what is left is rounding in sums and angles.
RELATIVE_TOLERANCE = 1e-9


@dataclass(frozen=True)
class LimitCheck:
    """One limit of one thruster over a whole run.

    Parameters
    ----------
    limit
        thrust, thrust_rate, azimuth_rate, torque or azimuth_motor_rate.
    thruster
        Name.
    allowed
        (lowest, highest), in ``unit``.
    found
        (lowest, highest) of the run.
    samples, violations
        Number of samples looked at, and of those outside.
    first
        Time of the first violation, s; None if there is none.
    """

    limit: str
    unit: str
    thruster: str
    allowed: tuple[float, float]
    found: tuple[float, float]
    samples: int
    violations: int
    first: float | None


def limits_violations(run: RunData, vessel: Vessel) -> tuple[LimitCheck, ...]:
    """Return a check of every limit of every thruster in every sample of ``run``.

    Commands: thrust within (4.5), its change between successive samples within (4.6), the turn between samples within
    (4.9) of [Ruth]. Setpoints of the drivers: motor torque and azimuth motor rate within what the drives can do.

    Raises
    ------
    InputError
        If the run has no commands.
    """
    thrust = run["thrust_command"]
    azimuth = run["azimuth_command"]
    dt = np.diff(thrust.t)[:, None]
    turn = wrap_angles(np.diff(azimuth.values, axis=0)) / dt
    checks = [
        *_check(run, "thrust", "N", thrust.t, thrust.values, vessel.thrust_min, vessel.thrust_max),
        *_check(
            run,
            "thrust_rate",
            "N/s",
            thrust.t[1:],
            np.diff(thrust.values, axis=0) / dt,
            -vessel.thrust_rate,
            vessel.thrust_rate,
        ),
        *_check(run, "azimuth_rate", "rad/s", azimuth.t[1:], turn, -vessel.azimuth_rate, vessel.azimuth_rate),
    ]
    if "torque_setpoint" in run:
        torque = run["torque_setpoint"]
        largest = np.array([thruster.shaft.torque_max for thruster in vessel.thrusters])
        checks += _check(run, "torque", "N m", torque.t, torque.values, -largest, largest)
    if "azimuth_rate_setpoint" in run:
        rate = run["azimuth_rate_setpoint"]
        fastest = np.array([t.azimuth_drive.rate_max if t.type == "azimuth" else 0.0 for t in vessel.thrusters])
        checks += _check(run, "azimuth_motor_rate", "rad/s", rate.t, rate.values, -fastest, fastest)
    return tuple(checks)


def _check(
    run: RunData,
    limit: str,
    unit: str,
    t: FloatArray,
    values: FloatArray,
    lowest: FloatArray,
    highest: FloatArray,
) -> list[LimitCheck]:
    checks = []
    for j, thruster in enumerate(run.thrusters):
        low, high = float(lowest[j]), float(highest[j])
        slack = RELATIVE_TOLERANCE * max(abs(low), abs(high), 1.0)
        # Written so that NaN counts as a violation.
        bad = ~((values[:, j] >= low - slack) & (values[:, j] <= high + slack))
        first = np.flatnonzero(bad)
        checks.append(
            LimitCheck(
                limit=limit,
                unit=unit,
                thruster=thruster,
                allowed=(low, high),
                found=(float(values[:, j].min()), float(values[:, j].max())) if len(values) else (0.0, 0.0),
                samples=len(values),
                violations=int(bad.sum()),
                first=float(t[first[0]]) if len(first) else None,
            )
        )
    return checks
