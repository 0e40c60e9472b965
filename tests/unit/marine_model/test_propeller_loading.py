"""tau, B_p, the best diameter and pitch, and where thrust ends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model.errors import InputError, UnknownNameError
from marine_model.propeller_file import load_propeller
from marine_model.propellers import BollardPropeller, FourQuadrantPropeller, TabulatedPropeller, WageningenBPropeller
from marine_model.propellers.loading import (
    best_point,
    desired_loading,
    diameter_for,
    largest_loading,
    loading,
    loading_from_coefficients,
    power_coefficient,
    power_loading,
    propeller_demand,
    select,
)
from marine_model.propellers.optimal import advance_number, optimal_pitch
from marine_model.propellers.zero_thrust import last_advance_number
from marine_model.root import rising_root

SEA = 1025.0
B4_70 = WageningenBPropeller(4.0, 4, 0.70, 0.58)


def test_the_example_of_the_thesis() -> None:
    """[Ruth] 2.2.1: V_S = 5 m/s, R = 53 kN, w = 0.2, t = 0.1."""
    V, T = propeller_demand(5.0, 53e3, 0.20, 0.10)
    assert (float(V), float(T)) == pytest.approx((4.0, 58.9e3), rel=1e-3)  # 59 kN to the digits printed
    # (2.29) with tau = 3.05 of the polynomials of 1969, and (2.30).
    assert float(diameter_for(3.05, 4.0, 59e3, SEA)) == pytest.approx(5.8, abs=0.05)
    assert float(loading(4.0, 4.0, 59e3, SEA)) == pytest.approx(2.1, abs=0.05)
    # With the polynomials of 1975: P/D 1.4 as well, tau 3.5, and so D = 6.6 m. Emergent; the digits are ours.
    best = best_point(B4_70)
    assert best.pitch_ratio == 1.4
    assert best.loading == pytest.approx(3.48, abs=0.005)
    free = select(B4_70, V, T, SEA)
    assert float(free.diameter) == pytest.approx(6.60, abs=0.01)
    narrow = select(B4_70, V, T, SEA, largest_diameter=4.0)
    assert float(narrow.loading) == pytest.approx(2.1, abs=0.05)
    assert float(narrow.pitch_ratio) == 1.4  # 1.36 in the thesis
    assert float(narrow.efficiency) < float(free.efficiency)


def test_a_selection_gives_its_thrust() -> None:
    V, T = np.array([2.0, 4.0, 6.0])[:, np.newaxis], np.array([4e4, 6e4])
    found = select(B4_70, V, T, SEA, largest_diameter=np.array([4.0, 5.0]))
    assert found.diameter.shape == (3, 2)
    for i in range(3):
        for j in range(2):
            D, n = float(found.diameter[i, j]), float(found.shaft_speed[i, j])
            K_T, K_Q = B4_70.coefficients(float(V[i, 0]) / (n * D), float(found.pitch_ratio[i, j]))
            # To the accuracy of the halved bracket of J.
            assert SEA * n**2 * D**4 * K_T == pytest.approx(T[j], rel=1e-9)
            assert 2.0 * math.pi * n * SEA * n**2 * D**5 * K_Q == pytest.approx(found.power[i, j], rel=1e-9)
    assert np.all(found.diameter <= np.array([4.0, 5.0]))


def test_no_diameter_or_pitch_beside_the_best_is_better() -> None:
    best = best_point(B4_70)
    for pitch in np.linspace(0.5, 1.4, 31):
        J = np.linspace(0.0, float(last_advance_number(B4_70, pitch)), 301)
        K_T, K_Q = B4_70.coefficients(J, pitch)
        assert np.max(J * K_T / (2.0 * math.pi * K_Q)) <= best.efficiency + 1e-12


@given(J=st.floats(1e-3, 0.5), pitch=st.floats(0.5, 1.4))
def test_tau_fixes_the_advance_number(J: float, pitch: float) -> None:
    K_T, _ = B4_70.coefficients(J, pitch)
    tau = loading_from_coefficients(J, K_T)
    # A root with an absolute accuracy of 1e-15, times the slope of tau, which grows as thrust ends.
    assert float(advance_number(B4_70, tau, pitch)) == pytest.approx(J, rel=1e-9)


@given(D=st.floats(0.1, 10.0), V=st.floats(0.1, 15.0), T=st.floats(1.0, 1e6), sensitivity=st.floats(0.01, 2.0))
def test_tau_d_is_that_of_the_desired_thrust(D: float, V: float, T: float, sensitivity: float) -> None:
    """By the first line of (2.31); the last line as printed, tau / sqrt(st), is the inverse way round."""
    desired = T / sensitivity
    assert float(desired_loading(loading(D, V, T, SEA), sensitivity)) == pytest.approx(
        float(loading(D, V, desired, SEA)), rel=1e-12
    )


def test_power_loading_in_the_units_of_its_diagrams() -> None:
    J, D, n, K_Q, fresh = 0.6, 3.0, 2.0, 0.03, 1000.0
    V = J * n * D
    horsepower = 2.0 * math.pi * n * K_Q * fresh * n**2 * D**5 / (76.0 * 9.80665)
    knots = V / (1852.0 / 3600.0)
    # 33.07 has four digits.
    assert float(power_loading(J, K_Q)) == pytest.approx(60.0 * n * math.sqrt(horsepower) / knots**2.5, rel=2e-4)
    assert float(power_loading(0.0, K_Q)) == math.inf


def test_power_coefficient_is_that_of_bollard_power() -> None:
    K_T, K_Q = B4_70.coefficients(0.0, 0.58)
    n, D = 2.0, 4.0
    T, Q = K_T * SEA * n**2 * D**4, K_Q * SEA * n**2 * D**5
    expected = 2.0 * math.pi * n * Q * math.sqrt(SEA) * D / T**1.5
    assert float(power_coefficient(K_T, K_Q)) == pytest.approx(float(expected), rel=1e-12)


def test_where_thrust_ends() -> None:
    pitch = np.array([0.5, 0.9, 1.4])
    end = last_advance_number(B4_70, pitch)
    assert np.abs(B4_70.coefficients(end, pitch)[0]).max() < 1e-12
    assert np.all(np.isinf(largest_loading(B4_70, pitch)))
    # Linear: K_T = 0.4 - 0.5 J.
    assert float(last_advance_number(BollardPropeller(1.0, 1.0, 0.4, 0.05, -0.5, -0.02))) == pytest.approx(0.8)
    assert float(last_advance_number(BollardPropeller(1.0, 1.0, 0.4, 0.05))) == 0.0
    # A table that ends before the thrust does.
    table = TabulatedPropeller(1.0, 1.0, (0.0, 0.25, 0.5), ((0.4, 0.3, 0.2),), ((0.05, 0.045, 0.04),), None)
    assert float(last_advance_number(table)) == 0.5
    assert float(largest_loading(table)) == pytest.approx(0.5 / math.sqrt(0.2))


def test_where_thrust_ends_without_an_end_of_the_data() -> None:
    """C_T = cos(beta) - sin(beta) is zero at 45 deg, where J = 0.7 pi."""
    model = FourQuadrantPropeller(1.0, 1.0, (1.0,), ((0.0, 1.0),), ((0.0, -1.0),), ((0.0, 0.2),), ((0.0, -0.1),))
    assert float(last_advance_number(model)) == pytest.approx(0.7 * math.pi, rel=1e-12)
    assert float(advance_number(model, 0.0, 1.0)) == 0.0
    J = float(advance_number(model, 1.0, 1.0))
    assert J / math.sqrt(float(model.coefficients(J, 1.0)[0])) == pytest.approx(1.0, rel=1e-12)


def test_no_best_point_where_efficiency_rises_to_the_end() -> None:
    table = TabulatedPropeller(1.0, 1.0, (0.0, 0.25, 0.5), ((0.4, 0.39, 0.38),), ((0.05, 0.05, 0.05),), None)
    with pytest.raises(InputError, match=r"efficiency that falls before the model ends, found it rising at J = 0\.5"):
        best_point(table)


def test_best_point_within_a_range_of_pitch() -> None:
    best = best_point(B4_70, (0.6, 1.0))
    assert best.pitch_ratio == 1.0
    assert best.efficiency < best_point(B4_70).efficiency
    assert float(optimal_pitch(B4_70, best.loading, (0.6, 1.0))) == 1.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: loading(0.0, 1.0, 1.0, SEA), "diameter: expected numbers above 0, found 0.0"),
        (lambda: loading(1.0, -1.0, 1.0, SEA), "advance_speed: expected numbers of at least 0, found -1.0"),
        (lambda: loading(1.0, 1.0, [1.0, -2.0], SEA), "thrust: expected numbers above 0, found -2.0"),
        (lambda: loading(1.0, 1.0, math.nan, SEA), "thrust: expected finite numbers, found nan"),
        (lambda: loading(1.0, "fast", 1.0, SEA), "advance_speed: expected numbers, found 'fast'"),
        (lambda: diameter_for(1.0, 0.0, 1.0, SEA), "advance_speed: expected numbers above 0, found 0.0"),
        (lambda: propeller_demand(5.0, 1e3, 1.0, 0.1), "wake_fraction: expected a fraction below 1, found 1.0"),
        (lambda: power_coefficient(0.0, 0.1), "thrust_coefficient: expected numbers above 0, found 0.0"),
        (lambda: power_loading(0.5, 0.0), "torque_coefficient: expected numbers above 0, found 0.0"),
        (lambda: select(B4_70, 4.0, 1e4, SEA, -1.0), "largest_diameter: expected numbers above 0, found -1.0"),
    ],
)
def test_refusals(call, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()


def test_rising_root_holds_to_its_bracket() -> None:
    root = rising_root(lambda x: x**2 - np.array([2.0, 9.0, -1.0]), [0.0, 0.0, 0.0], [2.0, 2.0, 2.0])
    assert root.tolist() == pytest.approx([math.sqrt(2.0), 2.0, 0.0], rel=1e-15)


def test_the_propeller_of_chapter_3() -> None:
    one = load_propeller("wageningen_b4_70")
    assert one.pitch is not None
    assert (one.density, one.propeller.diameter, one.pitch.min, one.pitch.max) == (SEA, 4.0, 0.5, 1.4)
    with pytest.raises(UnknownNameError, match="propeller: expected a path or one of wageningen_b4_70, found 'x'"):
        load_propeller("x")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("pitch: {min: 0.4, max: 1.4}", r"pitch: expected min and max from 0.5 to 1.4, those of the propeller's data"),
        ("pitch: {min: 1.4, max: 0.5}", r"pitch.min must be below pitch.max"),
        ("pitch: {min: 0.7, max: 1.4}", r"propeller.pitch_ratio: expected a number from pitch.min to pitch.max"),
    ],
)
def test_propeller_files_are_refused_by_field(tmp_path, line: str, message: str) -> None:
    path = tmp_path / "one.yaml"
    head = "name: one\ndescription: one\ndensity: 1000.0\n"
    data = "propeller: {model: wageningen_b, diameter: 1.0, blades: 4, area_ratio: 0.7, pitch_ratio: 0.6}\n"
    path.write_text(head + data + line + "\n", encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        load_propeller(path)
