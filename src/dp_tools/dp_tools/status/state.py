"""What `dp status` knows: made of messages, without ROS."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from dp_node import Level
from dp_node.health import ALARM_KEY
from dp_tools.status.alarm_log import AlarmLog, ShownAlarm
from dp_tools.status.rate import Meter
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import quaternion_to_attitude, quaternion_to_heading

# Nodes report once a second: after this long without a report, something is the matter.
SILENT = 3.0  # s
# What every node of the graph answers with: how often it comes is how often the node acts.
OUTPUTS = {
    "dp_observer": "odometry",
    "dp_controller": "controller_status",
    "thrust_allocator": "thruster_command",
    "thruster_drivers": "actuator_setpoint",
    "vessel_sim": "pose",
}
RECORDER = "recorder"
# Topics whose newest message is shown; those of OUTPUTS that are not among them are only counted.
SHOWN = (
    "odometry",
    "observer_state",
    "controller_status",
    "tau_desired",
    "thruster_command",
    "allocation_status",
    "thruster_feedback",
    "ventilation",
    "wind",
)


@dataclass(frozen=True)
class NodeReport:
    """The last report of a node.

    Attributes
    ----------
    name
        Without the namespace.
    level, message, values
        As on /diagnostics.
    stamp
        When the node made it, s of its clock.
    seen
        When it came, s.
    """

    name: str
    level: Level
    message: str
    values: dict[str, str]
    stamp: float
    seen: float


@dataclass(frozen=True)
class ThrusterRow:
    """What is known of a thruster; None where nobody has said it.

    Attributes
    ----------
    name
        As in the vessel file.
    thrust, azimuth
        Commanded, N and rad.
    thrust_min, thrust_max
        Limits of the vessel file, N.
    shaft_speed, power, measured_azimuth
        Measured, Hz, W, rad.
    saturated, disabled, ventilating
        At a limit; not in use; drawing air.
    """

    name: str
    thrust: float | None = None
    azimuth: float | None = None
    thrust_min: float | None = None
    thrust_max: float | None = None
    shaft_speed: float | None = None
    power: float | None = None
    measured_azimuth: float | None = None
    saturated: bool = False
    disabled: bool = False
    ventilating: bool = False


class StatusState:
    """Keeps the newest of everything.

    Parameters
    ----------
    namespace
        Of the graph: ``/`` or e.g. ``/ship``.
    vessel
        For names and limits of the thrusters; they are taken from messages as far as they hold them without.
    """

    def __init__(self, namespace: str = "/", vessel: Vessel | None = None) -> None:
        self.namespace = namespace
        self.vessel = vessel
        self.alarms = AlarmLog()
        self.nodes: dict[str, NodeReport] = {}
        self._newest: dict[str, tuple[Any, float]] = {}
        self._meters: dict[str, Meter] = {}
        self._counts: dict[str, int] = {}
        self._pace = Meter()

    # What comes in --------------------------------------------------------------------------------------------------

    def update(self, topic: str, message: Any, now: float) -> None:
        """Take the newest message of ``topic``, which came at ``now`` (s)."""
        if topic == "/diagnostics":
            self._report(message, now)
            return
        self._newest[topic] = (message, now)
        if topic == "odometry":
            self._pace.note(now, _seconds(message.header.stamp))

    def count(self, topic: str, total: int, now: float) -> None:
        """Take note that ``total`` messages of ``topic`` have come up to ``now`` (s)."""
        self._counts[topic] = total
        self._meters.setdefault(topic, Meter()).note(now, total)

    def _report(self, message: Any, now: float) -> None:
        stamp = _seconds(message.header.stamp)
        for status in message.status:
            name = self._own_name(status.name)
            before = self.nodes.get(name) if name else None
            if not name or (before is not None and stamp < before.stamp):
                continue  # of another graph, or of before what is known
            values = {pair.key: pair.value for pair in status.values}
            active = {key[len(ALARM_KEY) :]: text for key, text in values.items() if key.startswith(ALARM_KEY)}
            level = Level(min(status.level[0], int(Level.ERROR)))  # 3 is STALE, which is no better
            self.nodes[name] = NodeReport(name, level, status.message, values, stamp, now)
            self.alarms.report(name, active, stamp)

    def _own_name(self, full: str) -> str:
        """Return a name within the namespace; empty for a node of another one."""
        below = self.namespace.strip("/")
        space, _, name = full.strip("/").rpartition("/")
        return name if space == below else ""

    # What is known --------------------------------------------------------------------------------------------------

    def newest(self, topic: str) -> Any:
        """Return the newest message of ``topic``; None before the first."""
        found = self._newest.get(topic)
        return None if found is None else found[0]

    def age(self, topic: str, now: float) -> float:
        """Return the time since the newest message of ``topic``, s; infinite before the first."""
        found = self._newest.get(topic)
        return math.inf if found is None else now - found[1]

    @property
    def known(self) -> bool:
        """Whether anything has come at all."""
        return bool(self.nodes or self._newest)

    @property
    def simulated_time(self) -> float | None:
        """Stamp of the newest odometry, s."""
        odometry = self.newest("odometry")
        return None if odometry is None else _seconds(odometry.header.stamp)

    @property
    def pace(self) -> float | None:
        """Simulated seconds a wall second."""
        return self._pace.rate

    def rate(self, node: str) -> float | None:
        """Return how often a node puts out its answer, messages a second; None if it has none."""
        meter = self._meters.get(OUTPUTS.get(node, ""))
        return None if meter is None else meter.rate

    def counted(self, topic: str) -> int:
        """Return how many messages of ``topic`` have come."""
        return self._counts.get(topic, 0)

    @property
    def recorder(self) -> NodeReport | None:
        """Last report of the recorder."""
        return self.nodes.get(RECORDER)

    def pose(self) -> tuple[float, float, float] | None:
        """Return north (m), east (m), heading (rad) of the estimate; None if there is none or it is invalid."""
        message = self.newest("odometry")
        if message is None or message.pose.covariance[0] < 0.0:
            return None
        at, q = message.pose.pose.position, message.pose.pose.orientation
        try:
            return at.x, at.y, quaternion_to_heading(q.x, q.y, q.z, q.w)
        except InputError:
            return None

    def below(self) -> tuple[float, float, float] | None:
        """Return depth (m), roll, pitch (rad) of the estimate of a submerged vehicle; None as :meth:`pose`."""
        message = self.newest("odometry")
        if self.vessel is None or not self.vessel.is_submerged or self.pose() is None or message is None:
            return None
        at, q = message.pose.pose.position, message.pose.pose.orientation
        roll, pitch, _ = quaternion_to_attitude(q.x, q.y, q.z, q.w)
        return at.z, roll, pitch

    def thrusters(self) -> list[ThrusterRow]:
        """Return a row for every thruster, in the order of the vessel file or of the messages."""
        command, feedback = self.newest("thruster_command"), self.newest("thruster_feedback")
        names: Sequence[str] = ()
        if self.vessel is not None:
            names = self.vessel.thruster_names
        elif command is not None or feedback is not None:
            names = list((command or feedback).name)
        status, ventilation = self.newest("allocation_status"), self.newest("ventilation")
        allocator = self.nodes.get("thrust_allocator")
        disabled = () if allocator is None else allocator.values.get("disabled", "").split()
        rows = []
        for i, name in enumerate(names):
            limits = None if self.vessel is None else self.vessel.thrusters[i].thrust
            rows.append(
                ThrusterRow(
                    name,
                    thrust=_of(command, "thrust", name),
                    azimuth=_of(command, "azimuth", name),
                    thrust_min=None if limits is None else limits.min,
                    thrust_max=None if limits is None else limits.max,
                    shaft_speed=_of(feedback, "shaft_speed", name),
                    power=_of(feedback, "power", name),
                    measured_azimuth=_of(feedback, "azimuth", name),
                    saturated=bool(
                        status is not None and i < len(status.thrust_saturated) and status.thrust_saturated[i]
                    ),
                    disabled=name in disabled,
                    ventilating=bool(_of(ventilation, "ventilating", name)),
                )
            )
        return rows

    def shown_alarms(self, now: float) -> list[ShownAlarm]:
        """Return active alarms, newest first, and after them those that are over."""
        return self.alarms.active + self.alarms.over(now)


def _of(message: Any, field: str, name: str) -> Any:
    """Return what a message of thrusters says of ``name``; None if it says nothing."""
    if message is None or name not in message.name:
        return None
    values = getattr(message, field)
    index = list(message.name).index(name)
    return values[index] if index < len(values) else None


def _seconds(stamp: Any) -> float:
    return float(stamp.sec + stamp.nanosec * 1e-9)
