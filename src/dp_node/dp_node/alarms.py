"""Alarms: every condition that an operator has to know of, with a code that never changes, a text and an advice.

A code names who raises it and what is the matter: ``DRIVERS-COMMAND-STALE``. Codes that begin with ``NODE`` may come
from any node. The page docs/alarms.md lists the same table, and says when each is raised.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from dp_node.level import Level
from marine_model.errors import InputError


@dataclass(frozen=True, slots=True)
class AlarmKind:
    """One row of the table.

    Attributes
    ----------
    code
        Name that stays the same for ever: ``NODE-WORDS``.
    level
        WARN: sailing on, with less than was asked for. ERROR: a function is lost.
    text
        What is the matter.
    advice
        What to do.
    """

    code: str
    level: Level
    text: str
    advice: str


@dataclass(frozen=True, slots=True)
class Alarm:
    """An alarm that is active.

    Attributes
    ----------
    kind
        Row of the table.
    detail
        What is particular about this one: names, numbers. Empty if there is nothing.
    """

    kind: AlarmKind
    detail: str = ""

    @property
    def text(self) -> str:
        """Text of the kind, and the detail."""
        return f"{self.kind.text}: {self.detail}" if self.detail else self.kind.text


def raised(code: str, detail: str = "") -> Alarm:
    """Return the alarm ``code`` of the table.

    Raises
    ------
    InputError
        If there is no such code.
    """
    kind = ALARMS.get(code)
    if kind is None:
        raise InputError(f"alarm: expected a code of dp_node.alarms, found '{code}'")
    return Alarm(kind, detail)


def _table(*kinds: AlarmKind) -> Mapping[str, AlarmKind]:
    table = {kind.code: kind for kind in kinds}
    if len(table) < len(kinds):
        raise InputError("alarms: expected every code once")
    return MappingProxyType(table)


def _warn(code: str, text: str, advice: str) -> AlarmKind:
    return AlarmKind(code, Level.WARN, text, advice)


def _error(code: str, text: str, advice: str) -> AlarmKind:
    return AlarmKind(code, Level.ERROR, text, advice)


ALARMS = _table(
    # Any node
    _warn("NODE-NOT-ACTIVE", "the node is not active", "Activate it; see why it was deactivated or failed to start."),
    _warn("NODE-INPUT-REFUSED", "refused", "See who publishes what was refused, and correct it there."),
    _warn(
        "NODE-SOURCE-RESTARTED",
        "an input began anew and so did the node",
        "None if the source was restarted on purpose; else see why its time jumped.",
    ),
    _error(
        "NODE-QOS-INCOMPATIBLE",
        "a peer's quality of service does not fit: no data flows",
        "Give the peer the quality of service of docs/dp_node.md for this topic.",
    ),
    _warn(
        "NODE-DEADLINE-MISSED",
        "messages come less often than agreed",
        "See whether the publisher runs, and the load of the machine and of the network.",
    ),
    _error(
        "NODE-LIVELINESS-LOST",
        "a publisher is gone or does not answer",
        "See whether the process that publishes it runs; it may be stopped, starved or cut off.",
    ),
    _warn(
        "NODE-MESSAGES-LOST",
        "messages were lost before they were taken",
        "Reduce the load of the machine or of the network.",
    ),
    _error(
        "NODE-SECOND-PUBLISHER",
        "an input that has one publisher by design has a second one",
        "Stop the one that does not belong.",
    ),
    # Observer
    _warn("OBSERVER-NO-FIX-YET", "no position fix yet", "See whether the position reference runs and has a fix."),
    _warn(
        "OBSERVER-NO-POSE",
        "no pose: no measurement arrives",
        "See whether the position reference and the link to it run.",
    ),
    _warn("OBSERVER-DEAD-RECKONING", "no position fix: dead reckoning", "Restore the position reference soon."),
    _warn(
        "OBSERVER-FIX-REFUSED",
        "position fix refused as an outlier: dead reckoning",
        "Compare the position references; if the fix is right, wait until the observer takes it.",
    ),
    _warn(
        "OBSERVER-FIX-FROZEN",
        "the position fix stands still to the last bit while its stamps go on",
        "Distrust this position reference: see whether it measures; take manual control if the vessel drifts.",
    ),
    _warn(
        "OBSERVER-MEASUREMENTS-LOST",
        "measurements of position are missing or late",
        "See the position reference, its link, and the load of the machine.",
    ),
    _warn(
        "OBSERVER-REINITIALISED",
        "position set anew to a fix far from the estimate",
        "Compare the position references: one of the two positions was wrong.",
    ),
    _error(
        "OBSERVER-ESTIMATE-INVALID",
        "estimate invalid: no usable position fix for too long",
        "Take manual control; restore the position reference.",
    ),
    _warn(
        "OBSERVER-NO-TAU-ACHIEVED",
        "no tau_achieved: the estimate knows of no thrust",
        "See whether the allocator runs.",
    ),
    # Controller
    _warn("CONTROLLER-NO-ODOMETRY", "no odometry: no tau_desired", "See whether the observer runs."),
    _error(
        "CONTROLLER-OBSERVER-INVALID",
        "observer invalid: automatic axes hold their integral",
        "Take manual control; restore the position reference.",
    ),
    _warn(
        "CONTROLLER-ESTIMATE-LATE",
        "a sample came late: it counts as ten",
        "See whether the observer runs, and the load of the machine.",
    ),
    _warn(
        "CONTROLLER-JOYSTICK-STALE",
        "joystick stale: its force fades out",
        "See whether the joystick is connected, or change the mode.",
    ),
    _warn("CONTROLLER-PATH-MISSING", "path missing: mode tracking holds position", "Send a path."),
    _warn(
        "CONTROLLER-WIND-STALE",
        "wind stale: the integral has taken its part over",
        "See whether the wind sensor runs, or switch wind_feedforward.enabled off.",
    ),
    _warn(
        "CONTROLLER-WAITS",
        "odometry waits for an input",
        "See who publishes what is missing, or switch off what needs it.",
    ),
    _warn(
        "CONTROLLER-NO-TAU-ACHIEVED",
        "no tau_achieved: the integral takes every demand for achieved",
        "See whether the allocator runs.",
    ),
    _warn(
        "CONTROLLER-POSITION-ERROR",
        "position error above position_alarm",
        "See the margin of the thrusters; give a set point that can be held, or a heading with less load.",
    ),
    _warn(
        "CONTROLLER-HEADING-ERROR",
        "heading error above heading_alarm",
        "See the margin of the thrusters; give a heading that can be held.",
    ),
    _warn(
        "CONTROLLER-DEPTH-ERROR",
        "depth error above vertical.depth_alarm",
        "See the margin of the vertical thrusters, and the ballast; give a depth that can be held.",
    ),
    # Allocator
    _warn("ALLOCATOR-NO-DEMAND", "no tau_desired: no thruster_command", "See whether the controller runs."),
    _warn(
        "ALLOCATOR-NO-FEEDBACK",
        "no thruster_feedback yet: demands are refused",
        "See whether the thrusters send their feedback.",
    ),
    _warn(
        "ALLOCATOR-WAITS",
        "tau_desired waits for an input",
        "See who publishes what is missing, or switch off what needs it.",
    ),
    _warn(
        "ALLOCATOR-DEMAND-NOT-FINITE",
        "demand_not_finite",
        "See who publishes tau_desired; the last good demand stands.",
    ),
    _error("ALLOCATOR-NO-THRUSTER", "no_thruster", "Enable a thruster, or take other means to hold the vessel."),
    _error(
        "ALLOCATOR-SOLVER-FAILED",
        "hold: no solver has a good answer, the last command stands",
        "Choose another solver or method; keep the log, it holds the problem.",
    ),
    _warn(
        "ALLOCATOR-SOLVER-HELD",
        "hold: demands without a good answer",
        "None if it stays at that; else choose another solver, and keep the log.",
    ),
    _warn(
        "ALLOCATOR-SOLVER-FELL-BACK",
        "another solver than chosen had to answer",
        "None if it stays at that; else choose another solver.",
    ),
    _warn(
        "ALLOCATOR-DEMAND-OUT-OF-REACH",
        "demand out of reach",
        "Ask for less: another heading, set point or speed; enable thrusters, widen sectors.",
    ),
    _warn(
        "ALLOCATOR-DEMAND-WAITS-FOR-AZIMUTH",
        "demand out of reach as the thrusters point",
        "None if they are turning; else set azimuth_mode to auto or rotating.",
    ),
    _warn(
        "ALLOCATOR-THRUST-SATURATED",
        "thrust at its limit for long",
        "Ask for less: another heading or set point; enable thrusters that are off.",
    ),
    _warn(
        "ALLOCATOR-THRUSTERS-DISABLED",
        "thrusters are not in use",
        "Mind the smaller margin; enable them once they are repaired.",
    ),
    _warn(
        "ALLOCATOR-POWER-LIMITED",
        "power limited",
        "Start another generator and raise power.available, or ask for less.",
    ),
    _warn(
        "ALLOCATOR-POWER-PHASE-BACK",
        "all thrust phased back for want of power",
        "Start another generator and raise power.available at once, or shed other load.",
    ),
    _warn(
        "ALLOCATOR-BUS-LIMITED",
        "power of a bus limited",
        "Move load to another bus or raise power.bus_limit.",
    ),
    _warn(
        "ALLOCATOR-VENTILATION-STALE",
        "no ventilation: torque losses are being forgotten",
        "See whether the drivers run and ventilation.enabled is on there.",
    ),
    _warn(
        "ALLOCATOR-GAIN-LOW",
        "minimum gain below the limit",
        "Expect a force in the weakest direction to come slowly; enable thrusters, or ask for less at once.",
    ),
    _warn(
        "ALLOCATOR-SINGULAR",
        "singular: the thrusters in use give no force in one direction as they point",
        "Enable a thruster, set singularity.method, or set azimuth_mode to fixed.",
    ),
    _warn(
        "ALLOCATOR-AVOIDANCE-LOCKED",
        "singularity avoidance is locked",
        "Switch singularity.release on, or change azimuth_mode for a while.",
    ),
    # Drivers
    _warn("DRIVERS-NO-COMMAND", "no thruster_command yet: no thrust", "See whether the allocator runs."),
    _warn(
        "DRIVERS-COMMAND-STALE",
        "thruster_command is stale: thrust is ramped to zero, azimuth held",
        "See whether the allocator runs and the link to it.",
    ),
    _warn(
        "DRIVERS-COMMAND-CLIPPED",
        "commands beyond the limits of a thruster are clipped",
        "See who publishes thruster_command; the allocator and the drivers may have different vessel files.",
    ),
    _warn("DRIVERS-NO-FEEDBACK", "no thruster_feedback: no actuator_setpoint", "See whether the thrusters send it."),
    _error(
        "DRIVERS-SENSOR-LOST",
        "thruster_feedback is not finite: that thruster runs open loop",
        "Disable the thruster in the allocator and repair its sensor.",
    ),
    _warn(
        "DRIVERS-SPEED-LOST",
        "odometry is missing or stale: codes are those of the vessel at rest",
        "See whether the observer runs; or set code_map.compensated to false.",
    ),
    _warn(
        "DRIVERS-SPEED-CLAMPED",
        "the surge speed is outside the tables of a drive and is clamped",
        "Sail at a speed that the tables cover.",
    ),
    _warn(
        "DRIVERS-WAITS",
        "thruster_feedback waits for an input",
        "See whether the observer runs, and publishes odometry to the drivers.",
    ),
    _warn(
        "DRIVERS-VENTILATION",
        "propellers draw air",
        "None if anti-spin is on; else switch antispin.enabled on, or change heading.",
    ),
    # Simulator
    _warn(
        "SIMULATOR-CANNOT-KEEP-UP",
        "cannot keep up",
        "Ask for a smaller rate, run in lockstep, or free the processor.",
    ),
    _error(
        "SIMULATOR-LOCKSTEP-OVERDUE",
        "lockstep stands still",
        "See which node the text names: it has died, hangs, or was never started.",
    ),
    _warn(
        "SIMULATOR-NO-SETPOINT",
        "no actuator_setpoint: the motors keep the last one until setpoint_timeout",
        "See whether the drivers run.",
    ),
    _warn(
        "SIMULATOR-POSES-LOST",
        "measurements of position are being lost",
        "None if a fault is simulated on purpose.",
    ),
    # Recorder
    _warn("RECORDER-MESSAGES-LOST", "messages lost", "Record fewer topics, or free the processor and the disk."),
    _warn(
        "RECORDER-PARAMETERS-MISSING",
        "a node does not tell its parameters: they are not in the bag",
        "See whether the node hangs; one without parameter services can be left aside.",
    ),
    _error("RECORDER-DISK-FULL", "the disk is full: recording has stopped", "Free the disk and record anew."),
    _error("RECORDER-WRITE-FAILED", "a write failed: recording has stopped", "See the disk, and record anew."),
    # Supervisor
    _warn(
        "SUPERVISOR-NODE-RESTARTED",
        "a node died and was restarted",
        "See its log for the reason.",
    ),
    _error(
        "SUPERVISOR-NODE-GIVEN-UP",
        "a node died again and again and is not restarted any more",
        "See its log for the reason, then bring the graph up anew.",
    ),
    _error(
        "SUPERVISOR-NODE-SILENT",
        "a node runs but does not answer",
        "See the load of the machine, and whether the process is stopped.",
    ),
)
