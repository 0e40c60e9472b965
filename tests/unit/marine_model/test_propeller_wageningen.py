"""The Wageningen B-series: known numbers, the range that it knows, and what is refused."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from marine_model.errors import InputError
from marine_model.propellers import OutOfRangeWarning, WageningenBPropeller

B4_70 = WageningenBPropeller(0.25, 4, 0.7, 1.0)
ALL = list(itertools.product(range(2, 8), (0.3, 0.5, 0.7, 0.9, 1.05)))


def test_bollard_coefficients_of_the_b4_70() -> None:
    """The set of 1975. [Ruth] has 0.2394 and 0.0226, from the set of 1969."""
    thrust, torque = B4_70.coefficients(0.0, 0.58)
    assert float(thrust) == pytest.approx(0.2396, abs=5e-5)  # four digits are given
    assert float(torque) == pytest.approx(0.0233, abs=5e-5)


def test_one_term_by_hand() -> None:
    """At J = 0, P/D = 1, Z = 4, A_E/A_0 = 0.7 the powers of J drop out and those of P/D are 1."""
    k_t = 0.00880496 + 0.166351 + 0.158114 - 0.133698 + 0.00638407
    k_t += 0.415437 * 0.7 - 0.0507214 * 0.49
    k_t += 4.0 * (0.0144043 + 0.0143481 - 0.00841728) + 4.0 * 0.7 * (-0.0125894 - 0.0317791) - 4.0 * 0.49 * 0.00410798
    k_t += 16.0 * (-0.000606848) + 16.0 * 0.7 * (0.000690904 + 0.00421749) + 16.0 * 0.49 * -0.00146564
    assert float(B4_70.coefficients(0.0)[0]) == pytest.approx(k_t, rel=1e-13)


@pytest.mark.parametrize(("blades", "area_ratio"), ALL)
def test_the_range_ends_where_thrust_does_and_torque_stays_positive(blades: int, area_ratio: float) -> None:
    propeller = WageningenBPropeller(1.0, blades, area_ratio, 1.0)
    pitch = np.linspace(0.5, 1.4, 46)
    end = propeller.advance_number_end(pitch)
    # Rounding of a cubic with coefficients near 1.
    np.testing.assert_allclose(propeller.coefficients(end, pitch)[0], 0.0, atol=1e-14)
    inside = np.linspace(0.0, 0.999, 50)[:, None] * end
    thrust, torque = propeller.coefficients(inside, pitch)
    assert (thrust > 0.0).all()  # so that the end is the first zero
    assert (torque > 0.0).all()


@pytest.mark.parametrize(("blades", "area_ratio"), ALL)
def test_nothing_inside_is_taken_for_outside_by_the_guess_of_the_end(blades: int, area_ratio: float) -> None:
    """The kernel looks for the end only above 0.9 of its guess, which must therefore not be 10 % too large."""
    propeller = WageningenBPropeller(1.0, blades, area_ratio, 1.0)
    pitch = np.linspace(0.5, 1.4, 46)
    guess = np.polynomial.polynomial.polyval(pitch, propeller.row()[6:10])
    assert (np.abs(guess / propeller.advance_number_end(pitch) - 1.0) < 0.03).all()


def test_coefficients_broadcast() -> None:
    pitch, advance = np.array([0.6, 0.8, 1.0]), np.array([[0.0], [0.3]])
    thrust, torque = B4_70.coefficients(advance, pitch)
    assert thrust.shape == torque.shape == (2, 3)
    for i, j in np.ndindex(2, 3):
        assert thrust[i, j] == B4_70.coefficients(advance[i, 0], pitch[j])[0]


def test_the_range_at_the_design_pitch() -> None:
    assert B4_70.pitch_range == (0.5, 1.4)
    low, high = B4_70.advance_number_range
    assert low == 0.0
    assert high == pytest.approx(float(B4_70.advance_number_end(1.0)))


@pytest.mark.parametrize(
    ("advance", "pitch", "message"),
    [
        (-0.1, 1.0, r"advance_number: expected a number from 0 to 1\.0.*, found -0.1"),
        (1.2, 1.0, r"advance_number: expected a number from 0 to 1\.0.*, found 1.2"),
        ([0.1, 0.7], 0.5, r"advance_number: expected a number from 0 to 0\.5.*, found 0.7"),
        (0.1, 1.5, r"pitch_ratio: expected a number from 0.5 to 1.4, found 1.5"),
        (0.1, 0.4, r"pitch_ratio: expected a number from 0.5 to 1.4, found 0.4"),
        (np.nan, 1.0, r"advance_number: expected finite numbers, found nan"),
        (0.1, np.inf, r"pitch_ratio: expected finite numbers, found inf"),
        ("much", 1.0, r"advance_number: expected numbers, found 'much'"),
    ],
)
def test_out_of_range_is_refused(advance: object, pitch: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        B4_70.coefficients(advance, pitch)


@given(advance=st.floats(-2.0, 3.0), pitch=st.floats(0.1, 2.0))
def test_clamping_answers_for_the_nearest_inside_and_warns(advance: float, pitch: float) -> None:
    held = min(max(pitch, 0.5), 1.4)
    end = float(B4_70.advance_number_end(held))
    # What is off a limit by rounding counts as inside.
    assume(min(abs(advance), abs(advance - end), abs(pitch - 0.5), abs(pitch - 1.4)) > 1e-9)
    nearest = B4_70.coefficients(min(max(advance, 0.0), end), held)
    if held == pitch and 0.0 <= advance <= end:
        found = B4_70.coefficients(advance, pitch, "clamp")
    else:
        with pytest.warns(OutOfRangeWarning, match="taken as the nearest limit"):
            found = B4_70.coefficients(advance, pitch, "clamp")
    assert [float(k) for k in found] == [float(k) for k in nearest]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 4, 0.7, 1.0), "diameter: expected a number above 0, found 0.0"),
        ((-0.2, 4, 0.7, 1.0), "diameter: expected a number above 0, found -0.2"),
        ((0.2, 1, 0.7, 1.0), "blades: expected a whole number from 2 to 7, found 1"),
        ((0.2, 8, 0.7, 1.0), "blades: expected a whole number from 2 to 7, found 8"),
        ((0.2, 4.5, 0.7, 1.0), "blades: expected a whole number from 2 to 7, found 4.5"),
        ((0.2, 4, 0.2, 1.0), "area_ratio: expected a number from 0.3 to 1.05, found 0.2"),
        ((0.2, 4, 1.1, 1.0), "area_ratio: expected a number from 0.3 to 1.05, found 1.1"),
        ((0.2, 4, 0.7, 1.41), "pitch_ratio: expected a number from 0.5 to 1.4, found 1.41"),
        ((0.2, 4, 0.7, float("nan")), "pitch_ratio: expected a finite number, found nan"),
    ],
)
def test_no_such_propeller(arguments: tuple[float, int, float, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        WageningenBPropeller(*arguments)
