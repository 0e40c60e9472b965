"""From a recording to the run it holds, with the vessel and the scenario that were recorded with it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap_ros2.decoder import DecoderFactory

from dp_tools.run_data import WIDTHS, Labels, RunData, RunInfo, Series
from dp_tools.scenario import Scenario, load_scenario
from dp_tools.versions import VERSIONS_RECORD
from marine_model import Vessel, load_vessel
from marine_model.errors import DpError, UnknownNameError
from marine_model.frames import quaternion_to_heading

VESSEL_ATTACHMENT = "vessel.yaml"
SCENARIO_ATTACHMENT = "scenario.yaml"

_NANOSECONDS = 1_000_000_000
# Simulated time begins at 0. A stamp beyond this is wall-clock time, which is shown from the start of the recording.
_LONGEST_RUN_NS = 10_000_000 * _NANOSECONDS

Row = tuple[float, ...]


class BagError(DpError):
    """A recording cannot be read, or lacks what a report needs; the message says what."""


@dataclass(frozen=True)
class RecordedRun:
    """What is in a bag.

    Parameters
    ----------
    run
        Its signals.
    vessel
        As recorded.
    scenario
        As recorded; None if the run followed none.
    """

    run: RunData
    vessel: Vessel
    scenario: Scenario | None


@dataclass
class _Column:
    """Rows of one series as they come; of several with one stamp the last counts, one that jumps back is left out."""

    stamps: list[int] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)

    def add(self, stamp: int, row: Row) -> None:
        if self.stamps and stamp <= self.stamps[-1]:
            if stamp == self.stamps[-1]:
                self.rows[-1] = row
            return
        self.stamps.append(stamp)
        self.rows.append(row)


@dataclass
class _Words:
    """Changes of one word."""

    stamps: list[int] = field(default_factory=list)
    words: list[str] = field(default_factory=list)

    def add(self, stamp: int, word: str) -> None:
        if not self.words or self.words[-1] != word:
            self.stamps.append(stamp)
            self.words.append(word)


class _Collector:
    """Sorts decoded messages into series."""

    def __init__(self, vessel: Vessel) -> None:
        self._names = list(vessel.thruster_names)
        self.columns: dict[str, _Column] = {}
        self.words: dict[str, _Words] = {}
        self.topics: Mapping[str, Callable[[int, Any], None]] = {
            "pose": self._pose,
            "truth": self._truth,
            "odometry": self._odometry,
            "observer_state": self._observer_state,
            "controller_status": self._controller_status,
            "tau_desired": lambda stamp, m: self._row("tau_desired", stamp, _wrench(m)),
            "tau_achieved": lambda stamp, m: self._row("tau_achieved", stamp, _wrench(m)),
            "thruster_command": self._thruster_command,
            "allocation_status": self._allocation_status,
            "actuator_setpoint": self._actuator_setpoint,
            "thruster_feedback": self._thruster_feedback,
        }

    def take(self, topic: str, message: Any) -> None:
        stamp = message.header.stamp
        self.topics[topic](stamp.sec * _NANOSECONDS + stamp.nanosec, message)

    def _row(self, series: str, stamp: int, row: Any) -> None:
        self.columns.setdefault(series, _Column()).add(stamp, tuple(row))

    def _word(self, name: str, stamp: int, word: str) -> None:
        self.words.setdefault(name, _Words()).add(stamp, word)

    def _by_thruster(self, series: str, stamp: int, names: list[str], values: Any) -> None:
        if list(names) != self._names:
            raise BagError(f"{series}: expected the thrusters {self._names}, found {list(names)}")
        self._row(series, stamp, values)

    def _pose(self, stamp: int, m: Any) -> None:
        fix = m.pose.covariance[0] >= 0.0
        self._row("pose", stamp, _position(m.pose.pose) if fix else (np.nan,) * 3)

    def _truth(self, stamp: int, m: Any) -> None:
        self._row("truth_position", stamp, _position(m.pose.pose))

    def _odometry(self, stamp: int, m: Any) -> None:
        twist = m.twist.twist
        self._row("estimate_position", stamp, _position(m.pose.pose))
        self._row("estimate_velocity", stamp, (twist.linear.x, twist.linear.y, twist.angular.z))

    def _observer_state(self, stamp: int, m: Any) -> None:
        self._row("wave_position", stamp, m.wave_frequency_position)
        self._row("bias", stamp, m.bias)
        self._word("observer_status", stamp, m.status)

    def _controller_status(self, stamp: int, m: Any) -> None:
        for name in ("reference_position", "reference_velocity", "proportional", "integral", "derivative", "joystick"):
            self._row(name, stamp, getattr(m, name))
        self._word("controller_mode", stamp, m.mode)
        self._word("controller_status", stamp, m.status)

    def _thruster_command(self, stamp: int, m: Any) -> None:
        self._by_thruster("thrust_command", stamp, m.name, m.thrust)
        self._by_thruster("azimuth_command", stamp, m.name, m.azimuth)

    def _allocation_status(self, stamp: int, m: Any) -> None:
        self._row("slack", stamp, m.slack)
        self._row("allocation_cost", stamp, (m.cost,))
        self._word("allocation_status", stamp, m.status)
        self._word("azimuth_mode", stamp, m.azimuth_mode)

    def _actuator_setpoint(self, stamp: int, m: Any) -> None:
        self._by_thruster("torque_setpoint", stamp, m.name, m.torque)
        self._by_thruster("azimuth_rate_setpoint", stamp, m.name, m.azimuth_rate)

    def _thruster_feedback(self, stamp: int, m: Any) -> None:
        self._by_thruster("shaft_speed", stamp, m.name, m.shaft_speed)
        self._by_thruster("motor_torque", stamp, m.name, m.torque)
        self._by_thruster("power", stamp, m.name, m.power)
        self._by_thruster("azimuth", stamp, m.name, m.azimuth)


def _position(pose: Any) -> Row:
    q = pose.orientation
    return pose.position.x, pose.position.y, quaternion_to_heading(q.x, q.y, q.z, q.w)


def _wrench(message: Any) -> Row:
    wrench = message.wrench
    return wrench.force.x, wrench.force.y, wrench.torque.z


def bag_file(path: Path) -> Path:
    """Return the MCAP file of a bag, given its folder or the file itself.

    Raises
    ------
    BagError
        If there is none, or more than one.
    """
    if path.is_file():
        return path
    if not path.is_dir():
        raise BagError(f"{path}: no such bag")
    found = sorted(path.glob("*.mcap"))
    if len(found) != 1:
        raise BagError(f"{path}: expected one .mcap file, found {len(found)}")
    return found[0]


def read_bag(path: Path, vessel: str = "") -> RecordedRun:
    """Return the run in a bag.

    Parameters
    ----------
    path
        Folder of the bag, or its MCAP file.
    vessel
        Name or path of the vessel, for a bag that holds none.

    Raises
    ------
    BagError
        If the bag cannot be read, holds no vessel and none is named, or holds two graphs.
    DpError
        If the vessel or scenario in it is not valid.
    """
    file = bag_file(path)
    try:
        with file.open("rb") as stream:
            return _read(stream, file, vessel)
    except (OSError, McapError) as error:
        raise BagError(f"{file}: cannot be read: {error}") from error


def _read(stream: IO[bytes], file: Path, vessel_name: str) -> RecordedRun:
    reader = make_reader(stream, decoder_factories=[DecoderFactory()])
    attachments = {attachment.name: attachment.data for attachment in reader.iter_attachments()}
    vessel, scenario = _documents(attachments, vessel_name, file)
    collector = _Collector(vessel)
    first, last = _collect(reader, collector, file)
    started = min((c.stamps[0] for c in collector.columns.values()), default=0)
    zero = started if started > _LONGEST_RUN_NS else 0
    series = {
        name: Series((np.array(c.stamps) - zero) * 1e-9, _matrix(c.rows, WIDTHS[name] or len(vessel.thrusters)))
        for name, c in collector.columns.items()
    }
    labels = {name: Labels((np.array(w.stamps) - zero) * 1e-9, tuple(w.words)) for name, w in collector.words.items()}
    records = {record.name: record.metadata for record in reader.iter_metadata()}
    end = max((float(entry.t[-1]) for entry in series.values()), default=0.0)
    info = RunInfo(
        scenario=scenario.name if scenario else "",
        vessel=vessel.name,
        how="node graph",
        seed=scenario.seed if scenario else 0,
        versions=records.get(VERSIONS_RECORD, {}),
        started=_iso(first),
        simulated_time=min(end + vessel.simulation.time_step, scenario.duration) if scenario else end,
        wall_time=(last - first) * 1e-9,
    )
    return RecordedRun(RunData(info, vessel.thruster_names, series, labels), vessel, scenario)


def _collect(reader: McapReader, collector: _Collector, file: Path) -> tuple[int, int]:
    """Hand every message that counts to ``collector``; return the log times (ns) of the first and last feedback."""
    summary = reader.get_summary()
    if summary is None:
        raise BagError(f"{file}: has no summary; the recording was not closed")
    names: dict[str, str] = {}
    for channel in summary.channels.values():
        short = channel.topic.rpartition("/")[2]
        if short in collector.topics:
            if short in names.values():
                raise BagError(f"{file}: expected one graph, found {short} in two namespaces")
            names[channel.topic] = short
    if not names:
        raise BagError(f"{file}: holds none of the topics {', '.join(collector.topics)}")
    first = last = 0
    for _, channel, message, decoded in reader.iter_decoded_messages(topics=list(names), log_time_order=False):
        collector.take(names[channel.topic], decoded)
        if names[channel.topic] == "thruster_feedback":
            first, last = first or message.log_time, message.log_time
    return first, last


def _matrix(rows: list[Row], width: int) -> Any:
    return np.array(rows, dtype=np.float64).reshape(-1, width)


def _documents(attachments: Mapping[str, bytes], vessel_name: str, file: Path) -> tuple[Vessel, Scenario | None]:
    """Return the vessel and the scenario of a bag. Files on this machine are not looked at unless named."""
    with tempfile.TemporaryDirectory() as folder:
        for name in (VESSEL_ATTACHMENT, SCENARIO_ATTACHMENT):
            if name in attachments:
                (Path(folder) / name).write_bytes(attachments[name])
        if vessel_name:
            vessel = load_vessel(vessel_name)
        elif VESSEL_ATTACHMENT in attachments:
            vessel = load_vessel(Path(folder) / VESSEL_ATTACHMENT)
        else:
            raise UnknownNameError(f"{file}: holds no vessel file; name the vessel")
        scenario = None
        if SCENARIO_ATTACHMENT in attachments:
            scenario = load_scenario(Path(folder) / SCENARIO_ATTACHMENT, vessel)
        return vessel, scenario


def _iso(nanoseconds: int) -> str:
    if nanoseconds <= 0:
        return ""
    return str(np.datetime64(nanoseconds // _NANOSECONDS, "s")) + "+00:00"
