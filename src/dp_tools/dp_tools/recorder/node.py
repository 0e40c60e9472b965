"""`ros2 run dp_tools recorder`: one MCAP bag of a whole run."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from dp_node import RING, Health, Level, RingExecutor
from dp_node.health import to_status
from dp_node.run import Stop
from dp_tools.recorder import RECORDER_EARS
from dp_tools.recorder.attachments import SCENARIO_ATTACHMENT, VESSEL_ATTACHMENT, vessel_document
from dp_tools.recorder.bag_writer import BagWriter
from dp_tools.recorder.errors import RecordingRefusedError, RecordingStoppedError
from dp_tools.recorder.recorder import Recorder
from dp_tools.versions import VERSIONS_RECORD, versions
from marine_model import load_vessel
from marine_model.errors import DpError

# Periods, s. Messages wait for at most the first in the middleware, which holds thousands.
_DRAIN = 0.01
_DISCOVER = 0.05
_SERVE = 0.1
_ADAPT = 1.0
_FLUSH = 5.0
# At the end: quiet for this long means that nothing is on its way any more; wait no longer than the second.
_QUIET = 0.1
_QUIET_LIMIT = 2.0


class Period:
    """Says when something is due again."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._next = 0.0

    def due(self, now: float) -> bool:
        """Return True at most once a period; ``now`` in s."""
        if now < self._next:
            return False
        self._next = now + self._seconds
        return True


class RecorderNode(Node):
    """Parameters, diagnostics and attachments around a Recorder. Its ``ears`` hold the subscriptions."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("recorder", **kwargs)
        output = self._declare("output", "bag", "Folder of the bag; its name becomes that of the MCAP file")
        overwrite = self._declare("overwrite", False, "Replace a bag that is there")
        self._vessel = self._declare("vessel", "", "Vessel to attach, by name or path; empty for none")
        self._scenario = self._declare("scenario", "", "Scenario file to attach; empty for none")
        self.declare_parameter(
            "topics",
            Parameter.Type.STRING_ARRAY,
            ParameterDescriptor(description="Topics to record, full names; empty for all", read_only=True),
        )
        topics = self.get_parameter_or("topics", Parameter("topics", value=[""])).value
        attachments = self._attachments()
        self.writer = BagWriter(Path(output), overwrite)
        for name, data in attachments.items():
            self.writer.attach(name, "application/yaml", data, time.time_ns())
        self.writer.describe(VERSIONS_RECORD, versions())
        # No executor serves this node: the recorder takes its messages itself.
        self.ears = Node(
            RECORDER_EARS, namespace=self.get_namespace(), start_parameter_services=False, enable_rosout=False
        )
        self.recorder = Recorder(self.ears, self.writer, [topic for topic in topics if topic], self.get_namespace())
        self._publisher = self.create_publisher(DiagnosticArray, "/diagnostics", RING)
        self.create_timer(1.0, self._publish_health)

    def _declare(self, name: str, default: Any, description: str) -> Any:
        descriptor = ParameterDescriptor(description=description, read_only=True)
        try:
            return self.declare_parameter(name, default, descriptor).value
        except ParameterException as error:
            raise RecordingRefusedError(f"parameter {name}: {error}") from error

    def _attachments(self) -> dict[str, bytes]:
        """Return files to attach by name. Raises DpError."""
        files = {}
        if self._vessel:
            files[VESSEL_ATTACHMENT] = vessel_document(load_vessel(self._vessel))
        if self._scenario:
            try:
                files[SCENARIO_ATTACHMENT] = Path(self._scenario).read_bytes()
            except OSError as error:
                raise RecordingRefusedError(f"{self._scenario}: cannot be read: {error.strerror}") from error
        return files

    def _publish_health(self) -> None:
        lost = self.recorder.lost
        values: dict[str, object] = {
            "messages": self.writer.message_count,
            "topics": len(self.recorder.counts),
            "bytes": self.writer.size,
            "lost": sum(lost.values()),
            **{f"lost {topic}": count for topic, count in lost.items()},
        }
        level, text = (Level.WARN, f"messages lost on {', '.join(lost)}") if lost else (Level.OK, "recording")
        message = DiagnosticArray(status=[to_status(self.get_name(), Health(level, text, values))])
        message.header.stamp = self.get_clock().now().to_msg()
        self._publisher.publish(message)

    def custom_data(self) -> dict[str, str]:
        """Return what metadata.yaml says beside the topics."""
        lost = self.recorder.lost
        data = {"recorder": "dp_tools", "lost_messages": str(sum(lost.values()))}
        if self._vessel:
            data["vessel"] = self._vessel
        if self._scenario:
            data["scenario"] = Path(self._scenario).stem
        return data

    def destroy_node(self) -> None:
        """Destroy this node and its ears."""
        self.ears.destroy_node()
        super().destroy_node()


def record(node: RecorderNode, stop: Stop) -> None:
    """Record until ``stop``, then take what is still on its way. Raises RecordingStoppedError."""
    executor = RingExecutor()
    executor.add_node(node)
    discover, serve, adapt, flush = Period(_DISCOVER), Period(_SERVE), Period(_ADAPT), Period(_FLUSH)
    try:
        while not stop.requested:
            now = time.monotonic()
            if discover.due(now):
                node.recorder.discover()
            if adapt.due(now):
                node.recorder.adapt()
            node.recorder.drain()
            if serve.due(now):
                executor.spin_once(timeout_sec=0.0)
            if flush.due(now):
                node.writer.flush()
            time.sleep(max(0.0, now + _DRAIN - time.monotonic()))
        end = time.monotonic() + _QUIET_LIMIT
        quiet = time.monotonic() + _QUIET
        while time.monotonic() < min(quiet, end):
            if node.recorder.drain():
                quiet = time.monotonic() + _QUIET
            time.sleep(_DRAIN)
        node.recorder.settle()
    finally:
        executor.shutdown()


def run(arguments: list[str] | None = None) -> int:
    """Record until SIGINT or SIGTERM; return the exit code."""
    # Our own signal handling: rclpy's would close the context before the last messages are in the bag.
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    stop = Stop()
    node: RecorderNode | None = None
    code = 0
    try:
        node = RecorderNode()
        print(f"recording to {node.writer.path}", flush=True)
        try:
            record(node, stop)
        except RecordingStoppedError:
            pass  # close() says it, once the bag is whole
        finally:
            try:
                node.writer.close(node.custom_data())
            finally:
                report(node)
    except DpError as error:
        print(f"recorder: {error}", file=sys.stderr, flush=True)
        code = 1
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return code


def report(node: RecorderNode) -> None:
    """Say what is in the bag and what is not."""
    counts, lost = node.recorder.counts, node.recorder.lost
    print(
        f"recorded {node.writer.message_count} messages on {len(counts)} topics, "
        f"{node.writer.size / 1e6:.1f} MB, lost {sum(lost.values())}",
        flush=True,
    )
    if lost:
        by_topic = ", ".join(f"{count} on {topic}" for topic, count in lost.items())
        print(f"recorder: lost messages: {by_topic}", file=sys.stderr, flush=True)


def main() -> None:
    """Run the recorder and exit the process."""
    sys.exit(run())
