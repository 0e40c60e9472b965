"""Which fields of which topics carry the series and words of a run: one table for writing bags and for reading them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from dp_tools.run_data import PROPULSION_TRUTH
from marine_model.frames import BODY_FRAME, MAP_FRAME

Source = tuple[str, int | None]  # series, and its column; None: a whole row in one array


@dataclass(frozen=True)
class RunTopic:
    """One topic.

    Parameters
    ----------
    name, kind
        Topic, and type of its messages.
    frame
        Frame in the header.
    numbers
        Series by field.
    orientation
        Field of a quaternion and the series whose third column is its heading; None without one.
    attitude
        Series whose second and third column are roll and pitch of that quaternion: of a submerged vehicle.
    words
        Label by text field.
    by_thruster
        True where ``name`` says which thrusters the arrays are about.
    only_if
        Flag by series: this series has a row where the flag is raised.
    only_finite
        Series that have a row where their numbers are finite.
    absent
        Numbers for fields whose series has no row; NaN and empty sequences for all others.
    constants
        Numbers of fields that no series tells of, for every thruster where it is a sequence; NaN, 0, false and empty
        sequences for all others.
    texts
        Texts that do not change.
    """

    name: str
    kind: str
    frame: str
    numbers: Mapping[str, Source]
    orientation: tuple[str, str] | None = None
    attitude: str = ""
    words: Mapping[str, str] = field(default_factory=dict)
    by_thruster: bool = False
    only_if: Mapping[str, str] = field(default_factory=dict)
    only_finite: frozenset[str] = frozenset()
    absent: Mapping[str, float] = field(default_factory=dict)
    constants: Mapping[str, float] = field(default_factory=dict)
    texts: Mapping[str, str | tuple[str, ...]] = field(default_factory=dict)

    @property
    def series(self) -> tuple[str, ...]:
        """Names of the series that it carries."""
        found = [series for series, _ in self.numbers.values()]
        if self.orientation is not None:
            found.append(self.orientation[1])
        return tuple(dict.fromkeys(found))

    @property
    def constant_series(self) -> tuple[str, ...]:
        """Those with a row in every message."""
        return tuple(name for name in self.series if name not in self.only_if and name not in self.only_finite)


def _whole(*names: str) -> dict[str, Source]:
    """Return series that have the names of their fields."""
    return {name: (name, None) for name in names}


def _wrench(series: str, vertical: str) -> dict[str, Source]:
    horizontal: dict[str, Source] = {
        f"wrench.{part}": (series, i) for i, part in enumerate(("force.x", "force.y", "torque.z"))
    }
    return horizontal | {f"wrench.{part}": (vertical, i) for i, part in enumerate(("force.z", "torque.x", "torque.y"))}


def _place(prefix: str, series: str, vertical: str) -> dict[str, Source]:
    return {
        f"{prefix}.position.x": (series, 0),
        f"{prefix}.position.y": (series, 1),
        f"{prefix}.position.z": (vertical, 0),
    }


_WRENCH_REST = {"wrench.force.z": 0.0, "wrench.torque.x": 0.0, "wrench.torque.y": 0.0}
_POSE_REST = {
    f"pose.{part}": 0.0 for part in ("pose.position.z", "pose.orientation.x", "pose.orientation.y", "covariance")
}
_TWIST_REST = {f"twist.{part}": 0.0 for part in ("twist.linear.z", "twist.angular.x", "twist.angular.y", "covariance")}
_IF_ASKED = ("performance_measure", "minimum_gain", "minimum_gain_both_ways", "minimum_gain_free")
_OF_METHODS = ("feasible_load", "tau_feasible", "tau_qp")

# In the order in which they travel.
TOPICS: tuple[RunTopic, ...] = (
    RunTopic(
        "truth",
        "nav_msgs/msg/Odometry",
        MAP_FRAME,
        _place("pose.pose", "truth_position", "vertical_truth"),
        orientation=("pose.pose.orientation", "truth_position"),
        attitude="vertical_truth",
        constants={**_POSE_REST, **_TWIST_REST},
        texts={"child_frame_id": BODY_FRAME},
    ),
    RunTopic(
        "propulsion_truth",
        "dp_msgs/msg/PropulsionTruth",
        BODY_FRAME,
        {name: (f"truth_{name}", None) for name in PROPULSION_TRUTH},
        by_thruster=True,
    ),
    RunTopic(
        "wind",
        "geometry_msgs/msg/Vector3Stamped",
        BODY_FRAME,
        {"vector.x": ("wind", 0), "vector.y": ("wind", 1)},
        constants={"vector.z": 0.0},
    ),
    RunTopic(
        "pose",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        MAP_FRAME,
        _place("pose.pose", "pose", "vertical_pose"),
        orientation=("pose.pose.orientation", "pose"),
        attitude="vertical_pose",
        constants=_POSE_REST,
    ),
    RunTopic(
        "odometry",
        "nav_msgs/msg/Odometry",
        MAP_FRAME,
        {
            **_place("pose.pose", "estimate_position", "vertical_estimate"),
            "twist.twist.linear.x": ("estimate_velocity", 0),
            "twist.twist.linear.y": ("estimate_velocity", 1),
            "twist.twist.angular.z": ("estimate_velocity", 2),
            "twist.twist.linear.z": ("vertical_velocity", 0),
            "twist.twist.angular.x": ("vertical_velocity", 1),
            "twist.twist.angular.y": ("vertical_velocity", 2),
        },
        orientation=("pose.pose.orientation", "estimate_position"),
        attitude="vertical_estimate",
        constants={**_POSE_REST, **_TWIST_REST},
        texts={"child_frame_id": BODY_FRAME},
    ),
    RunTopic(
        "observer_state",
        "dp_msgs/msg/ObserverState",
        MAP_FRAME,
        {
            "wave_frequency_position": ("wave_position", None),
            "bias": ("bias", None),
            "vertical_bias": ("vertical_bias", None),
        },
        words={"status": "observer_status"},
    ),
    RunTopic(
        "tau_desired",
        "geometry_msgs/msg/WrenchStamped",
        BODY_FRAME,
        _wrench("tau_desired", "vertical_desired"),
        constants=_WRENCH_REST,
    ),
    RunTopic(
        "controller_status",
        "dp_msgs/msg/ControllerStatus",
        BODY_FRAME,
        _whole(
            "reference_position",
            "reference_velocity",
            "proportional",
            "integral",
            "derivative",
            "wind_feedforward",
            "joystick",
            "transfer",
            "vertical_reference",
        ),
        words={"mode": "controller_mode", "status": "controller_status"},
        texts={"axis_mode": ("", "", "")},
    ),
    RunTopic(
        "thruster_command",
        "dp_msgs/msg/ThrusterCommand",
        BODY_FRAME,
        {"thrust": ("thrust_command", None), "azimuth": ("azimuth_command", None)},
        by_thruster=True,
    ),
    RunTopic(
        "tau_achieved",
        "geometry_msgs/msg/WrenchStamped",
        BODY_FRAME,
        _wrench("tau_achieved", "vertical_achieved"),
        constants=_WRENCH_REST,
    ),
    RunTopic(
        "allocation_status",
        "dp_msgs/msg/AllocationStatus",
        BODY_FRAME,
        {
            **_whole("slack", "torque_loss", *_IF_ASKED, *_OF_METHODS, "sub_problem", "rotating", "crossing"),
            "cost": ("allocation_cost", None),
        },
        words={"status": "allocation_status", "azimuth_mode": "azimuth_mode", "method": "method"},
        only_if={"torque_loss": "antispin"},
        only_finite=frozenset((*_IF_ASKED, *_OF_METHODS, "crossing")),
        absent={"torque_loss": 1.0},
    ),
    RunTopic(
        "thruster_feedback",
        "dp_msgs/msg/ThrusterFeedback",
        BODY_FRAME,
        {**_whole("shaft_speed", "power", "azimuth", "pitch_ratio"), "torque": ("motor_torque", None)},
        by_thruster=True,
        constants={"azimuth_rate": math.nan},
    ),
    RunTopic(
        "actuator_setpoint",
        "dp_msgs/msg/ActuatorSetpoint",
        BODY_FRAME,
        {
            "torque": ("torque_setpoint", None),
            "azimuth_rate": ("azimuth_rate_setpoint", None),
            "pitch_ratio": ("pitch_ratio_setpoint", None),
            "code": ("code", None),
        },
        by_thruster=True,
        only_finite=frozenset(("code",)),
    ),
    RunTopic(
        "ventilation",
        "dp_msgs/msg/Ventilation",
        BODY_FRAME,
        _whole("ventilating", "beta_q", "beta_q2"),
        by_thruster=True,
    ),
)
