"""Propellers in vessel files: one kind for every model, data files, controllable pitch, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from marine_model import Vessel, load_vessel
from marine_model.errors import DocumentError
from marine_model.propellers import FourQuadrantPropeller, TabulatedPropeller, WageningenBPropeller
from marine_model.propellers.kernel import thrust_torque
from marine_model.propellers.sections import BollardData

B_SERIES = "{model: wageningen_b, diameter: 0.09, blades: 4, area_ratio: 0.7, pitch_ratio: 0.93}"
TABLE = """\
pitch_ratio: [0.8, 1.0]
advance_number: [0.0, 0.3, 0.6]
thrust_coefficient:
  - [0.36, 0.24, 0.1]
  - [0.46, 0.35, 0.2]
torque_coefficient:
  - [0.040, 0.032, 0.018]
  - [0.055, 0.045, 0.030]
"""
# Lower than the motor's torque at the thrust of the port thruster allows for.
SHAFT = "shaft: {torque_max: 0.3}"


def ship(folder: Path, propeller: str, more: str = "") -> Path:
    """Write a vessel whose port thruster has ``propeller``, over CyberShip III."""
    path = folder / "ship.yaml"
    lines = [
        "extends: cybership3",
        "thrusters:",
        "  - name: azimuth_port",
        f"    propeller: {propeller}",
        f"    {SHAFT}",
    ]
    path.write_text("\n".join([*lines, *(f"    {line}" for line in more.splitlines())]) + "\n", encoding="utf-8")
    return path


def problem(path: Path) -> str:
    with pytest.raises(DocumentError) as caught:
        load_vessel(path)
    (line,) = str(caught.value).splitlines()
    return line


def test_b_series_in_a_vessel_file(tmp_path: Path) -> None:
    vessel = load_vessel(ship(tmp_path, B_SERIES))
    model = vessel.propeller_models[2]
    assert isinstance(model, WageningenBPropeller)
    K_T, K_Q = (float(k) for k in model.coefficients(0.0))
    assert vessel.propellers.thrust_per_speed_squared[2] == pytest.approx(K_T * 1000.0 * 0.09**4)
    assert vessel.propellers.torque_per_speed_squared[2] == pytest.approx(K_Q * 1000.0 * 0.09**5)
    assert vessel.pitch_ratio.tolist() == [0.81, 1.14, 0.93, 1.01]
    # The others are as they were.
    assert vessel.propellers.thrust_per_speed_squared[3] == pytest.approx(0.46 * 1000.0 * 0.09**4)


def test_the_table_of_rows_holds_every_model(tmp_path: Path) -> None:
    vessel = load_vessel(ship(tmp_path, B_SERIES))
    table = vessel.propeller_table
    assert len(table) == 4
    assert not table.flags.writeable
    for row, model in zip(table, vessel.propeller_models, strict=True):
        found = thrust_torque(row, model.diameter, 1000.0, 12.0, 0.3, model.pitch_ratio)
        np.testing.assert_allclose(found, np.array(model.forces(12.0, 0.3, 1000.0)), rtol=1e-12)


def test_a_table_in_the_vessel_file_and_beside_it(tmp_path: Path) -> None:
    indented = "\n" + "".join(f"        {line}\n" for line in TABLE.splitlines())
    inline = f"\n      model: tabulated\n      diameter: 0.09\n      pitch_ratio: 0.9\n      table:{indented.rstrip()}"
    one = load_vessel(ship(tmp_path, inline))
    (tmp_path / "mine.yaml").write_text(f"source: towing tank\n{TABLE}", encoding="utf-8")
    other = load_vessel(ship(tmp_path, "{model: tabulated, diameter: 0.09, pitch_ratio: 0.9, file: mine.yaml}"))
    assert isinstance(one.propeller_models[2], TabulatedPropeller)
    np.testing.assert_array_equal(one.propeller_table, other.propeller_table)
    assert one.propeller_models[2].pitch_range == (0.8, 1.0)


def test_a_data_file_is_looked_for_beside_the_file_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "base").mkdir()
    (tmp_path / "base" / "mine.yaml").write_text(TABLE, encoding="utf-8")
    ship(tmp_path / "base", "{model: tabulated, diameter: 0.09, pitch_ratio: 0.9, file: mine.yaml}")
    (tmp_path / "over.yaml").write_text("extends: base/ship.yaml\nname: over\n", encoding="utf-8")
    assert isinstance(load_vessel(tmp_path / "over.yaml").propeller_models[2], TabulatedPropeller)


def test_the_packaged_four_quadrant_demonstration(tmp_path: Path) -> None:
    """Its source is the B4-70, so that it must come near it in the first quadrant: as near as the file says."""
    vessel = load_vessel(
        ship(tmp_path, "{model: four_quadrant, diameter: 0.09, pitch_ratio: 0.93, file: b4_70_continued.yaml}")
    )
    model = vessel.propeller_models[2]
    assert isinstance(model, FourQuadrantPropeller)
    assert model.pitch_range == (0.5, 1.4)
    known = WageningenBPropeller(0.09, 4, 0.7, 0.93)
    text = (Path(load_vessel.__code__.co_filename).parent / "data" / "b4_70_continued.yaml").read_text(encoding="utf-8")
    said = re.search(r"here: ([0-9.]+) in C_T, ([0-9.]+) in C_Q", text)
    assert said is not None
    angle = np.radians(np.linspace(-180.0, 180.0, 721))
    n, speed = np.cos(angle) / (0.7 * np.pi * 0.09), np.sin(angle)
    scale = 0.5 * np.pi / 4.0 * 0.09**2
    thrust, torque = model.forces(n, speed, 1.0)
    known_thrust, known_torque = known.forces(n, speed, 1.0)
    # Between the pitch ratios of the file a spline adds to it; a tenth is allowed for that.
    assert np.abs(thrust - known_thrust).max() / scale < 1.1 * float(said[1])
    assert np.abs(torque - known_torque).max() / (scale * 0.09) < 1.1 * float(said[2])


def test_a_vessel_goes_through_its_own_dump(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(TABLE, encoding="utf-8")
    vessel = load_vessel(ship(tmp_path, "{model: tabulated, diameter: 0.09, pitch_ratio: 0.9, file: mine.yaml}"))
    assert Vessel.model_validate(vessel.model_dump()).model_dump() == vessel.model_dump()
    # A recording has the vessel without the files that it was read from.
    recorded = tmp_path / "recorded" / "vessel.yaml"
    recorded.parent.mkdir()
    recorded.write_text(yaml.safe_dump(vessel.model_dump(mode="json"), sort_keys=False), encoding="utf-8")
    assert load_vessel(recorded).model_dump() == vessel.model_dump()


def test_shaft_depths_with_and_without_trim() -> None:
    """Draught 0.16 m: half of it, below the keel by R = 0.03, inside by R = 0.045."""
    np.testing.assert_allclose(load_vessel("cybership3").shaft_depth, [0.08, 0.19, 0.115, 0.115])
    trimmed = load_vessel("cybership3_trimmed")
    # h/R = 1 with R = 0.045 m; the trim is written with four digits.
    np.testing.assert_allclose(trimmed.shaft_depth[2:] / 0.045, 1.0, rtol=1e-5)
    np.testing.assert_allclose(trimmed.shaft_depth[:2], [0.08 + 0.84 * 0.08642, 0.19 + 0.76 * 0.08642])
    assert trimmed.allocator.thrust_weight == (6.62, 1.2, 0.90, 0.91)  # (B.33)


def test_the_trimmed_ship_differs_in_trim_what_waves_do_weights_and_least_shaft_speeds_only() -> None:
    dumps = [load_vessel(name).model_dump() for name in ("cybership3", "cybership3_trimmed")]
    for dump in dumps:
        del dump["name"], dump["description"], dump["hull"]["trim"], dump["allocator"]["thrust_weight"]
        del dump["drivers"]["ventilation"]["speed_min"], dump["wave_forces"]
    assert dumps[0] == dumps[1]


@pytest.mark.parametrize("j", range(4))
def test_estimates_in_the_file_are_what_their_comment_says(j: int) -> None:
    """P/D (two digits) of the B4-70 with the same K_T at J = 0, and its secants from J = 0 to 0.4."""
    data = load_vessel("cybership3").thrusters[j].propeller
    assert isinstance(data, BollardData)
    b = WageningenBPropeller(0.1, 4, 0.7, data.pitch_ratio)
    for pitch, above in ((data.pitch_ratio - 0.005, False), (data.pitch_ratio + 0.005, True)):
        assert (float(b.coefficients(0.0, pitch)[0]) > data.thrust_coefficient) is above
    (t0, q0), (t4, q4) = b.coefficients(0.0), b.coefficients(0.4)
    # Three digits are written down.
    assert data.thrust_slope == pytest.approx((t4 - t0) / 0.4 * data.thrust_coefficient / t0, rel=2e-3)
    assert data.torque_slope == pytest.approx((q4 - q0) / 0.4 * data.torque_coefficient / q0, rel=4e-3)


PITCH = "pitch: {min: 0.6, max: 1.2, rate: 0.5, time_constant: 0.2}"


def test_a_controllable_pitch(tmp_path: Path) -> None:
    pitch = load_vessel(ship(tmp_path, B_SERIES, PITCH)).thrusters[2].pitch
    assert pitch is not None
    assert (pitch.min, pitch.max, pitch.rate, pitch.time_constant) == (0.6, 1.2, 0.5, 0.2)
    assert load_vessel("cybership3").thrusters[2].pitch is None


HERE = "thrusters.2."
RISES = "expected a finite number above {} before it, found {}"
BOLLARD = "{model: bollard, diameter: 0.09, pitch_ratio: 0.93, thrust_coefficient: 0.42, torque_coefficient: 0.0442}"


@pytest.mark.parametrize(
    ("propeller", "more", "message"),
    [
        (B_SERIES.replace("0.09", "0.0"), "", "propeller.diameter: Input should be greater than 0, found 0.0"),
        (B_SERIES.replace("0.09", "-1.0"), "", "propeller.diameter: Input should be greater than 0, found -1.0"),
        (
            B_SERIES.replace("0.93", "1.5"),
            "",
            "propeller.pitch_ratio: Input should be less than or equal to 1.4, found 1.5",
        ),
        (
            B_SERIES.replace("blades: 4", "blades: 8"),
            "",
            "propeller.blades: Input should be less than or equal to 7, found 8",
        ),
        (
            B_SERIES.replace("0.7", "0.2"),
            "",
            "propeller.area_ratio: Input should be greater than or equal to 0.3, found 0.2",
        ),
        (B_SERIES.replace(", blades: 4", ""), "", "propeller.blades: Field required"),
        (
            B_SERIES.replace("wageningen_b", "gawn"),
            "",
            "propeller.model: expected one of bollard, polynomial, wageningen_b, four_quadrant, tabulated, "
            "found 'gawn'",
        ),
        (
            B_SERIES.replace("wageningen_b", "[1]"),
            "",
            "propeller.model: expected one of bollard, polynomial, wageningen_b, four_quadrant, tabulated, found [1]",
        ),
        (
            BOLLARD.replace("0.0442", "0.0"),
            "",
            "propeller.torque_coefficient: Input should be greater than 0, found 0.0",
        ),
        (
            BOLLARD.replace("}", ", torque_slope: 0.1}"),
            "",
            "propeller.torque_slope: Input should be less than or equal to 0, found 0.1",
        ),
        (BOLLARD, PITCH, "pitch: expected none, because the propeller model 'bollard' knows one pitch ratio"),
        (
            B_SERIES,
            PITCH.replace("0.6", "1.3"),
            "pitch: pitch.min must be below pitch.max, found 1.3 and 1.2",
        ),
        (
            B_SERIES,
            PITCH.replace("0.6", "0.4"),
            "pitch: expected min and max from 0.5 to 1.4, those of the propeller's data, found 0.4 and 1.2",
        ),
        (
            B_SERIES,
            PITCH.replace("1.2", "0.9"),
            "propeller.pitch_ratio: expected a number from pitch.min to pitch.max, 0.6 to 0.9, found 0.93",
        ),
        (B_SERIES, PITCH.replace("rate: 0.5", "rate: 0.0"), "pitch.rate: Input should be greater than 0, found 0.0"),
        ("{model: tabulated, diameter: 0.09, pitch_ratio: 0.9}", "", "propeller.table: Field required"),
        (
            "{model: tabulated, diameter: 0.09, pitch_ratio: 0.9, file: nowhere.yaml}",
            "",
            "propeller.file: expected a file beside this one or one of b4_70_continued.yaml, found 'nowhere.yaml'",
        ),
        (
            "{model: tabulated, diameter: 0.09, pitch_ratio: 0.9, file: 3}",
            "",
            "propeller.file: expected a file name, found 3",
        ),
        (
            "{model: tabulated, diameter: 0.09, pitch_ratio: 0.9, file: x.yaml, table: {}}",
            "",
            "propeller.table: expected none beside 'file', found one",
        ),
        (
            "{model: four_quadrant, diameter: 0.09, pitch_ratio: 1.5, file: b4_70_continued.yaml}",
            "",
            "propeller.pitch_ratio: expected a number from 0.5 to 1.4, those of the data, found 1.5",
        ),
    ],
)
def test_contradictions_are_named(tmp_path: Path, propeller: str, more: str, message: str) -> None:
    path = ship(tmp_path, propeller, more)
    found = problem(path)
    assert re.fullmatch(re.escape(f"{path}:") + r"\d+: " + re.escape(HERE + message), found), found


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        (
            "0.0, 0.3, 0.6",
            "0.0, 0.6, 0.3",
            "2: {}.advance_number.2: " + RISES.format("0.6", "0.3"),
        ),
        ("0.35, 0.2", "0.35, 0.4", "5: {}.thrust_coefficient.1.2: expected less than 0.35 before it, found 0.4"),
        ("0.032", "0.0", "7: {}.torque_coefficient.0.1: expected a number above 0, found 0"),
        ("0.055, 0.045, 0.030", "0.055, 0.045", "8: {}.torque_coefficient.1: expected 3 numbers, found 2"),
        ("[0.8, 1.0]", "[1.0, 0.8]", "1: {}.pitch_ratio.1: " + RISES.format("1", "0.8")),
        ("0.24", "much", "4: {}.thrust_coefficient.0.1: Input should be a valid number, found 'much'"),
    ],
)
def test_a_wrong_data_file_is_named_with_its_line(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    data = tmp_path / "mine.yaml"
    data.write_text(TABLE.replace(right, wrong), encoding="utf-8")
    found = problem(ship(tmp_path, "{model: tabulated, diameter: 0.09, pitch_ratio: 0.9, file: mine.yaml}"))
    assert found == f"{data}:{message.format('thrusters.2.propeller.table')}"


def test_a_motor_too_weak_for_the_thrust_is_named(tmp_path: Path) -> None:
    """K_Q/K_T D T = 0.0442/0.42 * 0.09 * 13.5 = 0.12786 N m."""
    path = ship(tmp_path, BOLLARD)
    path.write_text(path.read_text().replace("torque_max: 0.3", "torque_max: 0.127"))
    assert problem(path).endswith(
        "thrusters.2.shaft.torque_max: expected at least 0.128 N m, the torque at the largest thrust of 13.5 N and no "
        "advance speed, found 0.127"
    )


def test_a_trim_in_degrees_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "ship.yaml"
    path.write_text(yaml.safe_dump({"extends": "cybership3", "hull": {"trim": 3.4}}))
    assert problem(path).endswith("hull.trim: Input should be less than or equal to 0.3, found 3.4")
