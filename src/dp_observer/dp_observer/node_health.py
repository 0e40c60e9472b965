"""What the observer's node says of itself on /diagnostics: a pure function of what it has done."""

from __future__ import annotations

from dataclasses import dataclass

from dp_node import Alarm, Health, health_with, raised
from dp_observer.alarm_codes import BY_STATUS, FIX_FROZEN, MEASUREMENTS_LOST, codes_of
from dp_observer.estimate import ObserverStatus

_CALM = {ObserverStatus.INITIALISED: "first position fix"}


@dataclass(slots=True)
class Tally:
    """What the node has done since it was activated.

    Attributes
    ----------
    status, time_since_measurement
        Of the last estimate; the latter in s.
    poses, without_fix, outliers, late
        Poses that came; those without a fix, those refused as outliers, those that the watchdog had answered already.
    ahead
        Estimates made without a pose.
    force_age
        Time from the newest tau_achieved, or from the first pose if there was none, to the last pose, s.
    held
        Poses that wait for the answer to the sample before.
    reinitialised
        Whether the position was set anew since the last report.
    equal_fixes, frozen
        Fixes in a row that equal the one before, and whether these are too many.
    """

    status: ObserverStatus = ObserverStatus.UNINITIALISED
    time_since_measurement: float = 0.0
    poses: int = 0
    without_fix: int = 0
    outliers: int = 0
    late: int = 0
    ahead: int = 0
    force_age: float = 0.0
    held: int = 0
    reinitialised: bool = False
    equal_fixes: int = 0
    frozen: bool = False
    _reported: tuple[int, int, int, int, int] = (0, 0, 0, 0, 0)

    def fresh(self) -> tuple[int, int, int, int, int]:
        """Return poses, without_fix, outliers, late and ahead since the last report."""
        now = (self.poses, self.without_fix, self.outliers, self.late, self.ahead)
        a, b, c, d, e = (one - before for one, before in zip(now, self._reported, strict=True))
        return a, b, c, d, e

    def reported(self) -> None:
        """Begin the next report."""
        self._reported = (self.poses, self.without_fix, self.outliers, self.late, self.ahead)
        self.reinitialised = False

    def estimated(self, status: ObserverStatus, time_since_measurement: float) -> None:
        """Take note of an estimate."""
        self.status, self.time_since_measurement = status, time_since_measurement
        self.reinitialised = self.reinitialised or status is ObserverStatus.REINITIALISED


def status_alarm(status: ObserverStatus) -> Alarm | None:
    """Return the alarm that a status means; None if it means none."""
    return raised(BY_STATUS[status]) if status in BY_STATUS else None


def status_text(status: ObserverStatus) -> str:
    """Return what a status means, for the log."""
    alarm = status_alarm(status)
    return alarm.text if alarm is not None else _CALM.get(status, "nominal")


def health_of(tally: Tally, force_limit: float) -> Health:
    """Return level, text, values and alarms.

    Parameters
    ----------
    tally
        What was done.
    force_limit
        Age of tau_achieved above which the observer takes the thrust for zero, s.
    """
    values: dict[str, object] = {
        "status": str(tally.status),
        "time_since_measurement_s": tally.time_since_measurement,
        "poses": tally.poses,
        "poses_without_fix": tally.without_fix,
        "outliers": tally.outliers,
        "late_poses": tally.late,
        "estimates_without_pose": tally.ahead,
        "poses_held": tally.held,
        "equal_fixes": tally.equal_fixes,
        "tau_achieved_age_s": tally.force_age,
    }
    poses, without_fix, outliers, late, ahead = tally.fresh()
    missing = {"without fix": without_fix, "refused as outliers": outliers, "late": late, "made up for": ahead}
    told = ", ".join(f"{count} {what}" for what, count in missing.items() if count)
    details = {
        MEASUREMENTS_LOST: f"{told}, beside {poses} poses",
        FIX_FROZEN: f"{tally.equal_fixes} times the same",
    }
    codes = codes_of(tally.status, tally.reinitialised, poses, sum(missing.values()), tally.frozen)
    alarms = [raised(code, details.get(code, "")) for code in codes]
    if poses and tally.force_age > force_limit:
        alarms.append(raised("OBSERVER-NO-TAU-ACHIEVED", f"for {tally.force_age:.1f} s"))
    return health_with(alarms, values, _CALM.get(tally.status, "nominal"))
