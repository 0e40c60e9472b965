"""The supervisor as an executable: `ros2 run dp_bringup supervisor`."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import rclpy
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from dp_bringup.graph_lock import graph_lock
from dp_bringup.interrupts import Interrupts
from dp_bringup.parameter_file import read_parameter_file
from dp_bringup.processes import Children
from dp_bringup.supervisor.rules import Rules
from dp_bringup.supervisor.supervisor import SUPERVISOR, Supervisor
from dp_bringup.supervisor.unit import plan_units
from dp_bringup.workspace import share
from dp_node import RingExecutor
from marine_model.errors import DpError

T = TypeVar("T", bool, str, float, int)


class SupervisorRunningError(DpError):
    """A graph is there already."""


def main() -> None:
    """Look after a graph until SIGINT or SIGTERM."""
    sys.exit(run())


def run(args: list[str] | None = None) -> str | None:
    """Look after a graph until SIGINT or SIGTERM; return what went wrong, None if nothing did."""
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node(SUPERVISOR)
    executor = RingExecutor()
    executor.add_node(node)
    try:
        with graph_lock(os.environ.get("ROS_DOMAIN_ID", "0"), node.get_namespace()) as free:
            if not free:
                raise SupervisorRunningError(
                    f"namespace {node.get_namespace()}: expected no graph, found one that runs"
                )
            return _supervise(node, executor.spin_once)
    except DpError as error:
        return str(error)
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


def _supervise(node: Node, spin: Callable[..., None]) -> str | None:
    vessel = _parameter(node, "vessel", "cybership3", "Name or path of the vessel file, for all nodes")
    file = _parameter(node, "params_file", "", "ROS parameter file of the nodes; that of the launch file if empty")
    composed = _parameter(node, "composed", False, "All nodes in one process, restarted together")
    simulate = _parameter(node, "simulate", True, "Run the simulated vessel")
    folder = _parameter(node, "log_folder", "runs/supervisor", "Logs and parameter files of the processes go here")
    own: dict[str, Any] = {
        one.name: _parameter(node, one.name, getattr(Rules, one.name), _RULES[one.name]) for one in fields(Rules)
    }
    rules = Rules(**own)
    values: dict[str, dict[str, Any]] = read_parameter_file(
        Path(file) if file else share("dp_bringup") / "config" / "defaults.yaml"
    )
    plans = plan_units(composed, simulate)
    for plan in plans:
        for name in plan.nodes:
            values.setdefault(name, {})["vessel"] = vessel
    logs = Path(folder).absolute()
    children = Children(logs)
    names = ["-r", f"__ns:={node.get_namespace()}"] if node.get_namespace() != "/" else []
    problems: list[str] = []
    with Interrupts() as interrupts:
        try:
            supervisor = Supervisor(
                node, plans, children, logs, values, names, rules, node.get_logger().warning, interrupts.held_back
            )
            while True:
                supervisor.look()
                spin(timeout_sec=0.05)
        except KeyboardInterrupt:
            pass  # the way to stop
        finally:
            with interrupts.ignored():
                problems += children.stop()
    return "\n".join(problems) or None


def _parameter(node: Node, name: str, default: T, description: str) -> T:
    descriptor = ParameterDescriptor(description=description, read_only=True)
    value: T = node.declare_parameter(name, default, descriptor).value
    return value


_RULES = {
    "first_delay": "Back-off before the first restart [s]",
    "longest_delay": "Longest back-off [s]",
    "stable_after": "Time up after which the back-off begins anew [s]",
    "attempts": "Deaths within the window that are made good",
    "window": "Time in which deaths are counted [s]",
    "silent_after": "Time without a sign of life after which a node is said to be silent [s]",
    "hang_timeout": "Time without a sign of life after which it is killed [s]",
    "start_timeout": "Time that a process may take to come up [s]",
    "stop_timeout": "Time that a process may take to end when asked [s]",
}


if __name__ == "__main__":
    main()
