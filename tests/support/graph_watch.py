"""A process that watches a graph and writes what it hears, a line a message: also from a network namespace of its own.

Stamps are simulated time in s; ``wall`` is the monotonic clock, which all processes of a machine share.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

from dp_msgs.msg import ThrusterCommand, ThrusterFeedback
from nav_msgs.msg import Odometry

from dp_node import RING

ODD = "not_finite"


class Watch:
    """Reads what the process has written so far; :meth:`read` takes in the rest."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read = 0
        self._rest = ""
        self.last: dict[str, float] = {}
        """Newest stamp by topic, s."""
        self.alarms: dict[str, dict[str, float]] = defaultdict(dict)
        """By code: wall time of the newest report that had it, and of the first, and level."""
        self.active: dict[str, dict[str, str]] = {}
        """By node: alarms of its newest report with their texts."""
        self.reported: dict[str, float] = {}
        """By node: wall time of its newest report."""
        self.off: list[tuple[float, float]] = []
        """Stamp (s) and distance from north 0, east 0 (m), of the truth."""
        self.steps: list[tuple[float, float]] = []
        """Stamp (s) and largest change of a thrust between two commands, N."""
        self.largest_gap = 0.0  # s of simulated time between two commands
        self.feedback = 0
        self.not_finite = 0

    def read(self) -> Watch:
        """Take in what has been written since."""
        if not self._path.exists():
            return self
        with self._path.open(encoding="utf-8") as stream:
            stream.seek(self._read)
            text = self._rest + stream.read()
            self._read = stream.tell()
        *lines, self._rest = text.split("\n")
        for line in lines:
            self._take(json.loads(line))
        return self

    def _take(self, line: dict[str, Any]) -> None:
        topic = line["topic"]
        self.not_finite += bool(line.get(ODD))
        if topic == "diagnostics":
            self.active[line["node"]] = line["alarms"]
            self.reported[line["node"]] = line["wall"]
            for code in line["alarms"]:
                self.alarms[code].setdefault("first", line["wall"])
                self.alarms[code]["last"] = line["wall"]
            return
        if topic == "thruster_command":
            self.steps.append((line["stamp"], line["step"]))
            if topic in self.last:
                self.largest_gap = max(self.largest_gap, line["stamp"] - self.last[topic])
        self.last[topic] = line["stamp"]
        if topic == "truth":
            self.off.append((line["stamp"], line["off"]))
        self.feedback += topic == "thruster_feedback"

    def shown_since(self, wall: float) -> set[str]:
        """Return the codes that were in a report at or after a wall time."""
        return {code for code, times in self.alarms.items() if times["last"] >= wall}

    def calm_since(self, wall: float, nodes: set[str]) -> bool:
        """Whether the newest report of each node came after a wall time and has no alarm."""
        return all(self.reported.get(node, -math.inf) > wall and not self.active[node] for node in nodes)


def main() -> None:
    """Watch until SIGTERM or SIGINT, or until the parent has gone; argument: the file to write."""
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.signals import SignalHandlerOptions

    from dp_node import RingExecutor
    from dp_node.run import Stop

    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    stop = Stop()
    node = rclpy.create_node("graph_watch")
    last: dict[str, list[float]] = {}
    with Path(sys.argv[1]).open("w", encoding="utf-8", buffering=1) as out:

        def write(topic: str, message: Any, **fields: Any) -> None:
            stamp = message.header.stamp
            line = {"topic": topic, "wall": time.monotonic(), "stamp": stamp.sec + stamp.nanosec * 1e-9, **fields}
            out.write(json.dumps(line) + "\n")

        def on_command(message: Any) -> None:
            thrust = list(message.thrust)
            before = last.get("thrust", thrust)
            last["thrust"] = thrust
            step = max(abs(a - b) for a, b in zip(thrust, before, strict=True))
            odd = not all(map(math.isfinite, [*thrust, *message.azimuth]))
            write("thruster_command", message, step=step, **{ODD: odd})

        def on_odometry(message: Any) -> None:
            at = message.pose.pose.position
            write("odometry", message, **{ODD: not (math.isfinite(at.x) and math.isfinite(at.y))})

        def on_truth(message: Any) -> None:
            at = message.pose.pose.position
            write("truth", message, off=math.hypot(at.x, at.y))

        def on_diagnostics(message: Any) -> None:
            for status in message.status:
                alarms = {v.key.removeprefix("alarm."): v.value for v in status.values if v.key.startswith("alarm.")}
                write("diagnostics", message, node=status.name, alarms=alarms)

        node.create_subscription(ThrusterCommand, "thruster_command", on_command, RING)
        node.create_subscription(ThrusterFeedback, "thruster_feedback", lambda m: write("thruster_feedback", m), RING)
        node.create_subscription(Odometry, "odometry", on_odometry, RING)
        node.create_subscription(Odometry, "truth", on_truth, RING)
        node.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, RING)
        executor = RingExecutor()
        executor.add_node(node)
        while not stop.requested:
            executor.spin_once(timeout_sec=0.1)
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
