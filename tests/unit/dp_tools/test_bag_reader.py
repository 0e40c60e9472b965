"""A run that is written as a bag and read back is the same run."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from dp_tools.bag_reader import read_bag
from dp_tools.bags.errors import BagError
from dp_tools.in_process import ClosedLoop
from dp_tools.recorder.bag_metadata import TopicInfo
from dp_tools.recorder.bag_writer import BagWriter, Limits
from dp_tools.report import report_bag
from dp_tools.run_data import RunData
from dp_tools.scenario import Scenario, load_scenario
from marine_model import Vessel, load_vessel
from marine_model.errors import DocumentError, UnknownNameError
from support.bag_of_run import BagOfRun
from support.repository import SCENARIOS

SHORT = """\
name: short
title: Short
description: A lost pose, a switch and a measured window.
vessel: cybership3
duration: 12.0
seed: 4
parameters:
  vessel_sim: {waves.amplitude: 0.03, waves.period: 0.8, pose_dropout: 0.2, initial.heading: 3.1}
  dp_controller: {mode: setpoint}
events:
  - {at: 0.0, setpoint: [0.2, 0.1, -3.1]}
  - {at: 6.0, label: rotate, parameters: {thrust_allocator: {azimuth_mode: rotating}}}
windows:
  end: [4.0, 12.0]
figures:
  - {name: power, kind: mean_power, title: Mean power, window: end}
"""


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    path = tmp_path_factory.mktemp("scenario") / "short.yaml"
    path.write_text(SHORT, encoding="utf-8")
    return load_scenario(path)


@pytest.fixture(scope="module")
def run(vessel: Vessel, scenario: Scenario) -> RunData:
    return ClosedLoop(vessel, scenario).run()


@pytest.fixture(scope="module")
def bag(run: RunData, vessel: Vessel, scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run") / "bag"
    folder.mkdir()
    BagOfRun(run, vessel).write(folder / "bag_0.mcap", scenario.path)
    return folder


def test_every_series_comes_back_to_the_bit(bag: Path, run: RunData) -> None:
    read = read_bag(bag).run
    assert set(read.series) == set(run.series)
    for name, series in run.series.items():
        assert np.array_equal(read[name].t, series.t), name
        if name in ("pose", "truth_position", "estimate_position"):
            # A heading is a quaternion on the way: one more rounding.
            assert read[name].values == pytest.approx(series.values, abs=1e-15, nan_ok=True), name
        else:
            assert np.array_equal(read[name].values, series.values, equal_nan=True), name


def test_a_split_bag_is_read_as_one(bag: Path, tmp_path: Path) -> None:
    writer = BagWriter(tmp_path / "bag", limits=Limits(size=100_000))
    with (bag / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        for attachment in reader.iter_attachments():
            writer.attach(attachment.name, attachment.media_type, attachment.data, attachment.log_time)
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None
            if channel.id not in channels:
                channels[channel.id] = writer.add_topic(TopicInfo(channel.topic, schema.name), schema.data.decode())
            writer.write(channels[channel.id], message.data, message.log_time, message.publish_time)
    writer.close()
    assert len(list((tmp_path / "bag").glob("*.mcap"))) > 2
    split, whole = read_bag(tmp_path / "bag").run, read_bag(bag).run
    assert set(split.series) == set(whole.series)
    for name, series in whole.series.items():
        assert np.array_equal(split[name].t, series.t), name
        assert np.array_equal(split[name].values, series.values, equal_nan=True), name
    assert split.labels.keys() == whole.labels.keys()
    assert split.info.wall_time == whole.info.wall_time


def test_lost_poses_are_gaps(bag: Path) -> None:
    lost = np.isnan(read_bag(bag).run["pose"].values).all(axis=1)
    assert 0 < lost.sum() < len(lost)


def test_words_come_back(bag: Path, run: RunData) -> None:
    read = read_bag(bag).run
    assert set(read.labels) == set(run.labels)
    for name, labels in run.labels.items():
        assert read.labels[name].words == labels.words, name
        assert read.labels[name].t == pytest.approx(labels.t), name
    assert read.labels["azimuth_mode"].words == ("fixed", "rotating")


def test_bag_says_what_ran(bag: Path, scenario: Scenario, vessel: Vessel) -> None:
    recorded = read_bag(bag)
    assert recorded.vessel == vessel
    assert recorded.scenario is not None
    assert recorded.scenario.model_dump() == scenario.model_dump()
    info = recorded.run.info
    assert (info.scenario, info.vessel, info.seed) == ("short", vessel.name, 4)
    assert info.versions == {"dp_tools": "1.2.3"}
    assert info.simulated_time == pytest.approx(12.0)
    # Logged ten times faster than stamped; the last feedback comes one step of 0.02 s before the end.
    assert info.real_time_factor == pytest.approx(10.0, rel=0.01)
    assert info.started == "2026-01-01T00:00:00+00:00"


def test_report_of_a_bag(bag: Path, tmp_path: Path) -> None:
    page, figures = report_bag(bag, tmp_path / "out", picture=tmp_path / "images" / "run.png")
    assert (tmp_path / "images" / "run.png").read_bytes().startswith(b"\x89PNG")
    assert page.read_text(encoding="utf-8").count("<img") == 9
    assert '"name": "power"' in figures.read_text(encoding="utf-8")


def test_file_instead_of_folder_and_namespace(run: RunData, vessel: Vessel, scenario: Scenario, tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    BagOfRun(run, vessel).write(path, scenario.path, namespace="/ship")
    assert np.array_equal(read_bag(path).run["power"].values, run["power"].values)


def test_bag_without_scenario_has_a_report_too(run: RunData, vessel: Vessel, tmp_path: Path) -> None:
    BagOfRun(run, vessel).write(tmp_path / "free.mcap", None)
    assert read_bag(tmp_path / "free.mcap").scenario is None
    page, figures = report_bag(tmp_path / "free.mcap", tmp_path)
    assert "Run without a scenario" in page.read_text(encoding="utf-8")
    assert '"figures": []' in figures.read_text(encoding="utf-8")


def test_wall_clock_stamps_count_from_the_first(
    run: RunData, vessel: Vessel, scenario: Scenario, tmp_path: Path
) -> None:
    BagOfRun(run, vessel, start_ns=1_767_000_000_000_000_000).write(tmp_path / "wall.mcap", scenario.path)
    read = read_bag(tmp_path / "wall.mcap").run
    assert read["pose"].t == pytest.approx(run["pose"].t, abs=1e-9)


def test_custom_vessel_of_the_scenario_need_not_be_on_this_machine(
    run: RunData, vessel: Vessel, tmp_path: Path
) -> None:
    (tmp_path / "s.yaml").write_text(SHORT.replace("vessel: cybership3", "vessel: elsewhere.yaml"), encoding="utf-8")
    BagOfRun(run, vessel).write(tmp_path / "b.mcap", tmp_path / "s.yaml")
    recorded = read_bag(tmp_path / "b.mcap")
    assert recorded.scenario is not None
    assert recorded.scenario.vessel == "elsewhere.yaml"


def test_bag_without_vessel(run: RunData, vessel: Vessel, tmp_path: Path) -> None:
    BagOfRun(run, vessel).write(tmp_path / "b.mcap", None, with_vessel=False)
    with pytest.raises(UnknownNameError, match=r"b\.mcap: holds no vessel file; name the vessel"):
        read_bag(tmp_path / "b.mcap")
    assert read_bag(tmp_path / "b.mcap", "cybership3").vessel == vessel


def test_other_thrusters_are_refused(run: RunData, vessel: Vessel, tmp_path: Path) -> None:
    BagOfRun(run, vessel).write(tmp_path / "b.mcap", None, with_vessel=False)
    document = tmp_path / "other.yaml"
    document.write_text("extends: cybership3\nname: other\n", encoding="utf-8")
    text = (SCENARIOS.parents[1] / "marine_model/marine_model/vessels/cybership3.yaml").read_text(encoding="utf-8")
    document.write_text(text.replace("azimuth_bow", "azimuth_fore"), encoding="utf-8")
    with pytest.raises(BagError, match=r"expected the thrusters .*azimuth_fore.*found .*azimuth_bow"):
        read_bag(tmp_path / "b.mcap", str(document))


def test_bad_scenario_in_a_bag_is_named(run: RunData, vessel: Vessel, tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SHORT.replace("duration: 12.0", "duration: long"), encoding="utf-8")
    BagOfRun(run, vessel).write(tmp_path / "b.mcap", tmp_path / "s.yaml")
    with pytest.raises(DocumentError, match=r"scenario\.yaml:5: duration: Input should be a valid number"):
        read_bag(tmp_path / "b.mcap")


def test_what_is_no_bag(bag: Path, tmp_path: Path) -> None:
    with pytest.raises(BagError, match="nowhere: no such bag"):
        read_bag(tmp_path / "nowhere")
    with pytest.raises(BagError, match="expected MCAP files, found none"):
        read_bag(tmp_path)
    (tmp_path / "text.mcap").write_text("not a recording", encoding="utf-8")
    with pytest.raises(BagError, match=r"text\.mcap: expected an MCAP file"):
        read_bag(tmp_path / "text.mcap")
    whole = (bag / "bag_0.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BagError, match=r"cut\.mcap: cannot be read to its end: byte \d+: .*the file ends"):
        read_bag(tmp_path / "cut.mcap")


def test_files_of_two_bags_are_refused(bag: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        shutil.copy(bag / "bag_0.mcap", tmp_path / f"{name}.mcap")
    with pytest.raises(BagError, match=r"expected the files of one bag, found one\.mcap, two\.mcap; name"):
        read_bag(tmp_path)
