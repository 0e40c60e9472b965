"""Writes a run that was sailed without middleware as the bag that the node graph would have left.

Topics, types, schemas and attachments are those of the recorder. What a run does not log is NaN, false or empty; topics
of which it knows nothing (diagnostics, the force of the environment) are not there. Log time is
simulated time from the start of the run, so that ``ros2 bag play`` plays it in real time.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dp_tools.cdr.bulk import serialized
from dp_tools.cdr.layout import layout_of
from dp_tools.cdr.types import types_of
from dp_tools.exact_heading import exact_quaternion
from dp_tools.recorder.attachments import SCENARIO_ATTACHMENT, VESSEL_ATTACHMENT, vessel_document
from dp_tools.recorder.bag_metadata import TopicInfo
from dp_tools.recorder.bag_writer import BagWriter
from dp_tools.recorder.schemas import full_definition
from dp_tools.run_data import RunData, RunInfo, Series, width
from dp_tools.run_parameters import (
    PARAMETER_EVENT,
    PARAMETER_EVENTS,
    parameter_attachments,
    parameter_changes,
    parameter_event,
)
from dp_tools.run_topics import TOPICS, RunTopic
from dp_tools.scenario import Event, Scenario, scenario_document
from dp_tools.six_axes import pose_parts, wrench_parts
from dp_tools.versions import VERSIONS_RECORD
from marine_model import Vessel
from marine_model.frames import BODY_FRAME, MAP_FRAME, attitude_to_quaternion
from marine_model.guards import FloatArray

# Name of the metadata record with who sailed what, how and how long.
RUN_RECORD = "run"

_NANOSECONDS = 1_000_000_000
# Log time between two messages of one stamp, so that a player sends them in the order in which they travel, ns.
_HOP = 1000
_OPERATOR_KINDS = {
    "setpoint": "geometry_msgs/msg/PoseStamped",
    "joystick": "geometry_msgs/msg/WrenchStamped",
    "path": "nav_msgs/msg/Path",
}
_CLOCK = "rosgraph_msgs/msg/Clock"
# What the graph's nodes offer, as rosbag2 writes it down; publishers do not tell their history to others.
_FOREVER = {"sec": 9223372036, "nsec": 854775807}
_OFFERED: Mapping[str, Any] = {
    "history": "unknown",
    "depth": 0,
    "reliability": "reliable",
    "durability": "transient_local",
    "deadline": _FOREVER,
    "lifespan": _FOREVER,
    "liveliness": "automatic",
    "liveliness_lease_duration": _FOREVER,
    "avoid_ros_namespace_conventions": False,
}
# Words of the observer under which its estimate means nothing.
_NOT_VALID = ("uninitialised", "invalid")

Stamps = NDArray[np.int64]


@dataclass(frozen=True)
class _Messages:
    """Messages of one topic in order of time; ``hops`` orders those of an operator among others of one stamp."""

    topic: str
    kind: str
    stamps: Stamps
    data: list[bytes]
    hops: Stamps | None = None


def write_bag(folder: Path, run: RunData, vessel: Vessel, scenario: Scenario | None, overwrite: bool = False) -> Path:
    """Write a bag and return its folder.

    Parameters
    ----------
    folder
        Of the bag; its name is that of the MCAP file.
    run
        What was logged.
    vessel, scenario
        What was sailed; attached, so that the bag alone is enough for a report.
    overwrite
        True to replace a bag that is there.

    Raises
    ------
    RecordingRefusedError
        If the folder holds something already or cannot be written, or a message definition is not installed.
    RecordingStoppedError
        If the disk is full.
    """
    kinds = {topic.kind for topic in TOPICS} | {*_OPERATOR_KINDS.values(), _CLOCK, PARAMETER_EVENT}
    definitions = {kind: full_definition(kind) for kind in sorted(kinds)}
    types = types_of(definitions)
    writer = BagWriter(folder, overwrite)
    start = _started(run.info)
    try:
        writer.attach(VESSEL_ATTACHMENT, "application/yaml", vessel_document(vessel), start)
        if scenario is not None:
            writer.attach(SCENARIO_ATTACHMENT, "application/yaml", scenario_document(scenario), start)
            for name, data in parameter_attachments(vessel, scenario).items():
                writer.attach(name, "application/yaml", data, start)
        writer.describe(VERSIONS_RECORD, run.info.versions)
        writer.describe(RUN_RECORD, {name: json.dumps(value) for name, value in asdict(run.info).items()})
        # The clock first: what belongs to a time follows it, as in the graph.
        everything = [
            *_clock(types, run, vessel),
            *_changes(types, vessel, scenario),
            *_operator(types, scenario),
            *_topics(types, run, vessel),
        ]
        channels = []
        for messages in everything:
            info = TopicInfo(f"/{messages.topic}", messages.kind, types.hash_rihs01(messages.kind), (_OFFERED,))
            channels.append(writer.add_topic(info, definitions[messages.kind]))
        _write(writer, channels, everything, start)
    finally:
        custom = {"recorder": "dp_tools", "lost_messages": "0", "vessel": vessel.name}
        if scenario is not None:
            custom["scenario"] = scenario.name
        writer.close(custom)
    return folder


def _write(writer: BagWriter, channels: list[int], everything: list[_Messages], start: int) -> None:
    """Write all messages in order of log time: their stamps, and with one stamp as they travel."""
    times = [messages.stamps + _HOP * hops for messages, hops in zip(everything, _all_hops(everything), strict=True)]
    order = np.argsort(np.concatenate(times), kind="stable")
    which = np.repeat(np.arange(len(everything)), [len(t) for t in times])[order].tolist()
    rows = np.concatenate([np.arange(len(t)) for t in times])[order].tolist()
    log_times = (np.concatenate(times)[order] + start).tolist()
    data = [messages.data for messages in everything]
    for topic, row, log_time in zip(which, rows, log_times, strict=True):
        writer.write(channels[topic], data[topic][row], log_time, log_time, row + 1)


def _all_hops(everything: list[_Messages]) -> Iterator[int | Stamps]:
    """Yield for every topic its place among those of one stamp; what operators did has places between the others."""
    hop = reach = 0
    for messages in everything:
        if messages.hops is None:
            hop = max(hop, reach)
            yield hop
            hop += 1
        else:
            yield hop + messages.hops
            reach = max(reach, hop + int(messages.hops.max()) + 1)


def _started(info: RunInfo) -> int:
    """Return the wall-clock start of a run, ns; 0 where it is not known."""
    return round(datetime.fromisoformat(info.started).timestamp()) * _NANOSECONDS if info.started else 0


def _nanoseconds(seconds: FloatArray) -> Stamps:
    return np.rint(seconds * 1e9).astype(np.int64)


# Topics of the ring --------------------------------------------------------------------------------------------------


def _topics(types: Any, run: RunData, vessel: Vessel) -> Iterator[_Messages]:
    for topic in TOPICS:
        told = [name for name in topic.constant_series if name in run]
        if told:
            stamps = np.unique(np.concatenate([_nanoseconds(run[name].t) for name in told]))
            yield _Messages(topic.name, topic.kind, stamps, _messages(types, topic, run, vessel, stamps))


def _messages(types: Any, topic: RunTopic, run: RunData, vessel: Vessel, stamps: Stamps) -> list[bytes]:
    """Return the messages of ``topic`` at ``stamps``, layout by layout."""
    columns = {name: _at(run[name], stamps) for name in topic.series if name in run}
    present = {name: np.asarray(np.isfinite(values).any(axis=1)) for name, values in columns.items()}
    words = {label: _word_numbers(run, label, stamps) for label in topic.words.values()}
    own = _own_fields(topic, run, vessel, stamps)
    keys = np.column_stack([np.zeros(len(stamps), dtype=np.intp), *words.values(), *present.values()])
    _, group = np.unique(keys, axis=0, return_inverse=True)
    data: list[bytes] = [b""] * len(stamps)
    for number in range(group.max() + 1):
        index = np.flatnonzero(group.ravel() == number)
        first = index[0]
        has = {name for name, there in present.items() if there[first]}
        texts: dict[str, Any] = {"header.frame_id": topic.frame, **topic.texts}
        texts |= {path: _word(run, label, words[label][first]) for path, label in topic.words.items()}
        if topic.by_thruster:
            texts["name"] = run.thrusters
        sizes = len(run.thrusters), len(run.degrees_of_freedom)
        counts = {path: width(series, *sizes) for path, (series, _) in topic.numbers.items() if series in has}
        counts |= {path: len(run.thrusters) for path in (*topic.absent, *topic.constants)}
        layout = layout_of(types, topic.kind, texts, counts)
        numbers: dict[str, Any] = {
            path: math.nan for path in layout.form.names or () if layout.form[path].base.kind == "f"
        }
        numbers |= {**topic.constants, **topic.absent}
        for path, (series, column) in topic.numbers.items():
            if series in has:
                values = columns[series][index]
                scalar = layout.form[path].subdtype is None
                numbers[path] = values[:, column or 0] if scalar else values
        numbers |= {flag: series in has for series, flag in topic.only_if.items()}
        numbers |= {path: values[index] for path, values in own.items()}
        numbers |= _header(stamps[index])
        for i, message in zip(index.tolist(), serialized(layout, len(index), numbers), strict=True):
            data[i] = message
    return data


def _header(stamps: Stamps, path: str = "header.stamp") -> dict[str, Any]:
    return {f"{path}.sec": stamps // _NANOSECONDS, f"{path}.nanosec": stamps % _NANOSECONDS}


def _at(series: Series, stamps: Stamps) -> FloatArray:
    """Return the rows of a series at ``stamps``; NaN where it has none."""
    own = _nanoseconds(series.t)
    if np.array_equal(own, stamps):
        return series.values
    index = np.minimum(np.searchsorted(own, stamps), len(own) - 1)
    return np.where((own[index] == stamps)[:, None], series.values[index], np.nan)


def _word_numbers(run: RunData, label: str, stamps: Stamps) -> NDArray[np.intp]:
    """Return which of a label's words holds at every stamp; -1 for none."""
    if label not in run.labels:
        return np.full(len(stamps), -1, dtype=np.intp)
    found: NDArray[np.intp] = np.searchsorted(_nanoseconds(run.labels[label].t), stamps, side="right") - 1
    return found


def _word(run: RunData, label: str, number: int) -> str:
    return run.labels[label].words[number] if number >= 0 else ""


def _own_fields(topic: RunTopic, run: RunData, vessel: Vessel, stamps: Stamps) -> dict[str, FloatArray]:
    """Return numbers that are worked out from a series, one a stamp."""
    numbers: dict[str, Any] = {}
    if topic.orientation is not None:
        path, series = topic.orientation
        position = _at(run[series], stamps)
        below = _at(run[topic.attitude], stamps) if topic.attitude in run else None
        if topic.name == "pose":
            numbers, position, below = _pose(vessel, position, below)
        if below is None:
            quaternions = np.array([exact_quaternion(heading) for heading in position[:, 2].tolist()])
            numbers |= {f"{path}.z": quaternions[:, 0], f"{path}.w": quaternions[:, 1]}
        else:
            attitudes = np.column_stack([below[:, 1:], position[:, 2]]).tolist()
            quaternions = np.array([attitude_to_quaternion(*attitude) for attitude in attitudes])
            numbers |= {f"{path}.{part}": quaternions[:, i] for i, part in enumerate("xyzw")}
    elif topic.name == "observer_state" and "observer_status" in run.labels:
        words = run.labels["observer_status"].words
        told = _word_numbers(run, "observer_status", stamps)
        numbers["valid"] = np.array([word not in _NOT_VALID for word in words])[np.maximum(told, 0)]
    elif topic.name == "actuator_setpoint" and "thrust_command" in run:
        commands = _nanoseconds(run["thrust_command"].t)
        newest = np.searchsorted(commands, stamps, side="right") - 1
        numbers |= _header(np.where(newest >= 0, commands[np.maximum(newest, 0)], 0), "command_stamp")
    return numbers


def _pose(
    vessel: Vessel, position: FloatArray, below: FloatArray | None
) -> tuple[dict[str, FloatArray], FloatArray, FloatArray | None]:
    """Return what a pose message says; a lost one is the last one, marked by covariance[0] = -1."""
    fix = np.asarray(np.isfinite(position).all(axis=1))
    newest = np.maximum.accumulate(np.where(fix, np.arange(len(fix)), -1))
    held: FloatArray = np.where((newest >= 0)[:, None], position[np.maximum(newest, 0)], 0.0)
    noise = vessel.measurement
    covariance = np.zeros((len(fix), 36))
    covariance[:, 0] = np.where(fix, noise.position_noise**2, -1.0)
    covariance[:, 7], covariance[:, 35] = noise.position_noise**2, noise.heading_noise**2
    numbers = {"pose.covariance": covariance, "pose.pose.position.x": held[:, 0], "pose.pose.position.y": held[:, 1]}
    if below is None:
        return numbers, held, None
    below = np.where((newest >= 0)[:, None], below[np.maximum(newest, 0)], 0.0)
    return numbers | {"pose.pose.position.z": below[:, 0]}, held, below


# Clock and operator --------------------------------------------------------------------------------------------------


def _clock(types: Any, run: RunData, vessel: Vessel) -> Iterator[_Messages]:
    """Every step of the simulator tells the time it has come to."""
    if "power" in run:
        stamps = _nanoseconds(run["power"].t) + round(vessel.simulation.time_step * 1e9)
        layout = layout_of(types, _CLOCK, {}, {})
        yield _Messages("clock", _CLOCK, stamps, serialized(layout, len(stamps), _header(stamps, "clock")))


def _hops(scenario: Scenario) -> dict[int, int]:
    """Return the first hop of every event by its number: events of one time come one after the other."""
    hops: dict[int, int] = {}
    before: dict[float, int] = {}
    for number, event in enumerate(scenario.events):
        hops[number] = before.get(event.at, 0)
        before[event.at] = hops[number] + len(event.parameters) + 1
    return hops


def _changes(types: Any, vessel: Vessel, scenario: Scenario | None) -> Iterator[_Messages]:
    """Yield what the nodes tell of the parameters that were changed."""
    if scenario is None:
        return
    stamps, data, hops, first = [], [], [], _hops(scenario)
    numbers = {id(event): number for number, event in enumerate(scenario.events)}
    for event, node, values in parameter_changes(vessel, scenario):
        stamp, number = round(event.at * 1e9), numbers[id(event)]
        stamps.append(stamp)
        data.append(bytes(types.serialize_cdr(parameter_event(types.types, stamp, node, values), PARAMETER_EVENT)))
        hops.append(first[number] + list(event.parameters).index(node))
    if stamps:
        yield _Messages(PARAMETER_EVENTS, PARAMETER_EVENT, _whole(stamps), data, _whole(hops))


def _operator(types: Any, scenario: Scenario | None) -> Iterator[_Messages]:
    """Yield what the operator sent: set points, joystick, paths."""
    if scenario is None:
        return
    first = _hops(scenario)
    for topic, kind in _OPERATOR_KINDS.items():
        stamps, data, hops = [], [], []
        for number, event in enumerate(scenario.events):
            if getattr(event, topic) is not None:
                stamp = max(1, round(event.at * 1e9))  # zero would mean: no input yet
                stamps.append(stamp)
                data.append(bytes(types.serialize_cdr(_Operator(types.types).message(topic, event, stamp), kind)))
                hops.append(first[number] + len(event.parameters))
        if stamps:
            yield _Messages(topic, kind, _whole(stamps), data, _whole(hops))


def _whole(numbers: list[int]) -> Stamps:
    return np.array(numbers, dtype=np.int64)


@dataclass(frozen=True)
class _Operator:
    """Makes the messages of an operator."""

    types: Mapping[str, Any]

    def message(self, topic: str, event: Event, stamp: int) -> Any:
        if topic == "setpoint" and event.setpoint is not None:
            return self._pose(stamp, event.setpoint)
        if topic == "joystick" and event.joystick is not None:
            vector = self.types["geometry_msgs/msg/Vector3"]
            push, turn = wrench_parts(event.joystick)
            wrench = self.types["geometry_msgs/msg/Wrench"](vector(*push), vector(*turn))
            return self.types["geometry_msgs/msg/WrenchStamped"](self._header(stamp, BODY_FRAME), wrench)
        poses = [self._pose(round(point.at * 1e9), point.position) for point in event.path or ()]
        return self.types["nav_msgs/msg/Path"](self._header(stamp, MAP_FRAME), poses)

    def _header(self, stamp: int, frame: str) -> Any:
        sec, nanosec = divmod(stamp, _NANOSECONDS)
        return self.types["std_msgs/msg/Header"](self.types["builtin_interfaces/msg/Time"](sec, nanosec), frame)

    def _pose(self, stamp: int, position: Sequence[float]) -> Any:
        point, quaternion = pose_parts(position)
        return self.types["geometry_msgs/msg/PoseStamped"](
            self._header(stamp, MAP_FRAME),
            self.types["geometry_msgs/msg/Pose"](
                self.types["geometry_msgs/msg/Point"](*point),
                self.types["geometry_msgs/msg/Quaternion"](*quaternion),
            ),
        )
