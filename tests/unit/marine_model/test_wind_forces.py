"""Wind forces: values by hand, symmetry, tables, refusals; compiled and plain Python alike."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from marine_model import load_vessel
from marine_model.errors import DocumentError
from marine_model.wind import WindForces, wind_force
from vessel_sim.wind.load import compiled_wind_force

Force = tuple[float, float, float]
BLENDERMANN = {"model": "blendermann", "transverse": 0.9, "longitudinal_bow": 0.55, "longitudinal_stern": 0.8}
SHIP = {
    "length": 60.0,
    "frontal_area": 180.0,
    "lateral_area": 450.0,
    "centroid_ahead": 3.0,
    "centroid_height": 5.0,
    "density": 1.25,
}
ROWS = [[0.0, -0.6, 0.0, 0.0], [math.pi / 4, -0.5, 0.6, 0.1], [math.pi / 2, 0.1, 0.9, 0.05], [math.pi, 0.7, 0.0, 0.0]]


def forces(**changes: Any) -> WindForces:
    fields = {**SHIP, "coefficients": {**BLENDERMANN, "cross_force": 0.55}, **changes}
    return WindForces.model_validate(fields)


def load(data: WindForces, u: float, v: float) -> Force:
    return wind_force(data.constants(), data.table(), u, v)


def test_head_following_and_beam_wind_by_hand() -> None:
    # q = 1.25 * 10^2 / 2 = 62.5 Pa; frontal 62.5 * 180 = 11250 N, lateral 62.5 * 450 = 28125 N.
    data = forces()
    assert load(data, 10.0, 0.0) == pytest.approx((-11250 * 0.55, 0.0, 0.0))
    assert load(data, -10.0, 0.0) == pytest.approx((11250 * 0.8, 0.0, 0.0))
    # Wind from port, towards starboard, on a lever of 3 m.
    assert load(data, 0.0, -10.0) == pytest.approx((0.0, 28125 * 0.9, 28125 * 0.9 * 3.0))


def test_wind_on_the_port_bow_by_hand() -> None:
    # gamma = 45 deg: sin^2(2 gamma) = 1; CD_l = 0.55 * 180 / 450 = 0.22;
    # d = 1 - 0.55 / 2 * (1 - 0.22 / 0.9) = 0.792222. The lever: 3 + 0.18 * pi/4 * 60 = 11.48230 m.
    x, y, n = load(forces(), math.sqrt(50.0), -math.sqrt(50.0))
    d = 0.7922222222
    assert x == pytest.approx(-11250 * 0.55 * math.sqrt(0.5) / d)
    assert y == pytest.approx(28125 * 0.9 * math.sqrt(0.5) / d)
    assert n == pytest.approx(y * 11.4823002)
    assert n > 0.0  # the bow is pushed away


def test_table_between_its_rows_by_hand() -> None:
    data = forces(coefficients={"model": "table", "rows": ROWS})
    # gamma = 22.5 deg, half way between the first two rows.
    u, v = 10.0 * math.cos(math.pi / 8), -10.0 * math.sin(math.pi / 8)
    assert load(data, u, v) == pytest.approx((-0.55 * 11250, 0.3 * 28125, 0.05 * 28125 * 60.0))
    for angle, c_x, c_y, c_n in ROWS:
        found = load(data, 10.0 * math.cos(angle), -10.0 * math.sin(angle))
        # sin(pi) in floating point times a slope of the table.
        assert found == pytest.approx((c_x * 11250, c_y * 28125, c_n * 28125 * 60.0), abs=1e-8)


COMPONENT = st.floats(-40.0, 40.0)
KINDS = pytest.mark.parametrize(
    "data", [forces(), forces(coefficients={"model": "table", "rows": ROWS})], ids=["blendermann", "table"]
)


@KINDS
@given(u=COMPONENT, v=COMPONENT)
def test_port_mirrors_starboard_and_force_grows_with_the_square(data: WindForces, u: float, v: float) -> None:
    x, y, n = load(data, u, v)
    # Rounding of a moment of up to 1e7 N m.
    assert load(data, u, -v) == pytest.approx((x, -y, -n), rel=1e-12, abs=1e-8)
    assert load(data, 2.0 * u, 2.0 * v) == pytest.approx((4.0 * x, 4.0 * y, 4.0 * n), rel=1e-12, abs=1e-8)


@given(u=COMPONENT, v=COMPONENT)
def test_the_wind_takes_power_out_of_motion_through_the_air(u: float, v: float) -> None:
    x, y, _ = load(forces(), u, v)
    assert x * u + y * v <= 0.0


@KINDS
@given(u=COMPONENT, v=COMPONENT)
def test_machine_code_does_what_python_does(data: WindForces, u: float, v: float) -> None:
    compiled = compiled_wind_force(data.constants(), data.table(), u, v)
    # The machine's sine and square root against Python's: the last digits.
    assert compiled == pytest.approx(load(data, u, v), rel=1e-13, abs=1e-9)


@KINDS
def test_no_wind_no_force(data: WindForces) -> None:
    assert load(data, 0.0, 0.0) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("angle", [0.0, math.pi / 2, math.pi])
def test_force_is_continuous_where_formulas_change(angle: float) -> None:
    data = forces()
    before, after = (load(data, 10.0 * math.cos(angle + e), -10.0 * math.sin(angle + e)) for e in (-1e-9, 1e-9))
    # 2e-9 rad times a slope of at most 1e6 N m a radian.
    assert before == pytest.approx(after, abs=1e-2)


def test_every_scale_of_one_hull_has_the_same_force_by_froude() -> None:
    data, s = load_vessel("cybership3").wind_forces, 30.0
    assert data is not None
    full = data.model_copy(
        update={
            "length": data.length * s,
            "centroid_ahead": data.centroid_ahead * s,
            "frontal_area": data.frontal_area * s**2,
            "lateral_area": data.lateral_area * s**2,
        }
    )
    x, y, n = load(data, 1.0, 0.7)
    root = math.sqrt(s)
    assert load(full, root, 0.7 * root) == pytest.approx((x * s**3, y * s**3, n * s**4), rel=1e-12)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (ROWS[:1], "two rows or more"),
        ([ROWS[0], ROWS[2], ROWS[1], ROWS[3]], "increasing angles"),
        (ROWS[:3], "expected angles from 0 to pi, found 0.0 to 1.57"),
        ([[0.0, -0.6, 0.1, 0.0], *ROWS[1:]], "expected C_Y and C_N of 0"),
    ],
)
def test_tables_that_jump_or_have_gaps_are_refused(rows: list[list[float]], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        forces(coefficients={"model": "table", "rows": rows})


def vessel_with(folder: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    content: dict[str, Any] = {"extends": "cybership3", "name": "other", "wind_forces": {}}
    change(content)
    path = folder / "other.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return path


def test_a_vessel_may_replace_the_formulas_by_a_table(tmp_path: Path) -> None:
    path = vessel_with(tmp_path, lambda c: c["wind_forces"].update(coefficients={"model": "table", "rows": ROWS}))
    data = load_vessel(path).wind_forces
    assert data is not None
    np.testing.assert_array_equal(data.table(), ROWS)


def test_a_wrong_field_is_named_with_its_line(tmp_path: Path) -> None:
    path = vessel_with(tmp_path, lambda c: c["wind_forces"].update(frontal_area=-1.0))
    with pytest.raises(DocumentError, match=r"wind_forces\.frontal_area"):
        load_vessel(path)
