"""Restarts elsewhere than under `dp up` alone: in a scenario, of all nodes at once, by the executable."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from dp_msgs.msg import ControllerStatus

from dp_bringup.operator_node import Operator, operator
from dp_bringup.parameter_service import RemoteParameters
from dp_bringup.processes import Children
from dp_bringup.workspace import executable
from dp_node import RING
from dp_tools.bag_reader import read_bag
from support.dp_command import DpProcess, dp, write_scenario
from support.waiting import wait_until

pytestmark = [pytest.mark.timeout(300), pytest.mark.usefixtures("ros_domain_id")]

LIVE = {
    "dp_observer": {"dead_reckoning_limit": 17.0},
    "dp_controller": {"transfer_time": 4.0},
    "thrust_allocator": {"longest_step": 3.0},
    "thruster_drivers": {"command_timeout": 1.5},
    "vessel_sim": {"setpoint_timeout": 2.0},
}


def test_a_node_restarted_in_a_scenario_is_said_and_judged_until_then(tmp_path: Path) -> None:
    """The scenario goes on: the set point after the restart is followed, and the run ends as any."""
    events = [{"at": 0.0, "setpoint": [0.0, 0.0, 0.0]}, {"at": 60.0, "setpoint": [0.2, 0.0, 0.0]}]
    scenario = write_scenario(tmp_path, duration=62.0, events=events)
    folder = tmp_path / "run"
    with (
        DpProcess("up", "--scenario", scenario, "--rate", "5", "--record", "--output", folder) as process,
        operator() as one,
    ):
        heard: list[ControllerStatus] = []
        one.node.create_subscription(ControllerStatus, "controller_status", heard.append, RING)

        def until(condition: Callable[[], object], what: str) -> None:
            def done() -> bool:
                one.executor.spin_once(timeout_sec=0.05)
                return bool(condition())

            process.wait_until(done, what, timeout=120.0)

        until(lambda: len(heard) > 25, "5 s to be sailed")
        process.children()["dp_observer"].send_signal(signal.SIGKILL)
        until(lambda: "dp_observer is up again" in process.output, "dp_observer to be up again")
        assert process.wait() == 0, process.output
        assert "dp_observer died (killed by SIGKILL); starting it again in 1 s" in process.output
    assert read_bag(folder / "bag").run["reference_position"].values[-1, 0] > 0.01
    code, said = dp("replay", folder / "bag", "--into", "dp_observer", "--verify")
    assert code == 0, said
    assert "dp_observer: identical: " in said
    assert "; restarted at " in said


def test_the_executable_brings_all_up_in_one_process_and_again_with_its_last_parameters(tmp_path: Path) -> None:
    children = Children(tmp_path)
    child = children.start(
        "supervisor",
        [
            *(executable("dp_bringup", "supervisor"), "--ros-args"),
            *("-p", "composed:=true", "-p", f"log_folder:={tmp_path / 'logs'}", "-p", "first_delay:=0.1"),
        ],
    )
    log = tmp_path / "supervisor.log"
    try:
        with operator() as one:
            said = _Supervisor(one)

            def until(condition: Callable[[], object], what: str) -> None:
                def done() -> bool:
                    children.check()
                    one.executor.spin_once(timeout_sec=0.05)
                    return bool(condition())

                wait_until(done, timeout=120.0, message=lambda: f"{what}; {said.values}; {log.read_text()}")

            until(lambda: said.values.get("composed.phase") == "up", "the graph")
            for node, values in LIVE.items():
                RemoteParameters(one, node).set(values)
            process = next(each for each in _descendants(child.pid) if "composed" in " ".join(each.cmdline()))
            process.send_signal(signal.SIGKILL)
            until(
                lambda: said.values.get("composed.restarts") == "1" and said.values["composed.phase"] == "up",
                "the graph to be up again",
            )
            assert "killed by SIGKILL" in said.values["composed.last_end"]
            for node, values in LIVE.items():
                assert RemoteParameters(one, node).get(list(values)) == values
            left = _descendants(child.pid)
            child.request_stop(signal.SIGINT)
            wait_until(lambda: child.exit_code is not None, timeout=60.0, message=log.read_text)
            assert child.exit_code == 0, log.read_text()
            assert [each for each in left if each.is_running()] == []
    finally:
        children.stop()


class _Supervisor:
    def __init__(self, one: Operator) -> None:
        self.values: dict[str, str] = {}
        one.node.create_subscription(DiagnosticArray, "/diagnostics", self._hear, RING)

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "supervisor":
                self.values = {item.key: item.value for item in status.values}


def _descendants(pid: int) -> list[Any]:
    import psutil

    return psutil.Process(pid).children(recursive=True)
