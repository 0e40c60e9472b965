"""A graph in real time whose nodes are killed one after the other: each comes back, and the vessel with it."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from dp_msgs.msg import ControllerStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry

from dp_bringup.operator_node import Operator, operator
from dp_bringup.parameter_service import RemoteParameters
from dp_node import RING, RING_PUBLISHER, from_nanoseconds, to_nanoseconds
from dp_tools.bag_reader import read_bag
from dp_tools.limits import limits_violations
from marine_model import load_vessel
from marine_model.frames import MAP_FRAME, quaternion_to_heading, wrap_angle
from support.dp_command import DpProcess, own_domain
from support.dp_here import Dp, dp_here

__all__ = ["dp_here"]

pytestmark = [pytest.mark.timeout(300)]

NODES = ("dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers", "vessel_sim")
RATE = 4.0
SET_POINT = (0.3, -0.2, 0.2)  # m, m, rad; away from where controller and simulator begin
# In calm water the vessel keeps within 0.02 m and 0.02 rad; 0.1 is a fifth of the way that it has to come back.
ENVELOPE = 0.1  # m and rad
# Simulated. Its way from the origin to the set point takes 40 s; the rest is time to restart on a loaded machine.
BACK_WITHIN = 200.0  # s
LIVE = {
    "dp_observer": {"dead_reckoning_limit": 17.0},
    "dp_controller": {"transfer_time": 4.0},
    "thrust_allocator": {"longest_step": 3.0},
    "thruster_drivers": {"command_timeout": 1.5},
    "vessel_sim": {"setpoint_timeout": 2.0},
}


class Watch:
    """What a bystander sees of the graph."""

    def __init__(self, one: Operator) -> None:
        self.one = one
        self.truth: Any = None
        self.held = 0  # samples within the envelope in a row
        self.setpoint_stamp = 0
        self.supervisor: dict[str, str] = {}
        self.restarted: set[str] = set()
        node = one.node
        node.create_subscription(Odometry, "truth", self._on_truth, RING)
        node.create_subscription(ControllerStatus, "controller_status", self._on_status, RING)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, RING)
        self._setpoint = node.create_publisher(PoseStamped, "setpoint", RING_PUBLISHER)

    def _on_truth(self, message: Any) -> None:
        self.truth = message
        self.held = self.held + 1 if self.error() < ENVELOPE else 0

    def _on_status(self, message: Any) -> None:
        self.setpoint_stamp = to_nanoseconds(message.setpoint_stamp)

    def _on_diagnostics(self, message: Any) -> None:
        for status in message.status:
            if status.name == "supervisor":
                self.supervisor = {item.key: item.value for item in status.values}
                self.restarted |= {n for n in NODES if n in self.supervisor.get("alarm.SUPERVISOR-NODE-RESTARTED", "")}

    @property
    def time(self) -> float:
        return 0.0 if self.truth is None else to_nanoseconds(self.truth.header.stamp) * 1e-9

    def error(self) -> float:
        """Largest deviation from the set point, m or rad."""
        pose = self.truth.pose.pose
        q = pose.orientation
        heading = quaternion_to_heading(q.x, q.y, q.z, q.w)
        north, east, psi = SET_POINT
        return max(
            math.hypot(pose.position.x - north, pose.position.y - east),
            abs(wrap_angle(heading - psi)),
        )

    def order(self) -> None:
        """Give the set point, and wait until the controller has it."""
        message = PoseStamped()
        message.header.frame_id = MAP_FRAME
        message.header.stamp = from_nanoseconds(1_000_000)
        message.pose.position.x, message.pose.position.y = SET_POINT[:2]
        message.pose.orientation.z, message.pose.orientation.w = math.sin(SET_POINT[2] / 2), math.cos(SET_POINT[2] / 2)
        # Controller, supervisor and recorder: who is not there yet does not hear it.
        self.one.wait_until(lambda: self._setpoint.get_subscription_count() == 3, 20.0, "listeners of setpoint")
        self._setpoint.publish(message)
        self.one.wait_until(lambda: self.setpoint_stamp == 1_000_000, 20.0, "the controller to take the set point")

    def wait_until_held(self) -> None:
        """Wait until 25 samples in a row, 5 s, were within the envelope."""
        self.held = 0
        self.one.wait_until(
            lambda: self.held >= 25, BACK_WITHIN / RATE, f"the vessel within {ENVELOPE} of its set point"
        )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("supervision")


@pytest.fixture(scope="module")
def graph(folder: Path) -> Iterator[DpProcess]:
    with own_domain() as domain, pytest.MonkeyPatch.context() as patch:
        for name, value in domain.items():
            patch.setenv(name, value)
        with DpProcess("up", "--rate", str(RATE), "--record", "--hang-timeout", "5", "--output", folder) as process:
            process.wait_until(lambda: "running; Ctrl-C stops" in process.output, "the graph to run", timeout=150.0)
            yield process


@pytest.fixture(scope="module")
def watch(graph: DpProcess) -> Iterator[Watch]:
    with operator() as one:
        made = Watch(one)
        made.order()
        made.wait_until_held()
        yield made


def has_come_back(graph: DpProcess, watch: Watch, node: str, before: int) -> None:
    def up() -> bool:
        return (
            int(watch.supervisor.get(f"{node}.restarts", "0")) > before
            and watch.supervisor.get(f"{node}.phase") == "up"
        )

    watch.one.wait_until(up, 60.0, f"{node} to be up again; dp up said:\n{graph.output}")


@pytest.mark.parametrize("node", NODES)
def test_a_node_that_is_killed_comes_back_with_its_parameters_and_the_vessel_with_it(
    graph: DpProcess, watch: Watch, node: str
) -> None:
    RemoteParameters(watch.one, node).set(LIVE[node])
    watch.wait_until_held()
    began = watch.time
    graph.children()[node].send_signal(signal.SIGKILL)
    has_come_back(graph, watch, node, 0)
    up = watch.time
    watch.wait_until_held()
    print(f"{node}: up after {up - began:.1f} s, within the envelope after {watch.time - 5.0 - began:.1f} s")
    assert watch.time - began < BACK_WITHIN
    assert node in watch.restarted
    assert f"supervisor: {node} died (killed by SIGKILL); starting it again in " in graph.output
    assert RemoteParameters(watch.one, node).get(list(LIVE[node])) == LIVE[node]
    assert watch.setpoint_stamp == 1_000_000


def test_a_node_that_hangs_is_killed_and_comes_back(graph: DpProcess, watch: Watch) -> None:
    node = "dp_controller"
    before = int(watch.supervisor[f"{node}.restarts"])
    graph.children()[node].send_signal(signal.SIGSTOP)
    has_come_back(graph, watch, node, before)
    assert f"{node} is silent; it is killed unless it is heard of within 2 s" in graph.output
    assert f"{node}: silent for 5 s; killing it" in graph.output
    watch.wait_until_held()


def test_a_restart_that_an_operator_asks_for(graph: DpProcess, watch: Watch, dp_here: Dp) -> None:
    before = graph.children()["thrust_allocator"].pid
    assert dp_here("restart", "thrust_allocator") == (0, "thrust_allocator is up again\n")
    assert graph.children()["thrust_allocator"].pid != before
    code, output = dp_here("restart", "autopilot")
    assert code == 1
    assert "error: node: expected one of dp_observer, " in output
    watch.wait_until_held()


def test_ctrl_c_in_the_middle_of_a_back_off_leaves_nothing_and_no_limit_was_broken(
    graph: DpProcess, watch: Watch, folder: Path
) -> None:
    """Last: it ends the graph."""
    children = graph.children()
    assert set(children) == {*NODES, "recorder"}
    said = graph.output.count("dp_observer died")
    children["dp_observer"].send_signal(signal.SIGKILL)
    graph.wait_until(lambda: graph.output.count("dp_observer died") > said, "the supervisor to notice")
    graph.signal(signal.SIGINT)
    assert graph.wait() == 0, graph.output
    assert graph.left_behind() == []
    # Nor one that was started after somebody last looked.
    left = [each for each in psutil.process_iter(["cmdline"]) if str(folder) in " ".join(each.info["cmdline"] or [])]
    assert left == []
    checks = limits_violations(read_bag(folder / "bag").run, load_vessel("cybership3"))
    assert {check.limit for check in checks} == {
        "thrust",
        "thrust_rate",
        "azimuth_rate",
        "torque",
        "azimuth_motor_rate",
    }
    assert [check for check in checks if check.violations] == []
