"""Main function of the node executables."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Sequence
from types import FrameType

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from dp_node.executor import RingExecutor
from dp_node.hand_over import hand_over
from dp_node.node import DpNode
from marine_model.errors import DpError

# A process that starts others puts its process id here: they end when it does, however it ends.
PARENT_VARIABLE = "DP_PARENT_PID"


class Stop:
    """Set by SIGINT and SIGTERM, and by the end of the parent that asked for it; ask it in a loop."""

    def __init__(self) -> None:
        self._signalled = False
        self._parent = int(os.environ.get(PARENT_VARIABLE) or 0)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._handle)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self._signalled = True

    @property
    def requested(self) -> bool:
        """True once the process shall end."""
        return self._signalled or (self._parent > 0 and os.getppid() != self._parent)


def run_nodes(make: Sequence[Callable[[], Node]], args: Sequence[str] | None = None) -> int:
    """Run nodes in this process until SIGINT or SIGTERM; return the exit code.

    A node that cannot start says why in one line on standard error; exit code 1.
    """
    # Our own signal handling: rclpy's would close the context before the last messages are out.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    stop = Stop()
    executor = RingExecutor()
    nodes: list[Node] = []
    try:
        for make_one in make:
            nodes.append(make_one())
            executor.add_node(nodes[-1])
        for node in nodes:
            if isinstance(node, DpNode):
                node.start()
        while not stop.requested:
            executor.spin_once(timeout_sec=0.1)
        return 0
    except DpError as error:
        print(f"{error}", file=sys.stderr)
        return 1
    finally:
        _close(executor, nodes)


def run_node(make: Callable[[], Node]) -> None:
    """Run one node and exit the process."""
    sys.exit(run_nodes([make]))


def _close(executor: RingExecutor, nodes: list[Node]) -> None:
    for node in nodes:
        if isinstance(node, DpNode) and node.active:
            node.trigger_shutdown()
    hand_over(publisher for node in nodes for publisher in node.publishers)
    executor.shutdown()
    for node in nodes:
        node.destroy_node()
    rclpy.try_shutdown()
