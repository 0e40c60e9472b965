"""Local uni- and bidirectional thrusters, [Ruth] 7.2, and the arrow of 7.7.1."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from support.singularity_cases import fixed_configurations
from thrust_allocator.singularity import (
    LocalKind,
    classify,
    local_minimum_gain,
    minimum_gain,
    minimum_norm_thrust,
    project,
    required_change,
    required_change_scaled,
    scaled_configuration,
    scaling_of,
)

VESSEL = load_vessel("cybership3_ch7")
SCALING = scaling_of(VESSEL)


def test_the_five_thrusters_of_figure_7_1() -> None:
    """Limits -4 and 4 or 0 and 4, necessary change 1 either way."""
    thrust = [0.0, 0.0, 2.0, 0.5, 3.5]
    low = [-4.0, 0.0, 0.0, 0.0, 0.0]
    kinds = classify(thrust, low, np.full(5, 4.0), np.full(5, -1.0), np.ones(5))
    B, P, N = LocalKind.BIDIRECTIONAL, LocalKind.POSITIVE, LocalKind.NEGATIVE
    assert kinds.tolist() == [B, P, B, P, N]


def test_limits_themselves_count_as_room_7_8() -> None:
    kinds = classify([1.0, 3.0], [0.0, 0.0], [4.0, 4.0], [-1.0, -1.0], [1.0, 1.0])
    assert (kinds == LocalKind.BIDIRECTIONAL).all()


def test_room_neither_way() -> None:
    assert classify([1.0], [0.0], [2.0], [-1.5], [1.5]).tolist() == [LocalKind.NONE]


@given(fixed_configurations())
def test_local_gain_flips_and_drops_columns(case: tuple[np.ndarray, np.ndarray]) -> None:
    B, _ = case
    k = B.shape[1]
    kinds = np.resize([LocalKind.NEGATIVE, LocalKind.BIDIRECTIONAL, LocalKind.POSITIVE, LocalKind.NONE], k)
    by_hand = np.column_stack([-B[:, j] if kinds[j] == -1 else B[:, j] for j in range(k) if kinds[j] != 0])
    one_way = np.array([kinds[j] != 2 for j in range(k) if kinds[j] != 0])
    local, expected = local_minimum_gain(B, kinds), minimum_gain(by_hand, one_way)
    assert local.gain == expected.gain
    np.testing.assert_array_equal(local.direction, expected.direction)


def test_away_from_all_limits_local_is_bidirectional() -> None:
    B = scaled_configuration(VESSEL, [0.0, 0.6, -0.8, 0.8])
    kinds = classify(0.4 * VESSEL.thrust_max, np.zeros(4), VESSEL.thrust_max, np.zeros(4) - 0.1, np.full(4, 0.1))
    assert local_minimum_gain(B, kinds).gain == minimum_gain(B).gain


@given(
    st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3),
    st.lists(st.floats(-math.pi, math.pi), min_size=4, max_size=4),
)
def test_required_change_is_enough_for_any_perturbation(tau: list[float], azimuth: list[float]) -> None:
    """(7.15) and (7.16) with max(1, 1 / L_typ) bound every |Delta T_j|."""
    B = scaled_configuration(VESSEL, azimuth)
    gain = minimum_gain(B).gain
    if gain < 1e-3:  # thrusts beyond 1e3 times the perturbation: rounding
        return
    thrust = SCALING.unscaled_thrust(minimum_norm_thrust(B, SCALING.scaled(tau)))
    tight = required_change_scaled(SCALING, gain, float(np.linalg.norm(SCALING.scaled(tau))))
    loose = required_change(SCALING, gain, float(np.linalg.norm(tau)))
    assert (np.abs(thrust) <= tight * (1.0 + 1e-9) + 1e-12).all()
    assert (tight <= loose * (1.0 + 1e-12)).all()


def test_the_printed_factor_of_7_16_is_too_small() -> None:
    """A yaw moment of 1 N m with L_typ 0.79 m: the print's min(1, L_typ) promises less change than (7.15) asks for."""
    printed = min(1.0, SCALING.typical_arm) / SCALING.mean_thrust_max
    assert printed < np.linalg.norm(SCALING.scaled([0.0, 0.0, 1.0]))
    assert required_change(SCALING, 1.0, 1.0)[0] == pytest.approx(
        required_change_scaled(SCALING, 1.0, float(np.linalg.norm(SCALING.scaled([0.0, 0.0, 1.0]))))[0], rel=1e-12
    )


def test_no_gain_requires_endless_change() -> None:
    assert np.isinf(required_change(SCALING, 0.0, 1.0)).all()
    assert (required_change(SCALING, 0.0, 0.0) == 0.0).all()


@given(st.floats(-math.pi, math.pi), st.floats(0.0, 1.0), st.sampled_from([-1.0, 1.0]), st.floats(0.01, 100.0))
def test_projection(angle: float, length: float, side: float, size: float) -> None:
    moment = side * math.sqrt(1.0 - length * length)
    arrow = project([size * length * math.cos(angle), size * length * math.sin(angle), size * moment])
    assert arrow.length == pytest.approx(length, abs=1e-12)
    assert arrow.yaw_sign == (side if moment else 0.0)
    if length > 1e-6:
        assert math.cos(arrow.angle - angle) == pytest.approx(1.0, abs=1e-12)


def test_bad_input_is_refused() -> None:
    one = np.ones(1)
    with pytest.raises(InputError, match="delta_minus, delta_plus: expected numbers not above and not below 0"):
        classify(one, -one, one, one, one)
    with pytest.raises(InputError, match="thrust_min: expected not above thrust_max"):
        classify(one, 2 * one, one, -one, one)
    with pytest.raises(InputError, match=r"delta_plus: expected shape \(1,\)"):
        classify(one, -one, one, -one, [1.0, 2.0])
    with pytest.raises(InputError, match="kinds: expected 3 numbers of LocalKind"):
        local_minimum_gain(np.eye(3), [1, 2, 3])
    with pytest.raises(InputError, match="gain: expected a number not below 0, found -1"):
        required_change(SCALING, -1.0, 1.0)
    with pytest.raises(InputError, match="direction: expected a vector of some length"):
        project([0.0, 0.0, 0.0])
