"""What the recorder says of itself."""

from __future__ import annotations

from dp_node import Health, Level
from dp_tools.recorder.recorder_health import RecorderState, health_of


def codes(health: Health) -> list[str]:
    return [alarm.kind.code for alarm in health.alarms]


def test_a_recording_that_goes_well() -> None:
    health = health_of(RecorderState(messages=12, topics=3, size=4096, files=1))
    assert (health.level, health.message, health.alarms) == (Level.OK, "recording", ())
    assert health.values == {"messages": 12, "topics": 3, "bytes": 4096, "files": 1, "lost": 0}


def test_lost_messages_and_parameters_are_warnings_that_name_where() -> None:
    health = health_of(RecorderState(lost={"/pose": 2, "/odometry": 5}, silent=("dp_observer",)))
    assert (health.level, codes(health)) == (Level.WARN, ["RECORDER-MESSAGES-LOST", "RECORDER-PARAMETERS-MISSING"])
    assert [alarm.detail for alarm in health.alarms] == ["on /pose, /odometry", "dp_observer"]
    assert (health.values["lost"], health.values["lost /odometry"]) == (7, 5)


def test_a_recording_that_has_stopped_says_why() -> None:
    full = health_of(RecorderState(failed="no space left", disk_full=True))
    assert (full.level, codes(full)) == (Level.ERROR, ["RECORDER-DISK-FULL"])
    assert full.message.endswith("no space left")
    assert codes(health_of(RecorderState(failed="input/output error"))) == ["RECORDER-WRITE-FAILED"]
