"""Bags, spoiled: a small good one to begin with, and all that reads a bag."""

from __future__ import annotations

import tempfile
import zlib
from collections.abc import Callable
from functools import cache
from io import BytesIO
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk, DataEnd, Footer, Header

from dp_tools.bag_reader import read_bag
from dp_tools.bags.bag import Bag, open_bag
from dp_tools.bags.check import check_bag
from dp_tools.bags.errors import BagError
from dp_tools.bags.info import bag_info
from dp_tools.bags.mcap_records import MAGIC, parsed, raw_records, unpacked
from dp_tools.bags.parameters import parameters_at
from dp_tools.bags.repair import repair
from dp_tools.in_process import ClosedLoop
from dp_tools.reexecution.recording import recording_of
from dp_tools.run_bag import write_bag
from dp_tools.scenario import load_scenario
from marine_model import load_vessel
from marine_model.errors import DpError
from support.bag_of_run import BagOfRun

_SCENARIO = """\
name: short
title: Short
description: Two samples.
vessel: cybership3
duration: 0.4
seed: 4
parameters:
  dp_controller: {mode: setpoint}
events:
  - {at: 0.0, setpoint: [0.2, 0.1, -3.1]}
  - {at: 0.2, label: rotate, parameters: {thrust_allocator: {azimuth_mode: rotating}}}
"""


@cache
def run_bags() -> tuple[bytes, ...]:
    """The first samples of a run as one file each: as the graph is recorded, and as a run in process is."""
    vessel = load_vessel("cybership3")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "short.yaml"
        path.write_text(_SCENARIO, encoding="utf-8")
        scenario = load_scenario(path)
        run = ClosedLoop(vessel, scenario).run()
        graph = Path(folder) / "graph.mcap"
        BagOfRun(run, vessel).write(graph, path)
        own = write_bag(Path(folder) / "bag", run, vessel, scenario)
        return graph.read_bytes(), (own / "bag_0.mcap").read_bytes()


@cache
def chunks() -> tuple[bytes, ...]:
    """What is in their chunks."""
    return tuple(
        unpacked(parsed(raw), raw.start)
        for data in run_bags()
        for raw in raw_records(BytesIO(data), len(data))
        if raw.opcode == Opcode.CHUNK
    )


def of_chunk(content: bytes) -> bytes:
    """A file of one chunk with this in it, checksums right: what is wrong with it is not told by them."""
    builder = RecordBuilder()
    Header("ros2", "fuzz").write(builder)
    Chunk("", content, 0, 0, zlib.crc32(content), len(content)).write(builder)
    DataEnd(0).write(builder)
    Footer(0, 0, 0).write(builder)
    return MAGIC + bytes(builder.end()) + MAGIC


def read_spoiled_bag(path: Path) -> None:
    """Hand a file to everything that reads a bag.

    What is read of it is looked at as far as it tells by itself: a bag that is said to be whole can be read, and one
    that was repaired is whole. Raises DpError where anything of it was refused.
    """
    refused: list[DpError] = []

    def attempt(read: Callable[[], object]) -> None:
        try:
            read()
        except DpError as error:
            refused.append(error)

    checked = None
    try:
        checked = check_bag(path)
    except DpError as error:
        refused.append(error)
    attempt(lambda: _read(path))
    if checked is not None and not checked.needs_repair and refused:
        raise AssertionError(f"said to be whole, and refused: {refused[0]}")
    if checked is not None and not checked.whole:
        refused.append(BagError("; ".join(str(one) for one in (*checked.structure, *checked.content))))
    attempt(lambda: read_bag(path))
    with tempfile.TemporaryDirectory() as folder:
        new = Path(folder) / "new"
        attempt(lambda: repair(path, new))
        if list(new.glob("*.mcap")):
            again = check_bag(new)
            if again.messages and again.structure:
                raise AssertionError(f"repaired, and not whole: {again.structure[0]}")
            attempt(lambda: read_bag(new))
    if refused:
        raise refused[0]


def _read(path: Path) -> None:
    with open_bag(path) as bag:
        _look_at(bag)


def _look_at(bag: Bag) -> None:
    bag_info(bag)
    for row in range(len(bag.messages)):
        bag.data(row)
    recording_of(bag)
    parameters_at(bag, 1 << 62)
