"""Bollard, tabulated and four-quadrant propellers: what they know and what they refuse."""

from __future__ import annotations

import math

import numpy as np
import pytest

from marine_model.errors import InputError
from marine_model.propellers import BollardPropeller, FourQuadrantPropeller, TabulatedPropeller, WageningenBPropeller
from support.propellers import ADVANCE, ALL, B4_70, PITCHES, SERIES, THRUST, TORQUE


def test_linear_coefficients_by_hand() -> None:
    """(3.6)-(3.7): K_T = 0.42 - 0.353 J, zero at 1.1898; K_Q = 0.0442 - 0.0325 J."""
    model = ALL["linear"]
    thrust, torque = model.coefficients(0.5)
    assert float(thrust) == pytest.approx(0.42 - 0.1765)
    assert float(torque) == pytest.approx(0.0442 - 0.01625)
    assert model.advance_number_range[0] == 0.0
    assert model.advance_number_range[1] == pytest.approx(1.18980, abs=1e-5)
    assert model.pitch_range is None


def test_a_bollard_propeller_knows_bollard_pull_alone() -> None:
    model = ALL["bollard"]
    assert model.advance_number_range == (0.0, 0.0)
    assert [float(k) for k in model.coefficients(0.0)] == [0.42, 0.0442]
    with pytest.raises(InputError, match=r"advance_number: expected 0 \(no other is known\), found 0.1"):
        model.coefficients(0.1)
    with pytest.raises(InputError, match=r"pitch_ratio: expected 0.93 \(no other is known\), found 1"):
        model.coefficients(0.0, 1.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-0.1, 1.0, 0.4, 0.05), "diameter: expected a number above 0, found -0.1"),
        ((0.1, 0.0, 0.4, 0.05), "pitch_ratio: expected a number above 0, found 0.0"),
        ((0.1, 1.0, 0.0, 0.05), "thrust_coefficient: expected a number above 0, found 0.0"),
        ((0.1, 1.0, 0.4, -0.05), "torque_coefficient: expected a number above 0, found -0.05"),
        ((0.1, 1.0, 0.4, 0.05, 0.1), "thrust_slope: expected a number not above 0, found 0.1"),
        ((0.1, 1.0, 0.4, 0.05, -0.1, 0.01), "torque_slope: expected a number not above 0, found 0.01"),
    ],
)
def test_no_such_bollard_propeller(arguments: tuple[float, ...], message: str) -> None:
    with pytest.raises(InputError, match=message):
        BollardPropeller(*arguments)


def test_a_table_gives_its_entries_and_stays_between_neighbours() -> None:
    model = ALL["tabulated"]
    for table, found in zip((THRUST, TORQUE), model.coefficients(ADVANCE, np.array(PITCHES)[:, None]), strict=True):
        np.testing.assert_allclose(found, table, rtol=1e-13)
    one = ALL["tabulated, one pitch"]
    fine = np.linspace(0.0, ADVANCE[-1], 300)
    assert (np.diff(one.coefficients(fine)[0]) < 0.0).all()  # PCHIP: falls wherever the table falls


def test_a_table_of_the_b_series_comes_close_to_it_between_entries() -> None:
    """Spacing 0.15 in J and 0.1 to 0.2 in P/D: within 1 % of K at J = 0."""
    J, P = np.linspace(0.0, 0.7, 40)[:, None], np.linspace(0.8, 1.2, 40)
    for found, known in zip(ALL["tabulated"].coefficients(J, P), B4_70.coefficients(J, P), strict=True):
        np.testing.assert_allclose(found, known, atol=0.01 * known.max())


GOOD = {
    "advance_number": [0.0, 0.3, 0.6],
    "thrust_coefficient": [[0.4, 0.25, 0.1], [0.5, 0.35, 0.2]],
    "torque_coefficient": [[0.05, 0.04, 0.02], [0.06, 0.05, 0.03]],
    "table_pitch_ratio": [0.8, 1.0],
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"advance_number": [0.0]}, r"^advance_number: expected at least 2 numbers, found 1"),
        ({"advance_number": [0.1, 0.3, 0.6]}, r"^advance_number\[0\]: expected 0, bollard pull, found 0.1"),
        (
            {"advance_number": [0.0, 0.3, 0.3]},
            r"^advance_number\[2\]: expected a finite number above 0.3 before it, found 0.3",
        ),
        (
            {"advance_number": [0.0, float("nan"), 0.3]},
            r"^advance_number\[1\]: expected a finite number above 0 before it, found nan",
        ),
        (
            {"advance_number": [0.0, 0.3, math.inf]},
            r"^advance_number\[2\]: expected a finite number above 0.3 before it, found inf",
        ),
        (
            {"table_pitch_ratio": [1.0, 0.8]},
            r"^pitch_ratio\[1\]: expected a finite number above 1 before it, found 0.8",
        ),
        ({"table_pitch_ratio": [0.0, 0.8]}, r"^pitch_ratio\[0\]: expected a number above 0, found 0"),
        ({"table_pitch_ratio": []}, r"^pitch_ratio: expected at least 1 number, found none"),
        ({"table_pitch_ratio": None}, r"^thrust_coefficient: expected a row for every pitch ratio, 1, found 2"),
        (
            {"thrust_coefficient": [[0.4, 0.25, 0.1], [0.5, 0.35]]},
            r"^thrust_coefficient\[1\]: expected 3 numbers, found 2",
        ),
        (
            {"thrust_coefficient": [[0.4, 0.25, 0.1], [0.5, 0.35, 0.35]]},
            r"^thrust_coefficient\[1\]\[2\]: expected less than 0.35 before it, found 0.35",
        ),
        (
            {"thrust_coefficient": [[0.0, -0.25, -0.3], [0.5, 0.35, 0.3]]},
            r"^thrust_coefficient\[0\]\[0\]: expected a number above 0 at J = 0, found 0",
        ),
        (
            {"torque_coefficient": [[0.05, 0.04, 0.02], [0.06, 0.0, 0.03]]},
            r"^torque_coefficient\[1\]\[1\]: expected a number above 0, found 0",
        ),
        (
            {"torque_coefficient": [[0.05, 0.04, 0.02], [0.06, float("inf"), 0.03]]},
            r"^torque_coefficient\[1\]\[1\]: expected a finite number, found inf",
        ),
        ({"pitch_ratio": 1.1}, r"^pitch_ratio: expected a number from 0.8 to 1, found 1.1"),
        ({"diameter": 0.0}, r"^diameter: expected a number above 0, found 0.0"),
    ],
)
def test_no_such_table(changes: dict[str, object], message: str) -> None:
    TabulatedPropeller(**({"diameter": 0.2, "pitch_ratio": 0.9} | GOOD))
    with pytest.raises(InputError, match=message):
        TabulatedPropeller(**({"diameter": 0.2, "pitch_ratio": 0.9} | GOOD | changes))


def test_a_table_of_one_pitch_knows_that_pitch() -> None:
    message = "pitch_ratio: expected 0.8, the one that there is data for, found 0.9"
    with pytest.raises(InputError, match=message):
        TabulatedPropeller(0.2, 0.9, [0.0, 0.5], [[0.4, 0.1]], [[0.05, 0.02]], [0.8])


def test_four_quadrant_series_by_hand() -> None:
    """At beta = 90 deg the cosines are 0 and -1, the sines 1 and 0: C_T = 0.01 - 0.02 - 0.5."""
    model = ALL["four_quadrant"]
    assert isinstance(model, FourQuadrantPropeller)
    thrust, torque = model.four_quadrant_coefficients(math.pi / 2.0)
    assert float(thrust) == pytest.approx(-0.51)
    assert float(torque) == pytest.approx(0.002 - 0.001 - 0.07)
    # n = 0, V_A = 2 m/s: T = C_T rho/2 A_0 V_A^2.
    force = float(model.forces(0.0, 2.0, 1000.0)[0])
    assert force == pytest.approx(-0.51 * 500.0 * math.pi / 4.0 * 0.0625 * 4.0)


def test_four_quadrant_coefficients_at_bollard_pull_by_hand() -> None:
    """K_T = C_T pi/8 (0.7 pi)^2 at J = 0, (2.17), with C_T = 0.01 + 0.6 + 0.02."""
    thrust, torque = ALL["four_quadrant"].coefficients(0.0)
    assert float(thrust) == pytest.approx(0.63 * math.pi / 8.0 * (0.7 * math.pi) ** 2)
    assert float(torque) == pytest.approx(0.073 * math.pi / 8.0 * (0.7 * math.pi) ** 2)
    assert ALL["four_quadrant"].advance_number_range == (-math.inf, math.inf)


@pytest.mark.parametrize(
    ("at", "value", "message"),
    [
        (0, [0.8, 0.8, 1.3], r"^pitch_ratio\[1\]: expected a finite number above 0.8 before it, found 0.8"),
        (0, [0.8, 1.0], r"^thrust_cosine: expected a row for every pitch ratio, 2, found 3"),
        (2, [[0.0, 0.1], [0.0, 0.1, 0.1], [0.0, 0.1, 0.1]], r"^thrust_sine\[0\]: expected 3 numbers, found 2"),
        (4, [[0.0, math.nan, 0.1]] * 3, r"^torque_sine\[0\]\[1\]: expected a finite number, found nan"),
        (
            3,
            [[0.002, 0.07, 0.001], [0.002, -0.07, 0.001], [0.002, 0.07, 0.001]],
            r"^torque_cosine\[1\]: expected C_Q above 0 at 0 deg and below 0 at 180 deg .*, found -0.067 and 0.073",
        ),
        (1, [[0.5, 0.2, 0.0]] * 3, r"^thrust_cosine\[0\]: expected C_T above 0 at 0 deg and below 0 at 180 deg"),
    ],
)
def test_no_such_series(at: int, value: object, message: str) -> None:
    series = list(SERIES)
    series[at] = value
    with pytest.raises(InputError, match=message):
        FourQuadrantPropeller(0.25, 1.0, *series)


def test_the_rows_of_b_series_propellers_differ_by_blades_and_area() -> None:
    rows = [WageningenBPropeller(0.25, z, a, 1.0).row() for z, a in ((4, 0.7), (5, 0.7), (4, 0.55))]
    assert not np.array_equal(rows[0], rows[1])
    assert not np.array_equal(rows[0], rows[2])
