"""Parameters of a node as they are attached to a bag, and what changes make of them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterEvent, ParameterType, ParameterValue
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from dp_bringup.parameter_file import read_parameter_file
from dp_tools.recorder.parameter_snapshots import Snapshot, Snapshots, values_of

VALUES: dict[str, Any] = {
    "waves.height": 0.5,
    "enabled": True,
    "count": 3,
    "name": "no",
    "limits": [1.0, math.inf],
    "indices": [1, 2],
    "flags": [True, False],
    "words": ["a", "1e3"],
}


def messages(values: dict[str, Any]) -> list[Any]:
    return [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]


def read(tmp_path: Path, document: bytes) -> dict[str, dict[str, Any]]:
    (tmp_path / "parameters.yaml").write_bytes(document)
    return read_parameter_file(tmp_path / "parameters.yaml")


def snapshot_of(node: str, time: int, names: list[str], values: list[Any]) -> Snapshot:
    return Snapshot(node, time, values_of(names, values))


def event(node: str, **fields: Any) -> bytes:
    return bytes(serialize_message(ParameterEvent(node=node, **fields)))


def test_a_snapshot_is_a_parameter_file_of_everything_that_has_a_value(tmp_path: Path) -> None:
    answer = [message.value for message in messages(VALUES)]
    bytes_value = ParameterValue(type=ParameterType.PARAMETER_BYTE_ARRAY, byte_array_value=[b"\x01", b"\xff"])
    names = [*VALUES, "raw", "unset", "start_type_description_service"]
    snapshot = snapshot_of("/fleet/ship", 5, names, [*answer, bytes_value, ParameterValue(), answer[1]])
    assert snapshot.name == "parameters/fleet/ship.yaml"
    assert read(tmp_path, snapshot.document()) == {"ship": {**VALUES, "raw": [1, 255]}}


def test_changes_after_a_snapshot_are_in_the_next_file_and_those_before_are_not(tmp_path: Path) -> None:
    snapshots = Snapshots()
    one, two = messages({"gain": 1.0, "mode": "a"})
    snapshots.note(90, event("/ship", changed_parameters=messages({"gain": 0.0})))
    snapshots.add(snapshot_of("/ship", 100, ["gain", "mode"], [one.value, two.value]))
    snapshots.note(110, event("/ship", changed_parameters=messages({"gain": 2.0})))
    snapshots.note(120, event("/ship", new_parameters=messages({"more": [1, 2]})))
    snapshots.note(130, event("/other", changed_parameters=messages({"gain": 9.0})))
    (document,) = snapshots.at_present().values()
    assert read(tmp_path, document) == {"ship": {"gain": 2.0, "mode": "a", "more": [1, 2]}}

    snapshots.note(140, event("/ship", deleted_parameters=[ParameterMessage(name="more")]))
    assert read(tmp_path, snapshots.at_present()["parameters/ship.yaml"]) == {"ship": {"gain": 2.0, "mode": "a"}}

    # Its next life begins with what it was started with.
    snapshots.note(150, event("/ship", changed_parameters=messages({"gain": 3.0})))
    snapshots.add(snapshot_of("/ship", 160, ["gain"], [one.value]))
    assert read(tmp_path, snapshots.at_present()["parameters/ship.yaml"]) == {"ship": {"gain": 1.0}}
