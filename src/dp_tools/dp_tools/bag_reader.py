"""From a recording to the run it holds, with the vessel and the scenario that were recorded with it."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import TypesysError
from rosbags.typesys.store import Typestore

from dp_tools.bags.bag import Bag, open_bag
from dp_tools.bags.errors import BagError
from dp_tools.bags.files import bag_files
from dp_tools.cdr.bulk import Batch, batches
from dp_tools.cdr.layout import LayoutError
from dp_tools.cdr.types import types_of
from dp_tools.recorder.attachments import SCENARIO_ATTACHMENT, VESSEL_ATTACHMENT
from dp_tools.run_bag import RUN_RECORD
from dp_tools.run_data import VERTICAL, Labels, RunData, RunInfo, Series, width
from dp_tools.run_topics import TOPICS, RunTopic
from dp_tools.scenario import Scenario, load_scenario
from dp_tools.versions import VERSIONS_RECORD
from marine_model import Vessel, load_vessel
from marine_model.errors import UnknownNameError
from marine_model.frames import quaternion_to_attitude, quaternion_to_heading
from marine_model.guards import FloatArray

_NANOSECONDS = 1_000_000_000
# Simulated time begins at 0. A stamp beyond this is wall-clock time, which is shown from the start of the recording.
_LONGEST_RUN_NS = 10_000_000 * _NANOSECONDS
_BY_NAME: Mapping[str, RunTopic] = {topic.name: topic for topic in TOPICS}
# The topic whose log times say how long the run took.
_PACE_TOPIC = "thruster_feedback"

Stamps = NDArray[np.int64]


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


def _seconds(stamps: Stamps, zero: int) -> FloatArray:
    return (stamps - zero).astype(np.float64) * 1e-9


@dataclass
class _Raw:
    """Serialized messages of one topic, in the order of the file."""

    topic: RunTopic
    kind: str
    data: list[bytes]
    first: int = 0  # log times, ns
    last: int = 0


class _Rows:
    """Rows of one series in the order of the file, with their stamps (ns)."""

    def __init__(self) -> None:
        self._parts: list[tuple[NDArray[np.intp], Stamps, FloatArray]] = []

    def add(self, index: NDArray[np.intp], stamps: Stamps, rows: FloatArray) -> None:
        self._parts.append((index, stamps, rows))

    def sorted(self) -> tuple[Stamps, FloatArray]:
        """Return stamps and rows in order of time; of several with one stamp the last counts.

        An operator's input is answered with a status between two samples, and a command with a setpoint; what the
        sample itself is answered with comes later, or says the same.
        """
        order = np.argsort(np.concatenate([index for index, _, _ in self._parts]))
        stamps = np.concatenate([stamps for _, stamps, _ in self._parts])[order]
        rows = np.concatenate([rows for _, _, rows in self._parts])[order]
        found, last = np.unique(stamps[::-1], return_index=True)
        return found, rows[::-1][last]


class _Words:
    """One word a message in the order of the file, with their stamps (ns)."""

    def __init__(self) -> None:
        self._parts: list[tuple[NDArray[np.intp], Stamps, str]] = []

    def add(self, index: NDArray[np.intp], stamps: Stamps, word: str) -> None:
        self._parts.append((index, stamps, word))

    def changes(self, only: Stamps | None) -> tuple[Stamps, tuple[str, ...]]:
        """Return stamps and words where the word changes, looking at stamps in ``only`` if that is given.

        Of several with one stamp the first counts.
        """
        index = np.concatenate([index for index, _, _ in self._parts])
        stamps = np.concatenate([stamps for _, stamps, _ in self._parts])
        part = np.repeat(np.arange(len(self._parts)), [len(index) for index, _, _ in self._parts])
        order = np.argsort(index)
        found, first = np.unique(stamps[order], return_index=True)
        numbers = part[order][first]
        if only is not None:
            kept = np.isin(found, only)
            found, numbers = found[kept], numbers[kept]
        words = [self._parts[number][2] for number in numbers.tolist()]
        change = [i for i, word in enumerate(words) if i == 0 or words[i - 1] != word]
        return found[change], tuple(words[i] for i in change)


class _Collector:
    """Sorts messages into series, thousands at a time."""

    def __init__(self, vessel: Vessel) -> None:
        self._names = vessel.thruster_names
        self._axes = len(vessel.degrees_of_freedom)
        self._left_out = frozenset() if vessel.is_submerged else VERTICAL
        self.rows: dict[str, _Rows] = {}
        self.words: dict[str, _Words] = {}

    def take(self, raw: _Raw, types: Typestore) -> None:
        """Take all messages of a topic. Raises BagError, LayoutError."""
        topic = raw.topic
        texts = [*topic.words, *(["name"] if topic.by_thruster else [])]
        found = list(batches(types, raw.kind, raw.data, texts))
        stale = _stale(found, len(raw.data)) if topic.name == "actuator_setpoint" else None
        for batch in found:
            if topic.by_thruster and batch.texts["name"] != self._names:
                shown = list(batch.texts["name"])
                raise BagError(f"{topic.name}: expected the thrusters {list(self._names)}, found {shown}")
            self._take(topic, batch, stale)

    def _take(self, topic: RunTopic, batch: Batch, left_out: NDArray[np.bool_] | None) -> None:
        index, rows = batch.index, batch.rows
        if left_out is not None:
            kept = ~left_out[index]
            index, rows = index[kept], rows[kept]
        stamps = _stamps(rows)
        for path, label in topic.words.items():
            if word := batch.texts.get(path):
                self.words.setdefault(label, _Words()).add(index, stamps, str(word))
        for name in topic.series:
            if name in self._left_out:
                continue
            values = self._values(topic, name, rows)
            if values is None:
                continue
            there = np.ones(len(rows), dtype=np.bool_)
            if name in topic.only_finite:
                there &= np.isfinite(values).all(axis=1)
            if name in topic.only_if:
                flag = topic.only_if[name]
                there &= rows[flag] if flag in (rows.dtype.names or ()) else False
            if there.any():
                self.rows.setdefault(name, _Rows()).add(index[there], stamps[there], values[there])

    def _values(self, topic: RunTopic, name: str, rows: NDArray[Any]) -> FloatArray | None:
        """Return the rows of a series; None where the messages do not tell of it, as in earlier versions."""
        columns = width(name, len(self._names), self._axes)
        values: FloatArray = np.full((len(rows), columns), np.nan)
        for path, (series, column) in topic.numbers.items():
            if series != name:
                continue
            if path not in (rows.dtype.names or ()):
                return None
            given = rows[path].reshape(len(rows), -1)
            expected = columns if column is None else 1
            if given.shape[1] == 0:
                return None
            if given.shape[1] != expected:
                raise BagError(f"{topic.name}.{path}: expected {expected} numbers, found {given.shape[1]}")
            values[:, slice(None) if column is None else slice(column, column + 1)] = given
        if topic.orientation is not None and topic.attitude == name:
            values[:, 1:] = _tilts(rows, topic.orientation[0])
            if topic.name == "pose":
                values[rows["pose.covariance"][:, 0] < 0.0] = np.nan
        if topic.orientation is not None and topic.orientation[1] == name:
            values[:, 2] = _headings(rows, topic.orientation[0])
            if topic.name == "pose":  # a negative variance: no fix
                values[rows["pose.covariance"][:, 0] < 0.0] = np.nan
        return values


def _stamps(rows: NDArray[Any], path: str = "header.stamp") -> Stamps:
    stamps: Stamps = rows[f"{path}.sec"].astype(np.int64) * _NANOSECONDS + rows[f"{path}.nanosec"]
    return stamps


def _tilts(rows: NDArray[Any], path: str) -> list[tuple[float, float]]:
    """Return roll and pitch of every quaternion."""
    parts = [rows[f"{path}.{part}"].tolist() for part in "xyzw"]
    return [quaternion_to_attitude(*quaternion)[:2] for quaternion in zip(*parts, strict=True)]


def _headings(rows: NDArray[Any], path: str) -> list[float]:
    # One by one: numpy's arctangent may differ from the nodes' in the last place.
    parts = [rows[f"{path}.{part}"].tolist() for part in "xyzw"]
    return [quaternion_to_heading(*quaternion) for quaternion in zip(*parts, strict=True)]


def _stale(found: list[Batch], count: int) -> NDArray[np.bool_]:
    """Return which setpoints are the farewell of drivers that are being stopped: what they answered was in force."""
    stamps = np.empty(count, dtype=np.int64)
    stale = np.zeros(count, dtype=np.bool_)
    for batch in found:
        stamps[batch.index], stale[batch.index] = _stamps(batch.rows), batch.rows["command_stale"]
    _, first = np.unique(stamps, return_index=True)
    answered = np.ones(count, dtype=np.bool_)
    answered[first] = False
    return stale & answered


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
        Folder of the bag, or one MCAP file.
    vessel
        Name or path of the vessel, for a bag that holds none.

    Raises
    ------
    BagError
        If the bag cannot be read, holds no vessel and none is named, or holds two graphs.
    DpError
        If the vessel or scenario in it is not valid.
    """
    found = bag_files(path)
    if found.metadata is None and len({_of_one_bag(file) for file in found.files}) > 1:
        names = ", ".join(file.name for file in found.files)
        raise BagError(f"{path}: expected the files of one bag, found {names}; name one of them")
    with open_bag(path) as bag:
        for file, error in bag.cut_off.items():
            raise BagError(f"{file}: cannot be read to its end: {error}; dp bag check --repair may help")
        return _read(bag, path, vessel)


def _of_one_bag(file: Path) -> str:
    """Return what the files of one bag have in common: the name without the number."""
    name, _, number = file.stem.rpartition("_")
    return name if number.isdigit() else file.stem


def _read(bag: Bag, path: Path, vessel_name: str) -> RecordedRun:
    # Files after the first repeat what belongs to every file.
    attachments = {one.name: one.data for one in reversed(bag.attachments)}
    records = {one.name: one.metadata for one in reversed(bag.records)}
    schemas = {topic.kind: topic.definition for topic in bag.topics}
    vessel, scenario = documents(attachments, vessel_name, path)
    collector = _Collector(vessel)
    raw = _messages(bag, path)
    try:
        types = types_of({one.kind: schemas[one.kind] for one in raw})
        for one in raw:
            collector.take(one, types)
    except (LayoutError, TypesysError) as error:
        raise BagError(f"{path}: cannot be read: {error}") from error
    run = _run(collector, vessel, scenario)
    pace = next((one for one in raw if one.topic.name == _PACE_TOPIC), None)
    info = _info(records, vessel, scenario, run.duration, pace)
    return RecordedRun(RunData(info, run.thrusters, run.series, run.labels, run.degrees_of_freedom), vessel, scenario)


def _messages(bag: Bag, path: Path) -> list[_Raw]:
    """Return the messages of every topic that counts, in the order of the files."""
    joined: dict[str, _Raw] = {}
    wanted: dict[int, _Raw] = {}
    for number, topic in enumerate(bag.topics):
        short = topic.name.rpartition("/")[2]
        if short in _BY_NAME:
            one = joined.setdefault(topic.name, _Raw(_BY_NAME[short], topic.kind, []))
            if one.kind != topic.kind:
                raise BagError(f"{path}: {topic.name}: expected one type, found {one.kind} and {topic.kind}")
            wanted[number] = one
    for row, (number, log_time) in enumerate(
        zip(bag.messages.topic.tolist(), bag.messages.log_time.tolist(), strict=True)
    ):
        found = wanted.get(number)
        if found is not None:
            found.first = found.first or log_time
            found.last = log_time
            found.data.append(bag.data(row))
    if not joined:
        raise BagError(f"{path}: holds none of the topics {', '.join(_BY_NAME)}")
    shown = [one.topic.name for one in joined.values()]
    for short in shown:
        if shown.count(short) > 1:
            raise BagError(f"{path}: expected one graph, found {short} in two namespaces")
    return [one for one in joined.values() if one.data]


def _run(collector: _Collector, vessel: Vessel, scenario: Scenario | None) -> RunData:
    found = {name: rows.sorted() for name, rows in collector.rows.items()}
    # An operator is answered with a status as well; those count that came with a demand.
    demands = found["tau_desired"][0] if "tau_desired" in found else None
    for name in _BY_NAME["controller_status"].series:
        if name in found and demands is not None:
            kept = np.isin(found[name][0], demands)
            found[name] = found[name][0][kept], found[name][1][kept]
    started = min((int(stamps[0]) for stamps, _ in found.values() if len(stamps)), default=0)
    zero = started if started > _LONGEST_RUN_NS else 0
    series = {name: Series(_seconds(stamps, zero), rows) for name, (stamps, rows) in found.items()}
    labels = {}
    for name, words in collector.words.items():
        of_status = name in _BY_NAME["controller_status"].words.values()
        stamps, changes = words.changes(demands if of_status else None)
        labels[name] = Labels(_seconds(stamps, zero), changes)
    return RunData(RunInfo("", "", ""), vessel.thruster_names, series, labels, vessel.degrees_of_freedom)


def _info(
    records: Mapping[str, Mapping[str, str]],
    vessel: Vessel,
    scenario: Scenario | None,
    end: float,
    pace: _Raw | None,
) -> RunInfo:
    """Return who sailed what: as the run itself has written it down, or as the recording shows."""
    if RUN_RECORD in records:
        own = {field.name for field in fields(RunInfo)}
        return RunInfo(**{name: json.loads(text) for name, text in records[RUN_RECORD].items() if name in own})
    first, last = (pace.first, pace.last) if pace else (0, 0)
    return RunInfo(
        scenario=scenario.name if scenario else "",
        vessel=vessel.name,
        how="node graph",
        seed=scenario.seed if scenario else 0,
        versions=records.get(VERSIONS_RECORD, {}),
        started=_iso(first),
        simulated_time=min(end + vessel.simulation.time_step, scenario.duration) if scenario else end,
        wall_time=(last - first) * 1e-9,
    )


def documents(attachments: Mapping[str, bytes], vessel_name: str, file: Path) -> tuple[Vessel, Scenario | None]:
    """Return the vessel and the scenario of a bag. Files on this machine are not looked at unless named.

    Raises DpError if it holds no vessel and none is named, or one of the two is not valid.
    """
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
            scenario = load_scenario(Path(folder) / SCENARIO_ATTACHMENT, vessel, scale=False)
            scenario._path = None  # the file is gone with its folder
        return vessel, scenario


def _iso(nanoseconds: int) -> str:
    if nanoseconds <= 0:
        return ""
    return str(np.datetime64(nanoseconds // _NANOSECONDS, "s")) + "+00:00"
