"""Node ``recorder``: parameters, diagnostics and what is attached to the bag."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.exceptions import ParameterException
from rclpy.node import Node

from dp_node import Health
from dp_node.health import to_status
from dp_node.quality import Promise, offered
from dp_tools.recorder import RECORDER_EARS
from dp_tools.recorder.attachments import SCENARIO_ATTACHMENT, VESSEL_ATTACHMENT, vessel_document
from dp_tools.recorder.bag_writer import BagWriter, Limits
from dp_tools.recorder.compression import COMPRESSIONS, DEFAULT_COMPRESSION
from dp_tools.recorder.errors import RecordingRefusedError
from dp_tools.recorder.parameter_snapshots import Snapshot, Snapshots
from dp_tools.recorder.parameter_watch import ParameterWatch
from dp_tools.recorder.recorder import Recorder
from dp_tools.recorder.recorder_health import RecorderState, health_of
from dp_tools.recorder.selection import PARAMETER_EVENTS, Selection
from dp_tools.versions import VERSIONS_RECORD, versions
from marine_model import load_vessel

_YAML = "application/yaml"
# Larger values mean nothing: a million megabytes, a year.
_MOST_MEGABYTES = 1e6
_LONGEST = 3.2e7


class RecorderNode(Node):
    """Parameters, diagnostics and attachments around a Recorder. Its ``ears`` hold the subscriptions.

    Raises
    ------
    RecordingRefusedError
        If a parameter is not valid or the bag cannot begin.
    DpError
        If vessel or scenario cannot be read.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("recorder", **kwargs)
        output = self._declare("output", "bag", "Folder of the bag; its name becomes that of the MCAP files")
        overwrite = self._declare("overwrite", False, "Replace a bag that is there")
        self._vessel = self._declare("vessel", "", "Vessel to attach, by name or path; empty for none")
        self._scenario = self._declare("scenario", "", "Scenario file to attach; empty for none")
        compression = self._declare(
            "compression", DEFAULT_COMPRESSION, f"Of chunks: {', '.join(COMPRESSIONS)}", ", ".join(COMPRESSIONS)
        )
        size = self._declare("max_size", 0.0, "MB of a file before another begins; 0 for no limit", _MOST_MEGABYTES)
        duration = self._declare("max_duration", 0.0, "Seconds in a file before another begins; 0: no limit", _LONGEST)
        self.duration = self._declare("duration", 0.0, "Seconds until the recording ends; 0 for no limit", _LONGEST)
        regex = self._declare("regex", "", "Also topics in whose name this regular expression is found; empty: none")
        exclude = self._declare("exclude", "", "Never topics in whose name this is found; empty for none")
        # An empty list would have no type in ROS.
        topics = self._declare("topics", [""], "Topics to record, by name; empty for all")
        selection = Selection([topic for topic in topics if topic], regex, exclude, self.get_namespace())
        attachments = self._attachments()
        limits = Limits(round(size * 1e6), round(duration * 1e9))
        self.writer = BagWriter(Path(output), overwrite, compression=compression, limits=limits)
        for name, data in attachments.items():
            self.writer.attach(name, _YAML, data, time.time_ns())
        self.writer.describe(VERSIONS_RECORD, versions())
        # No executor serves this node: the recorder takes its messages itself.
        self.ears = Node(
            RECORDER_EARS, namespace=self.get_namespace(), start_parameter_services=False, enable_rosout=False
        )
        self._listening = True
        snapshots = Snapshots()
        taps = {}
        if limits != Limits():  # a further file begins with what the changes so far have led to
            taps[PARAMETER_EVENTS] = snapshots.note
            self.writer.fresh = snapshots.at_present

        def keep(snapshot: Snapshot) -> None:
            snapshots.add(snapshot)
            self.writer.attach(snapshot.name, _YAML, snapshot.document(), snapshot.time)

        self.recorder = Recorder(self.ears, self.writer, selection, taps)
        self.watch = ParameterWatch(self.ears, selection.is_below, keep, self.get_logger().warning)
        self._publisher = self.create_publisher(DiagnosticArray, "/diagnostics", offered("/diagnostics", Promise()))
        self.create_timer(1.0, self.publish_health)

    def _declare(self, name: str, default: Any, description: str, limit: float | str = "") -> Any:
        """Declare a read-only parameter; ``limit`` is the largest value of a number, or what there is to choose."""
        descriptor = ParameterDescriptor(description=description, read_only=True)
        if isinstance(limit, str):
            descriptor.additional_constraints = limit
        else:
            descriptor.floating_point_range = [FloatingPointRange(from_value=0.0, to_value=limit)]
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

    def health(self) -> Health:
        """Return what there is to say of the recording."""
        failed = self.writer.failed
        state = RecorderState(
            messages=self.writer.message_count,
            topics=len(self.recorder.counts),
            size=self.writer.size,
            files=self.writer.file_count,
            lost=self.recorder.lost,
            silent=self.watch.silent,
            failed="" if failed is None else str(failed),
            disk_full=self.writer.disk_full,
        )
        return health_of(state)

    def publish_health(self) -> None:
        """Say on /diagnostics how it goes."""
        message = DiagnosticArray(status=[to_status(self.get_fully_qualified_name().lstrip("/"), self.health())])
        message.header.stamp = self.get_clock().now().to_msg()
        self._publisher.publish(message)

    def custom_data(self) -> dict[str, str]:
        """Return what metadata.yaml says beside the topics."""
        lost = self.recorder.lost
        data = {"recorder": "dp_tools", "lost_messages": str(sum(lost.values()))}
        if self.watch.unanswered:
            data["parameters_missing"] = ", ".join(self.watch.unanswered)
        if self._vessel:
            data["vessel"] = self._vessel
        if self._scenario:
            data["scenario"] = Path(self._scenario).stem
        return data

    def stop_listening(self) -> None:
        """Give all subscriptions back, so that nobody keeps messages for them; counts stay."""
        if self._listening:
            self._listening = False
            self.watch.close()
            self.ears.destroy_node()

    def destroy_node(self) -> None:
        """Destroy this node and its ears."""
        self.stop_listening()
        super().destroy_node()
