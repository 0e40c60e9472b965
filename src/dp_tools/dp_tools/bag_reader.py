"""From a recording to the run it holds, with the vessel and the scenario that were recorded with it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap_ros2.decoder import DecoderFactory

from dp_tools.run_data import PROPULSION_TRUTH, WIDTHS, Labels, RunData, RunInfo, Series
from dp_tools.scenario import Scenario, load_scenario
from dp_tools.versions import VERSIONS_RECORD
from marine_model import Vessel, load_vessel
from marine_model.errors import DpError, UnknownNameError
from marine_model.frames import quaternion_to_heading
from marine_model.guards import FloatArray

VESSEL_ATTACHMENT = "vessel.yaml"
SCENARIO_ATTACHMENT = "scenario.yaml"

_NANOSECONDS = 1_000_000_000
# Simulated time begins at 0. A stamp beyond this is wall-clock time, which is shown from the start of the recording.
_LONGEST_RUN_NS = 10_000_000 * _NANOSECONDS

# Series that controller_status carries; it is published between samples too, as the answer to an operator.
_OF_STATUS = (
    "reference_position",
    "reference_velocity",
    "proportional",
    "integral",
    "derivative",
    "joystick",
    "transfer",
)

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


def _seconds(stamps: list[int], zero: int) -> FloatArray:
    return np.array([(stamp - zero) * 1e-9 for stamp in stamps], dtype=np.float64)


class _Column:
    """Rows of one series by stamp (ns); of several with one stamp the last counts.

    An operator's input is answered with a status between two samples, and a command with a setpoint; what the sample
    itself is answered with comes later, or says the same.
    """

    def __init__(self) -> None:
        self.rows: dict[int, Row] = {}

    def series(self, zero: int, width: int) -> Series:
        """Return the series, with time from ``zero`` (ns)."""
        stamps = sorted(self.rows)
        rows = [self.rows[stamp] for stamp in stamps]
        return Series(_seconds(stamps, zero), np.array(rows, dtype=np.float64).reshape(-1, width))

    def keep(self, stamps: Collection[int]) -> None:
        """Drop rows with other stamps."""
        self.rows = {stamp: row for stamp, row in self.rows.items() if stamp in stamps}


class _Words:
    """One word by stamp (ns); of several with one stamp the first counts."""

    def __init__(self) -> None:
        self.words: dict[int, str] = {}

    def labels(self, zero: int) -> Labels:
        """Return its changes, with time from ``zero`` (ns)."""
        stamps: list[int] = []
        words: list[str] = []
        for stamp in sorted(self.words):
            if not words or words[-1] != self.words[stamp]:
                stamps.append(stamp)
                words.append(self.words[stamp])
        return Labels(_seconds(stamps, zero), tuple(words))

    def keep(self, stamps: Collection[int]) -> None:
        """Drop words with other stamps."""
        self.words = {stamp: word for stamp, word in self.words.items() if stamp in stamps}


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
            "ventilation": self._ventilation,
            "propulsion_truth": self._propulsion_truth,
        }

    def take(self, topic: str, message: Any) -> None:
        stamp = message.header.stamp
        self.topics[topic](stamp.sec * _NANOSECONDS + stamp.nanosec, message)

    def drop_answers_to_operators(self) -> None:
        """Keep those controller_status that came with a demand."""
        if "tau_desired" not in self.columns:
            return
        stamps = self.columns["tau_desired"].rows
        for name in _OF_STATUS:
            if name in self.columns:
                self.columns[name].keep(stamps)
        for name in ("controller_mode", "controller_status"):
            if name in self.words:
                self.words[name].keep(stamps)

    def _row(self, series: str, stamp: int, row: Any) -> None:
        self.columns.setdefault(series, _Column()).rows[stamp] = tuple(row)

    def _word(self, name: str, stamp: int, word: str) -> None:
        self.words.setdefault(name, _Words()).words.setdefault(stamp, word)

    def _by_thruster(self, series: str, stamp: int, names: list[str], values: Any) -> None:
        if list(names) != self._names:
            raise BagError(f"{series}: expected the thrusters {self._names}, found {list(names)}")
        self._row(series, stamp, values)

    def _pose(self, stamp: int, m: Any) -> None:
        fix = m.pose.covariance[0] >= 0.0
        self._row("pose", stamp, _position(m.pose.pose) if fix else (np.nan,) * 3)

    def _truth(self, stamp: int, m: Any) -> None:
        self._row("truth_position", stamp, _position(m.pose.pose))

    def _propulsion_truth(self, stamp: int, m: Any) -> None:
        for name in PROPULSION_TRUTH:
            self._by_thruster(f"truth_{name}", stamp, m.name, getattr(m, name))

    def _odometry(self, stamp: int, m: Any) -> None:
        twist = m.twist.twist
        self._row("estimate_position", stamp, _position(m.pose.pose))
        self._row("estimate_velocity", stamp, (twist.linear.x, twist.linear.y, twist.angular.z))

    def _observer_state(self, stamp: int, m: Any) -> None:
        self._row("wave_position", stamp, m.wave_frequency_position)
        self._row("bias", stamp, m.bias)
        self._word("observer_status", stamp, m.status)

    def _controller_status(self, stamp: int, m: Any) -> None:
        for name in _OF_STATUS:
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
        if getattr(m, "antispin", False):  # not in recordings of earlier versions
            self._row("torque_loss", stamp, m.torque_loss)
        for name in (
            "performance_measure",
            "minimum_gain",
            "minimum_gain_both_ways",
            "minimum_gain_free",
            "sub_problem",
        ):
            value = float(getattr(m, name, np.nan))
            if np.isfinite(value):
                self._row(name, stamp, (value,))
        for name in ("rotating", "crossing"):
            if len(flags := getattr(m, name, ())):
                self._row(name, stamp, [float(flag) for flag in flags])

    def _actuator_setpoint(self, stamp: int, m: Any) -> None:
        answered = self.columns.get("torque_setpoint")
        if m.command_stale and answered and stamp in answered.rows:
            return  # the farewell of drivers that are being stopped: what they had answered was in force
        self._by_thruster("torque_setpoint", stamp, m.name, m.torque)
        self._by_thruster("azimuth_rate_setpoint", stamp, m.name, m.azimuth_rate)
        self._pitch("pitch_ratio_setpoint", stamp, m)

    def _thruster_feedback(self, stamp: int, m: Any) -> None:
        self._by_thruster("shaft_speed", stamp, m.name, m.shaft_speed)
        self._by_thruster("motor_torque", stamp, m.name, m.torque)
        self._by_thruster("power", stamp, m.name, m.power)
        self._by_thruster("azimuth", stamp, m.name, m.azimuth)
        self._pitch("pitch_ratio", stamp, m)

    def _pitch(self, series: str, stamp: int, m: Any) -> None:
        """Recordings of earlier versions, and thrusters of fixed pitch, may not tell of it."""
        if len(getattr(m, "pitch_ratio", ())):
            self._by_thruster(series, stamp, m.name, m.pitch_ratio)

    def _ventilation(self, stamp: int, m: Any) -> None:
        self._by_thruster("ventilating", stamp, m.name, [float(flag) for flag in m.ventilating])
        self._by_thruster("beta_q", stamp, m.name, m.beta_q)
        self._by_thruster("beta_q2", stamp, m.name, m.beta_q2)


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
    collector.drop_answers_to_operators()
    started = min((min(c.rows) for c in collector.columns.values() if c.rows), default=0)
    zero = started if started > _LONGEST_RUN_NS else 0
    series = {
        name: column.series(zero, WIDTHS[name] or len(vessel.thrusters)) for name, column in collector.columns.items()
    }
    labels = {name: words.labels(zero) for name, words in collector.words.items()}
    records = {record.name: record.metadata for record in reader.iter_metadata()}
    end = max((float(entry.t[-1]) for entry in series.values() if len(entry.t)), default=0.0)
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
