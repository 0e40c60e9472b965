"""What an operator does with `dp` while a graph runs: look at parameters and topics, change, save and load them."""

from __future__ import annotations

import json
import re
import signal
from array import array
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from dp_msgs.msg import ActuatorSetpoint, AllocationStatus, ControllerStatus, ThrusterCommand

from dp_bringup.operator_node import Operator, operator
from dp_bringup.parameter_file import read_parameter_file
from dp_bringup.parameter_service import ParameterRefusedError, RemoteParameters
from dp_node import RING, RING_PUBLISHER, from_nanoseconds, to_nanoseconds
from dp_node.quality import Promise, offered
from dp_tools.node_settings import default_settings
from marine_model import load_vessel
from marine_model.frames import BODY_FRAME
from marine_model.settings import parameters_of
from marine_model.yaml_document import parse_value
from support.dp_command import DpProcess, own_domain
from support.dp_here import Dp, dp_here

__all__ = ["dp_here"]

pytestmark = [pytest.mark.timeout(200), pytest.mark.usefixtures("graph")]

NODES = ("dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers", "vessel_sim")


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DpProcess]:
    """The graph as `dp up` starts it: no scenario, real time, until Ctrl-C."""
    folder = tmp_path_factory.mktemp("operator")
    with own_domain() as domain, pytest.MonkeyPatch.context() as patch:
        for name, value in domain.items():
            patch.setenv(name, value)
        with DpProcess("up", "--composed", "--record", "--output", folder) as process:
            process.wait_until(lambda: "running; Ctrl-C stops" in process.output, "the graph to run")
            process.children()
            yield process
            process.signal(signal.SIGINT)
            assert process.wait() == 0, process.output
            assert process.left_behind() == []
            assert (folder / "bag" / "metadata.yaml").is_file()
            assert str(folder / "bag") in process.output


@pytest.fixture(scope="module")
def one(graph: DpProcess) -> Iterator[Operator]:
    """A node of our own, which need not discover the graph for each test anew."""
    with operator() as made:
        yield made


def values(one: Operator, node: str) -> dict[str, Any]:
    return RemoteParameters(one, node).get()


def newest(one: Operator, kind: Any, topic: str, wanted: Any) -> Any:
    """Return the first message on ``topic`` that is as ``wanted``."""
    heard: list[Any] = []
    subscription = one.node.create_subscription(kind, topic, heard.append, RING)
    one.wait_until(lambda: any(wanted(message) for message in heard), 20.0, f"such a message on {topic}")
    one.node.destroy_subscription(subscription)
    return next(message for message in heard if wanted(message))


def test_the_whole_graph_on_one_screen_and_as_json(dp_here: Dp, graph: DpProcess) -> None:
    code, output = dp_here("status", "--json")
    assert code == 0, output
    told = json.loads(output)
    assert (told["vessel_name"], told["vessel"]["mode"]) == ("cybership3", "setpoint")
    assert told["vessel"]["position"] == pytest.approx([0.0, 0.0, 0.0], abs=0.5)  # nothing pushes
    assert told["simulated_time"] > 0.0
    assert told["margins"]["status"] == "optimal"
    assert [row["name"] for row in told["thrusters"]] == list(load_vessel("cybership3").thruster_names)
    assert all(row["thrust"] is not None and row["shaft_speed"] is not None for row in told["thrusters"])
    nodes = {node["name"]: node for node in told["nodes"]}
    assert {*NODES, "recorder"} <= set(nodes)
    assert all(nodes[name]["state"] == "active" for name in NODES)
    # In real time a sample comes every 0.2 s; a busy machine may be slow, and a stopped graph has no rate at all.
    assert all(nodes[name]["rate"] > 1.0 for name in NODES)
    code, output = dp_here("status", "--once")
    assert code == 0, output
    assert "cybership3" in output.splitlines()[0]
    assert "recording" in output.splitlines()[0]
    assert all(name in output for name in (*NODES, "Margins", "azimuth_starboard"))


def test_a_screen_of_a_namespace_without_a_graph_is_a_line_that_says_where_there_is_one(dp_here: Dp) -> None:
    code, output = dp_here("status", "--once", "--namespace", "nowhere")
    assert (code, output.strip()) == (1, "error: no graph in namespace /nowhere; there are nodes in /")


def test_the_graph_without_scenario_is_that_of_the_launch_file(dp_here: Dp) -> None:
    assert dp_here("param", "get", "dp_controller", "mode") == (0, "mode: setpoint\n")
    assert dp_here("param", "get", "thrust_allocator", "azimuth_mode", "vessel") == (
        0,
        "azimuth_mode: rotating\nvessel: cybership3\n",
    )


def test_list_shows_every_parameter_with_its_meaning(dp_here: Dp) -> None:
    code, output = dp_here("param", "list")
    assert code == 0
    for node, settings in default_settings(load_vessel("cybership3")).items():
        assert node in output
        for name in parameters_of(settings):
            assert name in output
    code, output = dp_here("param", "list", "vessel_sim")
    (amplitude,) = [line for line in output.splitlines() if "waves.amplitude" in line]
    assert "0 .." in amplitude
    assert "[m]" in amplitude
    assert "dp_controller" not in output


def test_a_mode_switched_live_takes_effect(dp_here: Dp, one: Operator) -> None:
    for mode in ("fixed", "rotating"):
        code, output = dp_here("param", "set", "thrust_allocator", "azimuth_mode", mode)
        assert (code, output) == (0, f"thrust_allocator: azimuth_mode = {mode}\n")
        newest(one, AllocationStatus, "allocation_status", lambda message, mode=mode: message.azimuth_mode == mode)


def test_a_change_of_mode_is_answered_by_the_controller(dp_here: Dp, one: Operator) -> None:
    try:
        assert dp_here("param", "set", "dp_controller", "mode", "standby")[0] == 0
        message = newest(one, ControllerStatus, "controller_status", lambda message: message.mode == "standby")
        assert list(message.axis_mode) == ["off"] * 3
    finally:
        assert dp_here("param", "set", "dp_controller", "mode", "setpoint")[0] == 0


def test_a_whole_number_does_for_a_real_one(dp_here: Dp, one: Operator) -> None:
    before = values(one, "vessel_sim")["waves.direction"]
    try:
        assert dp_here("param", "set", "vessel_sim", "waves.direction", "1") == (0, "vessel_sim: waves.direction = 1\n")
        assert values(one, "vessel_sim")["waves.direction"] == 1.0
    finally:
        assert dp_here("param", "set", "vessel_sim", "waves.direction", before)[0] == 0


@pytest.mark.parametrize(
    ("node", "words", "reason"),
    [
        ("thrust_allocator", ("azimuth_mode", "sideways"), "azimuth_mode: Input should be 'fixed', 'rotating'"),
        ("thrust_allocator", ("thruster_enabled", "[true]"), "thruster_enabled: expected 4 elements"),
        ("thrust_allocator", ("solver", "guess"), "guess"),
        ("dp_controller", ("mode", "autopilot"), "found 'autopilot'"),
        ("vessel_sim", ("waves.amplitude", "-1.0"), "out of range"),
        ("vessel_sim", ("waves.amplitude", "high"), "Wrong parameter type"),
        ("vessel_sim", ("waves.amplitude", ".nan"), "range"),
        ("vessel_sim", ("rate", "0.0"), "rate: expected above 0 unless lockstep is on, found 0.0"),
        ("vessel_sim", ("seed", "5"), "read-only"),
        ("dp_observer", ("vessel", "cybership3_ch7"), "read-only"),
        ("dp_observer", ("gain", "2.0"), "no parameter gain; known: "),
    ],
)
def test_a_refused_value_gives_the_reason_and_keeps_the_old_one(
    one: Operator, node: str, words: tuple[str, str], reason: str
) -> None:
    before = values(one, node)
    with pytest.raises(ParameterRefusedError, match=re.escape(reason)) as refused:
        RemoteParameters(one, node).set({words[0]: parse_value(words[1])})
    assert str(refused.value).startswith(f"node {node}: ")
    assert values(one, node) == before


def test_a_refusal_is_one_plain_text_and_exit_code_one(dp_here: Dp) -> None:
    code, output = dp_here("param", "set", "thrust_allocator", "azimuth_mode", "sideways")
    assert code == 1
    assert output.startswith("error: node thrust_allocator: azimuth_mode: Input should be 'fixed', 'rotating'")
    assert "Traceback" not in output


def test_all_values_of_one_command_are_set_or_none(dp_here: Dp, one: Operator) -> None:
    before = values(one, "vessel_sim")
    code, output = dp_here("param", "set", "vessel_sim", "waves.amplitude", "0.02", "waves.period", "-3.0")
    assert code == 1
    assert "waves.period" in output or "range" in output
    assert values(one, "vessel_sim") == before
    try:
        assert dp_here("param", "set", "vessel_sim", "waves.amplitude", "0.02", "waves.period", "1.5")[0] == 0
        assert values(one, "vessel_sim") == before | {"waves.amplitude": 0.02, "waves.period": 1.5}
    finally:
        with operator() as one:
            RemoteParameters(one, "vessel_sim").set(
                {name: before[name] for name in ("waves.amplitude", "waves.period")}
            )


def test_what_was_dumped_can_be_loaded(dp_here: Dp, one: Operator, tmp_path: Path) -> None:
    file = tmp_path / "saved.yaml"
    assert dp_here("param", "dump", "--output", file) == (0, "")
    saved = read_parameter_file(file)
    assert set(saved) == set(NODES)
    assert {node: values(one, node) for node in NODES} == saved
    for node, name, value in (
        ("dp_observer", "dead_reckoning_limit", "17.5"),
        ("dp_controller", "transfer_time", "4.5"),
        ("thrust_allocator", "thruster_enabled", "[true, true, false, true]"),
        ("thruster_drivers", "command_timeout", "1.5"),
        ("vessel_sim", "waves.direction", "1.25"),
    ):
        assert saved[node][name] != parse_value(value)
        assert dp_here("param", "set", node, name, value)[0] == 0
    assert not any(values(one, node) == saved[node] for node in NODES)
    code, output = dp_here("param", "load", file)
    assert code == 0, output
    assert {node: values(one, node) for node in NODES} == saved
    # One node, to standard output, in the format of ROS parameter files.
    code, output = dp_here("param", "dump", "vessel_sim")
    assert code == 0
    assert yaml.safe_load(output) == {"/**/vessel_sim": {"ros__parameters": saved["vessel_sim"]}}


def test_a_file_with_a_bad_value_changes_nothing_in_that_node(dp_here: Dp, one: Operator, tmp_path: Path) -> None:
    before = values(one, "vessel_sim")
    file = tmp_path / "bad.yaml"
    for content, reason in (
        ({"waves.amplitude": 0.03, "waves.period": -1.0}, "range"),
        ({"waves.amplitude": 0.03, "seed": before["seed"] + 1}, "read-only while running: seed is "),
        ({"waves": {"amplitude": 0.03, "colour": "blue"}}, "no parameter waves.colour"),
    ):
        file.write_text(yaml.safe_dump({"vessel_sim": {"ros__parameters": content}}), encoding="utf-8")
        code, output = dp_here("param", "load", file)
        assert code == 1
        assert reason in output
        assert values(one, "vessel_sim") == before
    file.write_text("vessel_sim:\n  waves.amplitude: 0.03\n", encoding="utf-8")
    code, output = dp_here("param", "load", file)
    assert code == 1
    assert f"{file}:" in output
    assert "expected one mapping ros__parameters" in output


class Drivers:
    """What the drivers say and do, and the newest command of the allocator."""

    def __init__(self, one: Operator) -> None:
        self.said: dict[str, str] = {}
        self.acknowledged: set[int] = set()  # ns
        self.newest = 0  # ns
        node = one.node
        node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, RING)
        node.create_subscription(ActuatorSetpoint, "actuator_setpoint", self._on_setpoint, RING)
        node.create_subscription(ThrusterCommand, "thruster_command", self._on_command, RING)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "thruster_drivers":
                self.said = {item.key: item.value for item in status.values} | {"level": str(status.level[0])}

    def _on_setpoint(self, message: ActuatorSetpoint) -> None:
        self.acknowledged.add(to_nanoseconds(message.command_stamp))

    def _on_command(self, message: ThrusterCommand) -> None:
        self.newest = max(self.newest, to_nanoseconds(message.header.stamp))


@pytest.mark.parametrize(
    ("quality", "alarm"),
    [(RING_PUBLISHER, "NODE-QOS-INCOMPATIBLE"), (offered("thruster_command", Promise()), "NODE-SECOND-PUBLISHER")],
    ids=["clumsy", "hostile"],
)
def test_a_second_publisher_of_commands_is_alarmed_and_not_heard(one: Operator, quality: Any, alarm: str) -> None:
    """It sends full thrust, stamped a nanosecond after the allocator's commands; the hostile one as a node of ours."""
    vessel = load_vessel("cybership3")
    drivers = Drivers(one)
    one.wait_until(lambda: bool(drivers.newest and drivers.said and drivers.acknowledged), 20.0, "the graph")
    assert "alarm.NODE-SECOND-PUBLISHER" not in drivers.said
    before = int(drivers.said["refused_of_others"])
    intruder = one.node.create_publisher(ThrusterCommand, "thruster_command", quality)
    hostile = alarm == "NODE-SECOND-PUBLISHER"
    sent: set[int] = set()

    def refused() -> bool:
        stamp = drivers.newest + 1
        # Once it is known to the drivers: what is sent before that is not refused but never arrives.
        if f"alarm.{alarm}" in drivers.said and len(sent) < 5 and stamp not in sent:
            message = ThrusterCommand(name=list(vessel.thruster_names), thrust=array("d", vessel.thrust_max))
            message.azimuth = array("d", vessel.fixed_direction)
            message.header.frame_id = BODY_FRAME
            message.header.stamp = from_nanoseconds(stamp)
            intruder.publish(message)
            sent.add(stamp)
        return len(sent) == 5 and int(drivers.said["refused_of_others"]) == before + 5 * hostile

    one.wait_until(refused, 60.0, "all messages to be refused")
    if hostile:
        told = drivers.said["alarm.NODE-SECOND-PUBLISHER"]
        assert f"thruster_command, from thrust_allocator, {one.node.get_name()}; heard is thrust_allocator" in told
    assert drivers.said["level"] == "2"
    last = max(sent)
    one.wait_until(lambda: max(drivers.acknowledged) > last, 20.0, "a command of the allocator to be acknowledged")
    assert drivers.acknowledged.isdisjoint(sent)
    one.node.destroy_publisher(intruder)
    one.wait_until(lambda: "alarm.NODE-SECOND-PUBLISHER" not in drivers.said, 20.0, "the alarm to end")


def test_topics_lists_the_graph(dp_here: Dp) -> None:
    code, output = dp_here("topics")
    assert code == 0
    lines = {line.split()[1]: line for line in output.splitlines() if line.startswith("│ /")}
    assert "dp_msgs/ThrusterCommand" in lines["/thruster_command"]
    assert "thrust_allocator → recorder, thruster_drivers" in lines["/thruster_command"]
    assert {"/pose", "/odometry", "/tau_desired", "/tau_achieved", "/actuator_setpoint", "/clock"} <= set(lines)
    assert "/rosout" not in lines
    assert "/rosout" in dp_here("topics", "--all")[1]


def test_topics_counts_messages(dp_here: Dp) -> None:
    code, output = dp_here("topics", "--rate", "1")
    assert code == 0
    (pose,) = [line for line in output.splitlines() if line.startswith("│ /pose ")]
    # 5 Hz in real time; within one second 3 to 7 on a machine that stumbles.
    assert 3.0 <= float(pose.split("│")[-2]) <= 7.0


def test_a_node_that_is_not_there(dp_here: Dp) -> None:
    code, output = dp_here("param", "get", "dp_autopilot", "mode")
    assert code == 1
    assert "error: node dp_autopilot: " in output
    assert "is it running? (dp topics shows the graph)" in output


def test_a_namespace_without_a_graph(dp_here: Dp) -> None:
    code, output = dp_here("param", "list", "--namespace", "nowhere")
    assert code == 1
    assert "no node of the graph in namespace /nowhere; is it running?" in output
    assert dp_here("topics", "--namespace", "nowhere")[0] == 1
    code, output = dp_here("topics", "--namespace", "no where")
    assert (code, output) == (1, "error: namespace: expected one such as 'ship' or 'fleet/ship', found 'no where'\n")
