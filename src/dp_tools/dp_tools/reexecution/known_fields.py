"""What a bag of a run in process tells: its loop logs some fields of some messages, and only those are compared."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from dp_tools.reexecution.detached import Caught
from dp_tools.reexecution.feeder import CHANGE, END
from dp_tools.reexecution.fields import Value, flat
from dp_tools.run_topics import TOPICS
from marine_model.frames import quaternion_to_heading

_BY_NAME = {topic.name: topic for topic in TOPICS}
_HEADER = ("header.stamp.sec", "header.stamp.nanosec", "header.frame_id")
# Told by the bag beside what its table of topics says.
_BESIDE = {
    "actuator_setpoint": ("command_stamp.sec", "command_stamp.nanosec"),
    "observer_state": ("valid",),
    "pose": ("pose.covariance",),
    "clock": ("clock.sec", "clock.nanosec"),
}

# Answers between two samples, which a run in process does not log.
_BETWEEN = {
    "controller_status": ("setpoint", "joystick", "path", CHANGE, END),
    "actuator_setpoint": ("thruster_command", END),
}

Pick = Callable[[Any], dict[str, Value]]


def whole(message: Any) -> dict[str, Value]:
    """Return every field of a message by path."""
    return dict(flat(message))


def told_in_process(topic: str) -> Pick:
    """Return what takes out of a message of ``topic`` the fields that a bag of a run in process tells, by path.

    A heading stands for its quaternion: the bag has one that gives it back, which need not be the one that was sent.
    """
    told = _BY_NAME.get(topic)
    paths = {*_HEADER, *_BESIDE.get(topic, ())}
    heading = ""
    if told is not None:
        paths |= {*told.numbers, *told.words, *told.only_if.values()}
        paths |= {path for path, text in told.texts.items() if isinstance(text, str) and text}
        if told.by_thruster:
            paths.add("name")
        if told.orientation is not None:
            heading = told.orientation[0]

    def pick(message: Any) -> dict[str, Value]:
        values: dict[str, Value] = {}
        quaternion: dict[str, float] = {}
        for path, value in flat(message):
            if path.partition("[")[0] in paths:
                values[path] = value
            elif heading and path.startswith(heading):
                quaternion[path[-1]] = float(value)
        if heading:
            values[heading] = quaternion_to_heading(*(quaternion[part] for part in "xyzw"))
        return values

    return pick


def logged_in_process(found: Caught) -> bool:
    """Return whether a run in process logs such a message: those between two samples it does not."""
    return found.cause not in _BETWEEN.get(found.topic, ())


def tells(value: Value) -> bool:
    """Return whether a value of such a bag tells anything: what a run did not log is NaN or an empty text."""
    return value != "" and not (isinstance(value, float) and math.isnan(value))
