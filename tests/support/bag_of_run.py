"""Writes a run as the bag that the node graph would have recorded."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from mcap.writer import Writer
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from dp_tools.run_data import Labels, RunData
from marine_model import Vessel
from marine_model.frames import heading_to_quaternion
from support.repository import MESSAGES

NANOSECONDS = 1_000_000_000

KINDS = {
    "wind": "geometry_msgs/msg/Vector3Stamped",
    "pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "truth": "nav_msgs/msg/Odometry",
    "propulsion_truth": "dp_msgs/msg/PropulsionTruth",
    "odometry": "nav_msgs/msg/Odometry",
    "observer_state": "dp_msgs/msg/ObserverState",
    "controller_status": "dp_msgs/msg/ControllerStatus",
    "tau_desired": "geometry_msgs/msg/WrenchStamped",
    "tau_achieved": "geometry_msgs/msg/WrenchStamped",
    "thruster_command": "dp_msgs/msg/ThrusterCommand",
    "allocation_status": "dp_msgs/msg/AllocationStatus",
    "thruster_feedback": "dp_msgs/msg/ThrusterFeedback",
    "actuator_setpoint": "dp_msgs/msg/ActuatorSetpoint",
    "ventilation": "dp_msgs/msg/Ventilation",
}
# Order of travel, so that the file has it as well.
AT_SAMPLE = tuple(KINDS)[:11]


def _store() -> Typestore:
    store = get_typestore(Stores.ROS2_JAZZY)
    for path in sorted((MESSAGES / "msg").glob("*.msg")):
        name = f"dp_msgs/msg/{path.stem}"
        store.register(get_types_from_msg(path.read_text(encoding="utf-8"), name))
    return store


def _empty(form: Any) -> Any:
    kind, detail = form
    if kind is Nodetype.BASE:
        return {"string": "", "bool": False}.get(detail[0], 0.0 if detail[0].startswith("float") else 0)
    (_, (base, _)), length = detail
    if base == "string":
        return [""] * length
    return np.zeros(length, dtype=bool if base == "bool" else base)


class BagOfRun:
    """Messages of one run."""

    def __init__(self, run: RunData, vessel: Vessel, start_ns: int = 0) -> None:
        self._run = run
        self._vessel = vessel
        self._start = start_ns
        self._store = _store()

    def write(self, path: Path, scenario: Path | None, namespace: str = "", with_vessel: bool = True) -> None:
        """Write an MCAP file with the attachments that the recorder makes; log time is stamp / 10 since 2026."""
        with path.open("wb") as stream:
            writer = Writer(stream)
            writer.start(profile="ros2", library="test")
            if with_vessel:
                document = yaml.safe_dump(self._vessel.model_dump(mode="json")).encode()
                writer.add_attachment(0, 0, "vessel.yaml", "application/yaml", document)
            if scenario is not None:
                writer.add_attachment(0, 0, "scenario.yaml", "application/yaml", scenario.read_bytes())
            writer.add_metadata("versions", {"dp_tools": "1.2.3"})
            schemas: dict[str, int] = {}
            channels = {}
            for topic, kind in KINDS.items():
                if kind not in schemas:
                    text = self._store.generate_msgdef(kind, ros_version=2)[0]
                    schemas[kind] = writer.register_schema(kind, "ros2msg", text.encode())
                channels[topic] = writer.register_channel(f"{namespace}/{topic}", "cdr", schemas[kind])
            for topic, stamp, message in self._messages():
                data = bytes(self._store.serialize_cdr(message, KINDS[topic]))
                log_time = 1_767_225_600 * NANOSECONDS + stamp // 10
                writer.add_message(channels[topic], log_time, data, log_time)
            writer.finish()

    def _messages(self) -> Iterator[tuple[str, int, Any]]:
        samples = {round(float(t) * 1e9): i for i, t in enumerate(self._run["pose"].t)}
        for k, t in enumerate(self._run["power"].t):
            stamp = round(float(t) * 1e9)
            if stamp in samples:
                # An operator was answered just before, with the output of the sample before.
                yield (
                    "controller_status",
                    stamp + (1 if stamp == 0 else 0),
                    self._controller_status(max(samples[stamp] - 1, 0), stamp + (1 if stamp == 0 else 0)),
                )
                for topic in AT_SAMPLE:
                    yield topic, stamp, getattr(self, f"_{topic}")(samples[stamp], stamp)
                # The drivers acknowledge the command with their last setpoint, stamped as the command.
                yield "actuator_setpoint", stamp, self._actuator_setpoint(max(k - 1, 0), stamp)
            yield "thruster_feedback", stamp, self._thruster_feedback(k, stamp)
            yield "actuator_setpoint", stamp, self._actuator_setpoint(k, stamp)
            if "beta_q" in self._run:
                yield "ventilation", stamp, self._ventilation(k, stamp)

    def _make(self, kind: str, **fields: Any) -> Any:
        """Return a message; numbers and texts that are not given are zero and empty."""
        rest = {name: _empty(form) for name, form in self._store.fielddefs[kind][1] if name not in fields}
        return self._store.types[kind](**fields, **rest)

    def _stamp(self, stamp: int) -> Any:
        sec, nanosec = divmod(stamp + self._start, NANOSECONDS)
        return self._make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)

    def _header(self, stamp: int) -> Any:
        return self._make("std_msgs/msg/Header", stamp=self._stamp(stamp), frame_id="")

    def _vector(self, x: float, y: float, z: float) -> Any:
        return self._make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def _row(self, name: str, i: int) -> Any:
        return self._run[name].values[i]

    def _word(self, name: str, i: int) -> str:
        labels: Labels = self._run.labels[name]
        index = np.searchsorted(labels.t, self._run["pose"].t[i] + 1e-6, side="right") - 1
        return labels.words[max(int(index), 0)]

    def _pose_of(self, position: Any, covariance: float) -> Any:
        north, east, heading = (float(v) for v in position)
        x, y, z, w = heading_to_quaternion(heading)
        matrix = np.zeros(36)
        matrix[0] = covariance
        return self._make(
            "geometry_msgs/msg/PoseWithCovariance",
            pose=self._make(
                "geometry_msgs/msg/Pose",
                position=self._make("geometry_msgs/msg/Point", x=north, y=east, z=0.0),
                orientation=self._make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w),
            ),
            covariance=matrix,
        )

    def _odometry_of(self, stamp: int, position: Any, velocity: Any) -> Any:
        u, v, r = (float(value) for value in velocity)
        return self._make(
            KINDS["odometry"],
            header=self._header(stamp),
            child_frame_id="",
            pose=self._pose_of(position, 1e-6),
            twist=self._make(
                "geometry_msgs/msg/TwistWithCovariance",
                twist=self._make(
                    "geometry_msgs/msg/Twist", linear=self._vector(u, v, 0.0), angular=self._vector(0.0, 0.0, r)
                ),
                covariance=np.zeros(36),
            ),
        )

    def _pose(self, i: int, stamp: int) -> Any:
        position = self._row("pose", i)
        fix = bool(np.isfinite(position).all())
        pose = self._pose_of(position if fix else np.zeros(3), 1e-6 if fix else -1.0)
        return self._make(KINDS["pose"], header=self._header(stamp), pose=pose)

    def _wind(self, i: int, stamp: int) -> Any:
        ahead, starboard = (float(value) for value in self._row("wind", i))
        return self._make(KINDS["wind"], header=self._header(stamp), vector=self._vector(ahead, starboard, 0.0))

    def _truth(self, i: int, stamp: int) -> Any:
        return self._odometry_of(stamp, self._row("truth_position", i), np.zeros(3))

    def _propulsion_truth(self, i: int, stamp: int) -> Any:
        names = ("thrust", "thrust_loss", "torque_loss", "submergence", "advance_speed")
        return self._make(
            KINDS["propulsion_truth"],
            header=self._header(stamp),
            name=list(self._run.thrusters),
            **{name: self._row(f"truth_{name}", i) for name in names},
        )

    def _odometry(self, i: int, stamp: int) -> Any:
        return self._odometry_of(stamp, self._row("estimate_position", i), self._row("estimate_velocity", i))

    def _observer_state(self, i: int, stamp: int) -> Any:
        return self._make(
            KINDS["observer_state"],
            header=self._header(stamp),
            valid=True,
            status=self._word("observer_status", i),
            time_since_measurement=0.0,
            wave_frequency_position=self._row("wave_position", i),
            bias=self._row("bias", i),
            innovation=np.zeros(3),
        )

    def _controller_status(self, i: int, stamp: int) -> Any:
        names = (
            "reference_position",
            "reference_velocity",
            "proportional",
            "integral",
            "derivative",
            "wind_feedforward",
            "joystick",
            "transfer",
        )
        return self._make(
            KINDS["controller_status"],
            header=self._header(stamp),
            mode=self._word("controller_mode", i),
            axis_mode=["automatic"] * 3,
            status=self._word("controller_status", i),
            message="",
            setpoint_stamp=self._stamp(0),
            joystick_stamp=self._stamp(0),
            error=np.zeros(3),
            **{name: self._row(name, i) for name in names},
        )

    def _wrench_of(self, stamp: int, tau: Any) -> Any:
        x, y, n = (float(value) for value in tau)
        return self._make(
            KINDS["tau_desired"],
            header=self._header(stamp),
            wrench=self._make(
                "geometry_msgs/msg/Wrench", force=self._vector(x, y, 0.0), torque=self._vector(0.0, 0.0, n)
            ),
        )

    def _tau_desired(self, i: int, stamp: int) -> Any:
        return self._wrench_of(stamp, self._row("tau_desired", i))

    def _tau_achieved(self, i: int, stamp: int) -> Any:
        return self._wrench_of(stamp, self._row("tau_achieved", i))

    def _thruster_command(self, i: int, stamp: int) -> Any:
        return self._make(
            KINDS["thruster_command"],
            header=self._header(stamp),
            name=list(self._run.thrusters),
            thrust=self._row("thrust_command", i),
            azimuth=self._row("azimuth_command", i),
        )

    def _allocation_status(self, i: int, stamp: int) -> Any:
        flags = np.zeros(len(self._run.thrusters), dtype=bool)
        return self._make(
            KINDS["allocation_status"],
            header=self._header(stamp),
            status=self._word("allocation_status", i),
            azimuth_mode=self._word("azimuth_mode", i),
            performance_measure=self._gain("performance_measure", i),
            solver="daqp",
            cost=float(self._row("allocation_cost", i)[0]),
            slack=self._row("slack", i),
            demanded_power=0.0,
            rotating=self._row("rotating", i) > 0.5,
            thrust_saturated=flags,
            azimuth_saturated=flags,
            antispin="torque_loss" in self._run,
            torque_loss=self._row("torque_loss", i) if "torque_loss" in self._run else np.ones(len(flags)),
            sub_problem=int(self._row("sub_problem", i)[0]),
            crossing=self._row("crossing", i) > 0.5 if "crossing" in self._run else flags[:0],
            minimum_gain=self._gain("minimum_gain", i),
            minimum_gain_both_ways=self._gain("minimum_gain_both_ways", i),
            minimum_gain_free=self._gain("minimum_gain_free", i),
            method=self._word("method", i),
            feasible_load=self._gain("feasible_load", i),
            **{name: self._row(name, i) for name in ("tau_feasible", "tau_qp") if name in self._run},
        )

    def _gain(self, name: str, i: int) -> float:
        return float(self._row(name, i)[0]) if name in self._run else math.nan

    def _thruster_feedback(self, k: int, stamp: int) -> Any:
        return self._make(
            KINDS["thruster_feedback"],
            header=self._header(stamp),
            name=list(self._run.thrusters),
            shaft_speed=self._row("shaft_speed", k),
            torque=self._row("motor_torque", k),
            power=self._row("power", k),
            azimuth=self._row("azimuth", k),
            azimuth_rate=np.zeros(len(self._run.thrusters)),
            pitch_ratio=self._row("pitch_ratio", k),
        )

    def _actuator_setpoint(self, k: int, stamp: int) -> Any:
        return self._make(
            KINDS["actuator_setpoint"],
            header=self._header(stamp),
            command_stamp=self._stamp(stamp),
            command_stale=False,
            name=list(self._run.thrusters),
            torque=self._row("torque_setpoint", k),
            azimuth_rate=self._row("azimuth_rate_setpoint", k),
            pitch_ratio=self._row("pitch_ratio_setpoint", k),
            code=self._row("code", k).astype(np.int16) if "code" in self._run else np.zeros(0, dtype=np.int16),
        )

    def _ventilation(self, k: int, stamp: int) -> Any:
        return self._make(
            KINDS["ventilation"],
            header=self._header(stamp),
            name=list(self._run.thrusters),
            ventilating=self._row("ventilating", k) > 0.5,
            beta_q=self._row("beta_q", k),
            beta_q2=self._row("beta_q2", k),
        )
