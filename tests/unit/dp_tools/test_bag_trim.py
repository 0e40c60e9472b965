"""A part of a bag: what was sent in that time, and what was in force when it began."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from mcap.reader import make_reader
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterType, ParameterValue

from dp_tools.bags.bag import open_bag
from dp_tools.bags.check import check_bag
from dp_tools.bags.errors import BagError
from dp_tools.bags.parameters import parameters_at
from dp_tools.bags.trim import trim
from support.dp_here import Dp, dp_here
from support.made_bag import LATCHED, RELIABLE, RING_TOLD, START, make_bag, text_in

__all__ = ["dp_here"]

EVENT = "rcl_interfaces/msg/ParameterEvent"
AT_START = {"/**/node": {"ros__parameters": {"gain": 1.0, "mode": "a", "limits": [1.0, 2.0]}}}


def event(node: str, **values: Any) -> ParameterEvent:
    message = ParameterEvent(node=node)
    for name, value in values.items():
        told = ParameterValue()
        if isinstance(value, float):
            told.type, told.double_value = ParameterType.PARAMETER_DOUBLE, value
        elif isinstance(value, str):
            told.type, told.string_value = ParameterType.PARAMETER_STRING, value
        else:
            told.type, told.double_array_value = ParameterType.PARAMETER_DOUBLE_ARRAY, value
        message.changed_parameters.append(Parameter(name=name, value=told))
    return message


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    messages: list[Any] = [("/pose", 0.1 * k, f"pose {k}") for k in range(100)]
    messages += [("/mode", 1.0, "first"), ("/mode", 2.0, "second"), ("/mode", 7.0, "third")]
    messages += [("/setpoint", 1.5, "there"), ("/events", 1.5, "gone by")]
    messages += [
        ("/parameter_events", 1.0, event("/ship/node", gain=2.0)),
        ("/parameter_events", 2.0, event("/ship/node", gain=3.0, limits=[4.0])),
        ("/parameter_events", 2.5, event("/other/node", gain=9.0)),
        ("/parameter_events", 6.0, event("/ship/node", mode="b")),
    ]
    messages.sort(key=lambda message: message[1])
    quality = {"/mode": LATCHED, "/setpoint": RING_TOLD, "/pose": RING_TOLD, "/events": RELIABLE}
    attachments = {"vessel.yaml": b"name: v\n", "parameters/ship/node.yaml": yaml.safe_dump(AT_START).encode()}
    return make_bag(tmp_path / "bag", messages, {"/parameter_events": EVENT}, quality, attachments)


def found(path: Path) -> tuple[dict[str, list[tuple[float, str]]], dict[str, list[Any]]]:
    """Texts with publish times by topic; attachments by name."""
    texts: dict[str, list[tuple[float, str]]] = {}
    with open_bag(path) as opened:
        for row, number in enumerate(opened.messages.topic.tolist()):
            topic = opened.topics[number]
            at = (int(opened.messages.publish_time[row]) - START) * 1e-9
            word = text_in(opened.data(row)) if topic.kind.endswith("String") else ""
            texts.setdefault(topic.name, []).append((round(at, 6), word))
        attachments: dict[str, list[Any]] = {}
        for one in opened.attachments:
            attachments.setdefault(one.name, []).append(yaml.safe_load(one.data))
    return texts, attachments


def test_a_part_says_what_ran(bag: Path, tmp_path: Path) -> None:
    with open_bag(bag) as opened:
        done = trim(opened, tmp_path / "part", [topic.name for topic in opened.topics], start=3.0, until=8.0)
    texts, attachments = found(tmp_path / "part")
    assert texts["/pose"] == [(round(0.1 * k, 6), f"pose {k}") for k in range(30, 81)]
    # Depth 1 for late readers: the last one before the start; so of an untold depth, if nothing comes soon.
    assert texts["/mode"] == [(3.0, "second"), (7.0, "third")]
    assert texts["/setpoint"] == [(3.0, "there")]
    assert "/events" not in texts
    assert texts["/parameter_events"] == [(6.0, "")]
    assert attachments["vessel.yaml"] == [{"name": "v"}]
    assert attachments["parameters/ship/node.yaml"] == [
        {"/**/node": {"ros__parameters": {"gain": 3.0, "mode": "a", "limits": [4.0]}}}
    ]
    assert sorted(done.carried) == ["/mode", "/setpoint"]
    assert done.nodes == ["/ship/node"]
    assert check_bag(tmp_path / "part").whole
    with (tmp_path / "part" / "part_0.mcap").open("rb") as stream:
        records = {record.name: record.metadata for record in make_reader(stream).iter_metadata()}
    assert records["trimmed"]["begin"] == "3.000000000"
    assert records["trimmed"]["carried"] == "/setpoint, /mode"


def test_a_part_of_a_part_is_the_same_as_at_once(bag: Path, tmp_path: Path) -> None:
    with open_bag(bag) as opened:
        names = [topic.name for topic in opened.topics]
        trim(opened, tmp_path / "once", names, start=6.5, until=8.0)
        trim(opened, tmp_path / "part", names, start=2.2, until=9.0)
    with open_bag(tmp_path / "part") as opened:
        trim(opened, tmp_path / "twice", names, start=4.3, until=5.8)
    assert found(tmp_path / "twice") == found(tmp_path / "once")


def test_parameters_over_time(bag: Path) -> None:
    with open_bag(bag) as opened:
        gains = [parameters_at(opened, START + round(at * 1e9))[0].values["gain"] for at in (0.5, 1.5, 2.5)]
        assert gains == [1.0, 2.0, 3.0]
        assert parameters_at(opened, START - 1) == []


def test_chosen_topics_and_what_is_refused(dp_here: Dp, bag: Path, tmp_path: Path) -> None:
    part = tmp_path / "part"
    code, output = dp_here("bag", "trim", bag, "--output", part, "--topics", "pose", "--start", "1", "--until", "1.5")
    assert code == 0, output
    texts, _ = found(part)
    assert {name: len(words) for name, words in texts.items()} == {"/pose": 6, "/parameter_events": 1}
    for words, message in (
        (("--topics", "wind"), "--topics: expected a topic of the bag, found wind"),
        (("--start", "20"), "no message of these topics in that time; the bag is 9.900 s long"),
        (("--start", "1", "--sim-time"), "simulated time needs one clock, found none"),
        ((), "holds a recording, which is not overwritten unless asked for"),
    ):
        code, output = dp_here("bag", "trim", bag, "--output", part, *words)
        assert (code, output.count("\n")) == (1, 1), output
        assert message in output
    assert dp_here("bag", "trim", bag, "--output", part, "--overwrite")[0] == 0


def test_nothing_is_written_if_nothing_is_left(bag: Path, tmp_path: Path) -> None:
    with open_bag(bag) as opened, pytest.raises(BagError, match="no message of these topics"):
        trim(opened, tmp_path / "part", ["/pose"], start=50.0)
    assert not (tmp_path / "part").exists()
