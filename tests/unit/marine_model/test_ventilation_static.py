"""Static map of ventilation: hand-worked points, limits, monotony, Figure 2.17."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.ventilation import VentilationData
from marine_model.ventilation.static import (
    VentilationModel,
    loss_factors,
    modified_froude_number,
    thrust_loss,
    wetted_area,
)


def table_2_5() -> VentilationData:
    data = load_vessel("cybership3").ventilation
    assert data is not None
    return data


DATA = table_2_5()
MODEL = VentilationModel(DATA)
ROW = DATA.row()
D = 0.25  # m, propeller P 1020

speeds = st.floats(-50.0, 50.0)
ratios = st.floats(-3.0, 10.0)
pitches = st.floats(-1.4, 1.4)
diameters = st.floats(0.03, 5.0)


def froude_speed(froude: float, x: float) -> float:
    """Shaft speed of P 1020 at P/D = 1 with this F_nh2."""
    return froude * math.sqrt((1.0 + x) * 9.81 / D)


@pytest.mark.parametrize(
    ("x", "area"),
    [
        (-5.0, 0.0),
        (-1.0, 0.0),
        (0.0, 0.5),
        # 1 - (pi/3)/pi + 0.5 sqrt(0.75)/pi
        (0.5, 2.0 / 3.0 + math.sqrt(3.0) / (4.0 * math.pi)),
        (-0.5, 1.0 / 3.0 - math.sqrt(3.0) / (4.0 * math.pi)),
        (1.0, 1.0),
        (7.0, 1.0),
    ],
)
def test_wetted_area(x: float, area: float) -> None:
    assert wetted_area(x) == pytest.approx(area, abs=1e-15)


def test_modified_froude_number() -> None:
    # 10 sqrt(0.25) 0.8 / sqrt(2 * 9.81) = 0.90305
    assert modified_froude_number(10.0, 0.25, 0.8, 1.0) == pytest.approx(0.90305, abs=1e-5)
    assert modified_froude_number(-10.0, 0.25, 0.8, 1.0) == modified_froude_number(10.0, 0.25, -0.8, 1.0)
    assert modified_froude_number(0.0, 0.25, 0.8, -1.0) == math.inf


@pytest.mark.parametrize(
    ("x", "froude", "beta"),
    [
        # x = 1: plus 0.8 - 0.6 (1.1 - 0.7615) / 0.6778 = 0.50035; minus 0.8 - 0.6 (1.1 - 0.7907) / 0.5939 = 0.48752.
        (1.0, 1.1, 0.50035),
        # x = 0: minus 0.8 - 0.6 (1.5 - 0.8739) / 1.3268 = 0.51687; plus below its minimum.
        (0.0, 1.5, 0.51687),
        # x = 2: plus 0.8 - 0.6 (2.5 - 1.9364) / 0.8202 = 0.38771; the minus band has ended.
        (2.0, 2.5, 0.38771),
        (2.0, 0.5, 1.0),
        (2.0, 10.0, 0.05),
        (-0.9, 0.0, 1.0),
    ],
)
def test_loss_of_wetted_thrust_by_hand(x: float, froude: float, beta: float) -> None:
    assert thrust_loss(ROW, froude, x) == pytest.approx(beta, abs=1e-5)
    area, thrust, torque = loss_factors(ROW, froude_speed(froude, x), D, 1.0, x)
    assert (thrust, torque) == pytest.approx((beta, 0.87 * beta + 0.13), abs=1e-5)
    factors = MODEL.loss_factors([froude_speed(froude, x)], D, 1.0, x)
    assert factors.thrust == pytest.approx([area * thrust], abs=1e-15)
    assert factors.torque == pytest.approx([area * torque], abs=1e-15)


@given(x=st.floats(-0.95, 1.02))
def test_the_printed_lines_pass_through_their_loss_factors(x: float) -> None:
    # Where the minus band is above: up to h/R = 0.974 for 0.2 and 1.023 for 0.8.
    for a, b, beta, end in ((-0.0832, 0.8739, 0.8, 1.0232), (-0.8161, 2.2007, 0.2, 0.9743)):
        if x < end:
            assert thrust_loss(ROW, a * x + b, x) == pytest.approx(beta, abs=1e-12)


@given(x=st.floats(1.03, 10.0))
def test_the_deep_lines_pass_through_their_loss_factors(x: float) -> None:
    assert thrust_loss(ROW, 1.1749 * x - 0.4134, x) == pytest.approx(0.8, abs=1e-12)
    assert thrust_loss(ROW, 1.3173 * x + 0.1220, x) == pytest.approx(0.2, abs=1e-12)


@given(n=speeds, d=diameters, pitch=pitches, x=ratios)
def test_factors_are_within_0_and_1(n: float, d: float, pitch: float, x: float) -> None:
    area, thrust, torque = loss_factors(ROW, n, d, pitch, x)
    assert 0.0 <= area <= 1.0
    assert 0.05 <= thrust <= 1.0
    assert 0.13 <= torque <= 1.0 + 1e-15  # 0.87 + 0.13
    assert (area, thrust, torque) == loss_factors(ROW, -n, d, pitch, x) == loss_factors(ROW, n, d, -pitch, x)


@given(n=st.floats(0.0, 50.0), more=st.floats(0.0, 10.0), d=diameters, pitch=pitches, x=ratios)
def test_factors_fall_with_shaft_speed(n: float, more: float, d: float, pitch: float, x: float) -> None:
    slow, fast = loss_factors(ROW, n, d, pitch, x), loss_factors(ROW, n + more, d, pitch, x)
    assert fast[0] == slow[0]
    assert fast[1] <= slow[1]
    assert fast[2] <= slow[2]


@given(n=speeds, d=diameters, pitch=pitches, x=ratios, deeper=st.floats(0.0, 5.0))
def test_factors_rise_with_submergence_outside_of_the_minus_band(
    n: float, d: float, pitch: float, x: float, deeper: float
) -> None:
    # Between h/R = 0.179 and 1.007 the minus band, whose 0.2 line falls with depth, may let beta fall: next test.
    upper, lower = loss_factors(ROW, n, d, pitch, x), loss_factors(ROW, n, d, pitch, x + deeper)
    assert lower[0] >= upper[0] - 1e-15
    if x >= 1.01 or x + deeper <= 0.17:
        # Rounding of F_nh2 and of beta.
        assert lower[1] >= upper[1] - 1e-12


def test_where_the_map_of_the_thesis_falls_with_submergence() -> None:
    # F_nh2 at one shaft speed goes with (1 + h/R)^-1/2; what matters is f = F_nD P/D. Figures of docs/ventilation.md.
    f = np.linspace(0.0, 4.0, 401)
    x = np.linspace(-1.0, 4.0, 5001)
    factors = MODEL.loss_factors(f[:, None] / math.sqrt(D / 9.81), D, 1.0, x)
    for beta, first, drop in (
        (factors.thrust_wetted, 0.18, 0.166),
        (factors.thrust, 0.255, 0.109),
        (factors.torque, 0.427, 0.074),
    ):
        row, column = np.nonzero(np.diff(beta, axis=1) < -1e-9)
        # A step of x is 0.001, one of f 0.01.
        assert x[column].min() == pytest.approx(first, abs=0.003)
        assert x[column].max() == pytest.approx(1.007, abs=0.003)
        assert f[row].min() == pytest.approx(1.29, abs=0.02)
        assert f[row].max() <= 2.56
        assert (np.maximum.accumulate(beta, axis=1) - beta).max() == pytest.approx(drop, abs=0.001)


@given(froude=st.floats(0.0, 5.0))
def test_nothing_jumps_where_the_lines_of_the_minus_band_meet(froude: float) -> None:
    below, above = (thrust_loss(ROW, froude, DATA.minus_end + e) for e in (-1e-9, 1e-9))
    # d beta / d x of the plus band is below 0.6 * 1.32 / 0.79 + ...: 2 is ample.
    assert below == pytest.approx(above, abs=4e-9)


def test_out_of_the_water_and_at_rest() -> None:
    assert loss_factors(ROW, 20.0, D, 1.0, -1.0) == pytest.approx((0.0, 0.05, 0.1735))
    assert loss_factors(ROW, 20.0, D, 1.0, -30.0) == pytest.approx((0.0, 0.05, 0.1735))
    assert loss_factors(ROW, 0.0, D, 1.0, -0.999)[1:] == pytest.approx((1.0, 1.0))
    # Towards the edge the wetted area goes to 0 and with it every difference.
    assert loss_factors(ROW, 1e-3, D, 1.0, -1.0 + 1e-12)[0] < 1e-12


def test_vectorised_equals_scalar_and_broadcasts() -> None:
    rng = np.random.default_rng(4)
    n, x = rng.uniform(-30.0, 30.0, (7, 1)), rng.uniform(-1.5, 3.0, (1, 9))
    pitch = rng.uniform(0.4, 1.3, 9)
    factors = MODEL.loss_factors(n, D, pitch, x)
    assert factors.thrust.shape == (7, 9)
    for i in range(7):
        for j in range(9):
            assert (factors.area[i, j], factors.thrust_wetted[i, j], factors.torque_wetted[i, j]) == loss_factors(
                ROW, n[i, 0], D, pitch[j], x[0, j]
            )
    assert MODEL.loss_factors(10.0, D, 1.0, 1.0).thrust.shape == ()


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ((math.nan, D, 1.0, 1.0), "shaft_speed: expected finite numbers, found nan"),
        ((10.0, 0.0, 1.0, 1.0), "diameter: expected numbers above 0, found 0.0"),
        ((10.0, [0.25, -0.1], 1.0, 1.0), r"diameter: expected numbers above 0, found \[0.25, -0.1\]"),
        ((10.0, D, 1.0, -math.inf), "submergence_ratio: expected finite"),
        (([1.0, 2.0], D, 1.0, [1.0, 2.0, 3.0]), r"fit together, found shaft_speed \(2,\).*submergence_ratio \(3,\)"),
    ],
)
def test_bad_input_is_refused(arguments: tuple, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        MODEL.loss_factors(*arguments)


def test_figure_2_17_lower_pitch_ventilates_less() -> None:
    # The thrusts of 13.4 Hz at P/D 0.8 and 10.0 Hz at P/D 1.2 differ by 2.3 % in (2.63).
    assert pytest.approx(1.0, abs=0.025) == (13.4 / 10.0) ** 2 * (0.8 / 1.2) ** 1.5
    x = np.linspace(-0.9, 3.0, 391)
    low, high = MODEL.loss_factors(13.4, D, 0.8, x), MODEL.loss_factors(10.0, D, 1.2, x)
    for a, b in ((low.thrust, high.thrust), (low.torque, high.torque)):
        assert (a >= b).all()
        assert (a - b).max() > 0.1
    # Ventilation begins less deep: beta_Tw below 1 up to a smaller h/R.
    assert x[low.thrust_wetted < 1.0].max() < x[high.thrust_wetted < 1.0].max() - 0.05


@given(n=st.floats(1.0, 20.0), pitch=st.floats(0.4, 1.3), a=st.floats(0.5, 2.0), x=st.floats(-0.9, 5.0))
def test_froude_number_at_equal_thrust_goes_with_the_fourth_root_of_pitch(
    n: float, pitch: float, a: float, x: float
) -> None:
    # (2.66), (2.68).
    first = modified_froude_number(n, D, pitch, x)
    second = modified_froude_number(n / a**0.75, D, a * pitch, x)
    assert second == pytest.approx(a**0.25 * first, rel=1e-12)
