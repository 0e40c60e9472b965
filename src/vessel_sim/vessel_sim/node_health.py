"""What the simulator's node says of itself on /diagnostics: a pure function of how time goes."""

from __future__ import annotations

from dataclasses import dataclass

from dp_node import Alarm, Health, health_with, raised

_SLOW = 0.95  # of the asked rate: below, an alarm


@dataclass(frozen=True, slots=True)
class SimulatorState:
    """How time goes, and who keeps it from going.

    Attributes
    ----------
    now
        Simulated time, s.
    phase
        What is waited for, in words.
    rate, achieved
        Simulated seconds a wall second that are asked for and that were achieved; the latter is None while unknown.
    paced
        Whether it is the wall clock that says when to go on.
    held
        Whether time stands still until somebody says how far to sail.
    overdue
        Who has not answered, if lockstep has waited for longer than its limit; empty otherwise.
    forgiven
        Wall time that could not be kept up with, s.
    poses, poses_lost, fresh_poses, fresh_lost
        Measurements sent and lost, since the start and since the last report.
    setpoint_age
        Age of the set point in force, s; that of the run before the first.
    setpoint_limit
        Age above which an alarm is raised, s.
    drives_cut
        How often the drives had no set point for so long that they took their torque away.
    """

    now: float
    phase: str
    rate: float
    achieved: float | None
    paced: bool
    held: bool
    overdue: str
    forgiven: float
    poses: int
    poses_lost: int
    fresh_poses: int
    fresh_lost: int
    setpoint_age: float
    setpoint_limit: float
    drives_cut: int = 0


def health_of(state: SimulatorState) -> Health:
    """Return level, text, values and alarms."""
    values: dict[str, object] = {
        # To the millisecond however long it runs: who restarts a simulator begins there.
        "simulated_time": f"{state.now:.3f}",
        "phase": state.phase,
        "rate": state.rate,
        "poses": state.poses,
        "poses_lost": state.poses_lost,
        "drives_cut": state.drives_cut,
    }
    if state.achieved is not None:
        values["rate_achieved"] = state.achieved
    if state.forgiven > 0.0:
        values["time_not_kept_up_with"] = state.forgiven
    alarms: list[Alarm] = []
    if state.overdue:
        alarms.append(raised("SIMULATOR-LOCKSTEP-OVERDUE", state.overdue))
    elif state.paced and state.achieved is not None and state.achieved < _SLOW * state.rate:
        detail = f"{state.achieved:.2f} simulated seconds a second, asked {state.rate:g}"
        alarms.append(raised("SIMULATOR-CANNOT-KEEP-UP", detail))
    if state.setpoint_age > state.setpoint_limit:
        alarms.append(raised("SIMULATOR-NO-SETPOINT", f"for {state.setpoint_age:.1f} s"))
    if state.fresh_lost:
        alarms.append(raised("SIMULATOR-POSES-LOST", f"{state.fresh_lost} of the last {state.fresh_poses}"))
    return health_with(alarms, values, state.phase if state.held else "nominal")
