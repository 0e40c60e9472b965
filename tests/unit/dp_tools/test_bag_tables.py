"""Bags as tables: every value comes back, with its unit; and what a bag says of itself."""

from __future__ import annotations

import csv
import json
import math
import sys
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from dp_msgs.msg import ActuatorSetpoint, AllocationStatus, ObserverState
from hypothesis import given, settings
from hypothesis import strategies as st
from sensor_msgs.msg import JointState, PointField

from dp_tools.bags.bag import open_bag
from dp_tools.bags.definitions import definitions_in
from dp_tools.bags.tables import write_tables
from support.dp_here import Dp, dp_here
from support.made_bag import CLOCK, START, clock, make_bag

__all__ = ["dp_here"]

SETPOINT = "dp_msgs/msg/ActuatorSetpoint"
# Any double there is, and any text that a message can hold.
NUMBERS = st.floats(allow_nan=True, allow_infinity=True)
TEXTS = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=12)


def setpoint(stamp: int, names: list[str], torque: list[float], stale: bool = False) -> ActuatorSetpoint:
    message = ActuatorSetpoint(name=names, torque=torque, command_stale=stale)
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 1_000_000_000)
    return message


def read_csv(path: Path) -> tuple[list[str], list[list[str]]]:
    with path.open(encoding="utf-8", newline="") as stream:
        head, *rows = csv.reader(stream)
    return head, rows


def same(one: float, other: float) -> bool:
    return one == other or (math.isnan(one) and math.isnan(other))


@settings(max_examples=30)  # a bag and two tables each
@given(
    st.lists(
        st.tuples(st.integers(0, 2**31 - 1), st.lists(st.tuples(TEXTS, NUMBERS), max_size=4), st.booleans()),
        min_size=1,
        max_size=6,
    )
)
def test_values_come_back_to_the_bit(
    tmp_path_factory: pytest.TempPathFactory, sent: list[tuple[int, list[tuple[str, float]], bool]]
) -> None:
    """By CSV and Parquet, with arrays of different lengths: what a message does not have is empty."""
    import pyarrow.parquet

    folder = tmp_path_factory.mktemp("tables")
    messages = [
        ("/ship/actuator_setpoint", 0.1 * k, setpoint(stamp, [name for name, _ in items], [x for _, x in items], stale))
        for k, (stamp, items, stale) in enumerate(sent)
    ]
    bag = make_bag(folder / "bag", messages, {"/ship/actuator_setpoint": SETPOINT})
    with open_bag(bag) as opened:
        names = [topic.name for topic in opened.topics]
        ((_, path, rows, columns),) = write_tables(opened, names, folder / "csv")
        ((_, parquet, *_),) = write_tables(opened, names, folder / "parquet", parquet=True)
    assert path == folder / "csv" / "ship.actuator_setpoint.csv"
    head, lines = read_csv(path)
    table = pyarrow.parquet.read_table(parquet)
    assert (rows, columns) == (len(sent), len(head)) == (len(lines), table.num_columns)
    assert table.schema.metadata[b"type"] == SETPOINT.encode()
    places = {name.partition(" [")[0]: place for place, name in enumerate(head)}
    wide = max(len(items) for _, items, _ in sent)
    assert [name for name in head if name.startswith(("torque", "name"))] == [
        *(f"name[{k}]" for k in range(wide)),
        *(f"torque[{k}] [N m]" for k in range(wide)),
    ]
    for k, (stamp, items, stale) in enumerate(sent):
        line, row = lines[k], {name: table[name][k] for name in table.column_names}
        assert int(line[places["header.stamp"]]) == row["header.stamp"].as_py() == stamp
        assert int(line[places["publish_time"]]) == row["publish_time"].value == START + round(0.1 * k * 1e9)
        assert int(line[places["log_time"]]) == row["log_time"].value
        assert (line[places["command_stale"]] == "true") is row["command_stale"].as_py() is stale
        for i in range(wide):
            number, word = row[f"torque[{i}]"].as_py(), row[f"name[{i}]"].as_py()
            if i < len(items):
                assert same(float(line[places[f"torque[{i}]"]]), items[i][1])
                assert same(number, items[i][1])
                assert line[places[f"name[{i}]"]] == word == items[i][0]
            else:
                assert (number, word) == (None, None)
                assert line[places[f"torque[{i}]"]] == line[places[f"name[{i}]"]] == ""


def test_units_stand_where_the_definition_tells_them(tmp_path: Path) -> None:
    import pyarrow.parquet

    status = AllocationStatus(status="optimal", slack=[0.1, 0.2, 0.3], bus_power=[1.0])
    observed = ObserverState(bias=[0.1, 0.2, 0.3])
    kinds = {"/allocation_status": "dp_msgs/msg/AllocationStatus", "/observer_state": "dp_msgs/msg/ObserverState"}
    messages = [("/allocation_status", 0.0, status), ("/observer_state", 0.0, observed)]
    with open_bag(make_bag(tmp_path / "bag", messages, kinds)) as opened:
        ((_, path, *_),) = write_tables(opened, ["/allocation_status"], tmp_path)
        ((_, other, *_),) = write_tables(opened, ["/observer_state"], tmp_path)
        ((_, parquet, *_),) = write_tables(opened, ["/observer_state"], tmp_path, parquet=True)
    head, _ = read_csv(path)
    bias, _ = read_csv(other)
    assert {"bias[0] [N]", "bias[2] [N m]"} <= set(bias)
    for name in (
        "header.stamp [ns]",
        "slack[0]",  # along which axis, the definition does not tell
        "demanded_power [W]",
        "weakest_azimuth [rad]",
        "cost",
        "margin",
    ):
        assert name in head
    schema = pyarrow.parquet.read_schema(parquet)
    assert schema.field("bias[2]").metadata == {b"unit": b"N m"}
    assert schema.field("valid").metadata is None
    # In the order of the definition.
    assert head.index("status") < head.index("slack[0]") < head.index("bus_power[0] [W]") < head.index("released")


def test_comments_of_definitions() -> None:
    text = (
        "# Numbers of a thing.\nfloat64 a   # N m, motor torque\n# above it\nfloat64 b\nint32 K=5 # m\n"
        "float64[3] c # m, m, rad in map_ned\n"
        "float64 d # stamp of it\nfloat64 e # m/s^2; NaN without one\ngeometry_msgs/Point p\nfloat64 f # P/D\n"
        + "=" * 80
        + "\nMSG: geometry_msgs/Point\nfloat64 x # m\n"
    )
    found = definitions_in("my_msgs/msg/Thing", text)
    thing = found["my_msgs/msg/Thing"]
    assert {name: thing.units(name) for name in thing.comments} == {
        "a": ("N m",),
        "b": (),
        "c": ("m", "m", "rad"),
        "d": (),
        "e": ("m/s^2",),
        "p": (),
        "f": (),
    }
    assert [name for name in thing.comments if thing.may_be_none(name)] == ["e"]
    assert thing.comments["b"] == "above it"
    assert found["geometry_msgs/msg/Point"].units("x") == ("m",)
    assert definitions_in("m/msg/N", "# NaN where not asked for\nfloat64 a")["m/msg/N"].may_be_none("a")


def test_arrays_of_messages_times_bytes_and_single_precision(tmp_path: Path) -> None:
    array = DiagnosticArray(
        status=[
            DiagnosticStatus(
                level=b"\x01", name="one", values=[KeyValue(key="k", value="v"), KeyValue(key="l", value="w")]
            ),
            DiagnosticStatus(level=b"\x02", name="two"),
        ]
    )
    kinds = {
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
        "/clock": CLOCK,
        "/joints": "sensor_msgs/msg/JointState",
        "/field": "sensor_msgs/msg/PointField",
        "/battery": "sensor_msgs/msg/BatteryState",
    }
    from sensor_msgs.msg import BatteryState

    bag = make_bag(
        tmp_path / "bag",
        [
            ("/diagnostics", 0.0, array),
            ("/diagnostics", 0.1, DiagnosticArray()),
            ("/clock", 0.2, clock(1.5)),
            ("/joints", 0.3, JointState()),
            ("/field", 0.4, PointField(name='x, "y"\nz', offset=7)),
            ("/battery", 0.5, BatteryState(voltage=0.1)),
        ],
        kinds,
    )
    with open_bag(bag) as opened:
        written = write_tables(opened, list(kinds), tmp_path)
    files = {name: read_csv(path) for name, path, *_ in written}
    head, rows = files["/diagnostics"]
    row = dict(zip(head, rows[0], strict=True))
    assert (row["status[0].level"], row["status[0].values[1].value"], row["status[1].name"]) == ("1", "w", "two")
    assert set(rows[1][head.index("status[0].level") :]) == {""}
    assert files["/clock"][0][2:] == ["clock [ns]"]
    assert files["/clock"][1][0][2:] == ["1500000000"]
    assert files["/field"][1][0][2:5] == ['x, "y"\nz', "7", "0"]
    head, rows = files["/battery"]
    assert rows[0][head.index("voltage")] == "0.1"


def test_commands(dp_here: Dp, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bag = make_bag(tmp_path / "bag", [("/a", 0.0, "x"), ("/b", 1.0, "y")])
    code, output = dp_here("bag", "to-csv", bag, "--topics", "a")
    assert code == 0, output
    assert [path.name for path in (tmp_path / "bag_csv").iterdir()] == ["a.csv"]
    assert (
        tmp_path / "bag_csv" / "a.csv"
    ).read_text() == f"log_time [ns],publish_time [ns],data\n{START + 1_000_000},{START},x\n"
    code, output = dp_here("bag", "to-csv", bag)
    assert (code, output.count("\n")) == (1, 1)
    assert "a.csv: is there already; --overwrite replaces it" in output
    assert dp_here("bag", "to-csv", bag, "--overwrite")[0] == 0
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    code, output = dp_here("bag", "to-parquet", bag)
    assert (code, output.count("\n")) == (1, 1)
    assert "error: Parquet needs the package pyarrow, which is not installed here" in output
    assert not (tmp_path / "bag_parquet").exists()


@pytest.mark.parametrize("command", [("info",), ("check",), ("to-csv",), ("to-parquet",), ("trim", "--output", "new")])
def test_what_is_no_bag_is_told_in_one_line(
    dp_here: Dp, tmp_path: Path, command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "noise").mkdir()
    (tmp_path / "noise" / "noise_0.mcap").write_bytes(bytes(range(256)) * 4)
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("not a bag")
    for name, message in (
        ("nowhere", "nowhere: no such bag"),
        ("empty", "empty: expected MCAP files, found none"),
        ("file", "not an MCAP file" if command == ("check",) else "expected an MCAP file, found something else"),
        ("noise", "not an MCAP file" if command == ("check",) else "expected an MCAP file, found something else"),
    ):
        code, output = dp_here("bag", command[0], tmp_path / name, *command[1:])
        assert code == 1
        assert message in output
        assert "Traceback" not in output
    assert not (tmp_path / "new").exists()


def test_info(dp_here: Dp, tmp_path: Path) -> None:
    attachments = {
        "vessel.yaml": b"name: some vessel\n",
        "parameters/ship/allocator.yaml": b"/**/allocator:\n  ros__parameters: {gain: 1.0, name: x}\n",
    }
    messages: list[Any] = [("/a", 0.5 * k, "x") for k in range(5)]
    bag = make_bag(tmp_path / "bag", messages, None, None, attachments, delay=0.0)
    code, output = dp_here("bag", "info", bag, "--json")
    assert code == 0
    told = json.loads(output)
    assert (told["messages"], told["duration"], told["begin"]) == (5, 2.0, START * 1e-9)
    assert told["vessel"] == "some vessel"
    assert told["parameters"] == {"/ship/allocator": {"snapshots": 1, "parameters": 2, "changes": 0}}
    assert told["compression"] == {"zstd": 1}
    (topic,) = told["topics"]
    assert topic == {
        "name": "/a",
        "type": "std_msgs/msg/String",
        "messages": 5,
        "rate": 2.0,
        "quality": "reliable, volatile",
        "lost": 0,
    }
    code, output = dp_here("bag", "info", bag)
    assert code == 0
    assert "some vessel" in output
