"""Full message definitions."""

from __future__ import annotations

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from dp_tools.recorder.schemas import DefinitionMissingError, full_definition, nested_types

TEXTS = {
    ("ship_msgs", "Fleet"): (
        "# A comment with std_msgs/String in it\n"
        "uint8 LIMIT=5   # a constant\n"
        "string<=10 GREETING_TEXT\n"
        "std_msgs/Header header\n"
        "Ship[] ships # nested, same package\n"
        "geometry_msgs/Point[<=4] corners\n"
        "float64[3] plain\n"
        "string[<=3] names\n"
        "\n"
        "Ship flagship\n"
    ),
    ("ship_msgs", "Ship"): "geometry_msgs/Point position\nint32 number 7\nbuiltin_interfaces/Time built",
    ("std_msgs", "Header"): "builtin_interfaces/Time stamp\nstring frame_id\n",
    ("builtin_interfaces", "Time"): "int32 sec\nuint32 nanosec\n",
    ("geometry_msgs", "Point"): "float64 x\nfloat64 y\nfloat64 z\n",
}


def text_of(package: str, name: str) -> str:
    return TEXTS[(package, name)]


def test_nested_types_once_each_without_constants_and_built_ins() -> None:
    assert nested_types("ship_msgs", TEXTS[("ship_msgs", "Fleet")]) == [
        ("std_msgs", "Header"),
        ("ship_msgs", "Ship"),
        ("geometry_msgs", "Point"),
    ]


def test_every_definition_is_there_once_after_a_separator() -> None:
    text = full_definition("ship_msgs/msg/Fleet", text_of)
    parts = text.split("=" * 80 + "\n")
    assert parts[0] == TEXTS[("ship_msgs", "Fleet")]
    names = [part.splitlines()[0] for part in parts[1:]]
    assert names == [
        "MSG: std_msgs/Header",
        "MSG: ship_msgs/Ship",
        "MSG: geometry_msgs/Point",
        "MSG: builtin_interfaces/Time",
    ]


def test_another_parser_understands_the_text() -> None:
    found = get_types_from_msg(full_definition("ship_msgs/msg/Fleet", text_of), "ship_msgs/msg/Fleet")
    assert set(found) == {f"{package}/msg/{name}" for package, name in TEXTS}
    store = get_typestore(Stores.EMPTY)
    store.register(found)
    assert [field for field, _ in store.fielddefs["ship_msgs/msg/Fleet"][1]] == [
        "GREETING_TEXT",
        "header",
        "ships",
        "corners",
        "plain",
        "names",
        "flagship",
    ]


def test_a_missing_definition_is_named() -> None:
    with pytest.raises(DefinitionMissingError, match="message type no_such_msgs/msg/Nothing: no definition installed"):
        full_definition("no_such_msgs/msg/Nothing")
