"""Thrust of a code and code of a thrust: [Kostenko] (4), (7), (8) with Tables 2-4."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from marine_model.code_maps import Speeds, nearest_code, require_code
from marine_model.code_maps.consistency import RoundTrip, round_trip
from marine_model.code_maps.sections import DriveData
from marine_model.errors import InputError
from support.marching_thruster import SPEEDS, TABLE_2, TABLE_3, TABLE_4, TESTED_CODES, drive, drive_data

DRIVE = drive()
THRUST, CODE, REST = DRIVE.thrust_from_code, DRIVE.code_from_thrust, DRIVE.rest_code_from_thrust
COLUMNS = pytest.mark.parametrize("i", range(5), ids=[f"{speed} m/s" for speed in SPEEDS])
SPEED = st.floats(0.0, 2.0)


def printed_2(code: float, i: int) -> float:
    """(4) as it stands, column ``i`` of Table 2, without a dead zone."""
    c, b, a = (TABLE_2[name][i] for name in ("constant", "linear", "quadratic"))
    return c * math.copysign(1.0, code) + b * code + a * code * abs(code)


def printed_4(thrust: float, i: int) -> float:
    """(8) as it stands, column ``i`` of Table 4, its third coefficient taken for K_N2S."""
    k0, k1, k2, k3 = (TABLE_4[name][i] for name in ("constant", "linear", "quadratic", "cubic"))
    return k0 * math.copysign(1.0, thrust) + k1 * thrust + k2 * thrust * abs(thrust) + k3 * thrust**3


# The file and the equations -----------------------------------------------------------------------------------------


def test_the_file_has_every_entry_of_the_tables() -> None:
    data = drive_data()
    assert data.code_max == 127
    assert data.speed == SPEEDS
    for name, row in TABLE_2.items():
        assert getattr(data.thrust_from_code, name) == row
    for name, row in TABLE_4.items():
        assert getattr(data.code_from_thrust, name) == row
    for name, terms in TABLE_3.items():
        assert getattr(data.rest_code_from_thrust, name) == terms
    assert data.code_from_thrust.dead_zone == data.rest_code_from_thrust.dead_zone == 0.5
    assert data.rest_code_from_thrust.thrust_max == 43.0


@COLUMNS
def test_thrust_is_equation_4_at_the_tabulated_speeds(i: int) -> None:
    """Three codes give back the three coefficients of the column, every code the polynomial, and both signs."""
    for code in range(-127, 128):
        printed = printed_2(code, i) if code else 0.0
        thrust = printed if printed * code > 0.0 else 0.0
        assert THRUST.thrust(code, SPEEDS[i]) == pytest.approx(thrust, rel=1e-13, abs=1e-13)
    codes = np.array([80.0, 100.0, 127.0])
    found = np.polyfit(codes, [THRUST.thrust(int(code), SPEEDS[i]) for code in codes], 2)
    expected = [TABLE_2[name][i] for name in ("quadratic", "linear", "constant")]
    np.testing.assert_allclose(found, expected, rtol=1e-9)  # a parabola through three points, well conditioned


@COLUMNS
def test_code_is_equation_8_at_the_tabulated_speeds(i: int) -> None:
    speed, largest = SPEEDS[i], TABLE_4["thrust_max"][i]
    assert CODE.thrust_max(speed) == largest
    for thrust in np.linspace(0.501, largest, 60).tolist():
        for sign in (1.0, -1.0):
            assert CODE.at(sign * thrust, speed) == pytest.approx(printed_4(sign * thrust, i), rel=1e-13)
    thrusts = np.linspace(2.0, largest, 4)
    found = np.polyfit(thrusts, [CODE.at(float(thrust), speed) for thrust in thrusts], 3)
    expected = [TABLE_4[name][i] for name in ("cubic", "quadratic", "linear", "constant")]
    np.testing.assert_allclose(found, expected, rtol=1e-8)  # a cubic through four points


def test_code_at_rest_is_equation_7_both_ways() -> None:
    for thrust in np.linspace(0.501, 43.0, 60).tolist():
        for name, T in (("ahead", thrust), ("astern", -thrust)):
            k0, k1, k2, k3 = TABLE_3[name]
            assert REST.at(T) == pytest.approx(k0 + k1 * T + k2 * T**2 + k3 * T**3, rel=1e-13)
    # By hand at +-10 N: 12.7 + 43.36 - 7 + 0.729 = 49.789; -12.7 - 47.38 + 8.9 - 0.968 = -52.148.
    assert (REST.code(10.0), REST.code(-10.0)) == (50, -52)


def test_worked_by_hand_at_2_m_per_s() -> None:
    """Code 100: -15 + 20.8 + 8.67 = 14.47 N. 14.47 N: 60 + 45.870 - 6.491 + 1.515 = 100.894."""
    assert THRUST.thrust(100, 2.0) == pytest.approx(14.47, rel=1e-12)
    assert THRUST.thrust(-100, 2.0) == pytest.approx(-14.47, rel=1e-12)
    assert CODE.at(14.47, 2.0) == pytest.approx(100.894, abs=5e-4)
    assert CODE.code(14.47, 2.0) == 101


# Dead zones ---------------------------------------------------------------------------------------------------------


@COLUMNS
def test_the_dead_zone_of_4_is_its_zero_and_not_the_printed_coefficient(i: int) -> None:
    """K_F0 is a negative thrust: at |N| just above |K_F0| the print's polynomial pushes against the code."""
    speed, edge = SPEEDS[i], THRUST.dead_zone(SPEEDS[i])
    assert printed_2(edge, i) == pytest.approx(0.0, abs=1e-12)
    assert printed_2(abs(TABLE_2["constant"][i]) + 1.0, i) < -2.0  # N, at a positive code
    assert THRUST.thrust(math.floor(edge), speed) == THRUST.thrust(-math.floor(edge), speed) == 0.0
    assert THRUST.thrust(math.ceil(edge), speed) > 0.0 > THRUST.thrust(-math.ceil(edge), speed)
    # The map back begins there: within 3.3 codes, the largest difference of the two tables (at rest).
    assert TABLE_4["constant"][i] == pytest.approx(edge, abs=3.3)


def test_no_code_for_the_smallest_thrusts() -> None:
    for thrust in (0.0, 0.5, -0.5, 0.2):
        assert REST.code(thrust) == 0
        assert all(CODE.code(thrust, speed) == 0 for speed in (*SPEEDS, 0.7))
    assert (REST.code(0.51), REST.code(-0.51)) == (15, -15)
    assert CODE.code(0.51, 2.0) == 62


# Consistency --------------------------------------------------------------------------------------------------------

# Largest and rms of T(N(T)) - T over 0.5 N < T <= T_max, N: code as the map gives it, and whole. As measured.
RESIDUAL = {
    0.0: (0.766, 0.355, 0.865, 0.373),
    0.5: (0.723, 0.395, 0.932, 0.409),
    1.0: (0.764, 0.493, 0.970, 0.505),
    1.5: (0.575, 0.239, 0.752, 0.262),
    2.0: (0.669, 0.457, 0.855, 0.470),
}


def figures(trip: RoundTrip) -> list[float]:
    return [
        f(r) for r in (trip.smooth, trip.whole) for f in (lambda r: np.abs(r).max(), lambda r: np.sqrt(np.mean(r**2)))
    ]


@COLUMNS
def test_thrust_to_code_to_thrust(i: int) -> None:
    """What is in docs/underwater_drives.md; the tables are two independent fits, so that they do not agree exactly."""
    trip = round_trip(DRIVE, SPEEDS[i])
    assert figures(trip) == pytest.approx(RESIDUAL[SPEEDS[i]], abs=1e-3)  # the digits above
    # The step of a code is worth 0.48 N at the most (at rest, at 127): half of it is what whole numbers add.
    assert np.abs(trip.whole - trip.smooth).max() < 0.24
    back = round_trip(DRIVE, SPEEDS[i], astern=True)
    np.testing.assert_array_equal(back.whole, -trip.whole)  # (8) and (4) are odd


def test_residual_of_the_map_at_rest() -> None:
    """(7) into (4) at no speed: ahead 1.03 N at most; astern 1.99 N, for (4) knows no weaker propeller astern."""
    ahead, astern = round_trip(DRIVE, None), round_trip(DRIVE, None, astern=True)
    assert figures(ahead)[:2] == pytest.approx([1.034, 0.620], abs=1e-3)
    assert figures(astern)[:2] == pytest.approx([1.986, 1.211], abs=1e-3)
    assert astern.smooth.min() == -np.abs(astern.smooth).max()  # too much thrust astern


def test_row_of_largest_thrusts_against_code_127() -> None:
    """(8) at T_max means code 127 at every speed; (4) at 127 gives T_max to 0.6 N, more at all but 1 m/s."""
    assert [CODE.code(CODE.thrust_max(speed), speed) for speed in SPEEDS] == [127] * 5
    assert [CODE.code(-CODE.thrust_max(speed), speed) for speed in SPEEDS] == [-127] * 5
    codes = [CODE.at(CODE.thrust_max(speed), speed) for speed in SPEEDS]
    assert codes == pytest.approx([127.417, 126.641, 126.985, 127.493, 127.176], abs=5e-4)
    over = [THRUST.thrust(127, speed) - CODE.thrust_max(speed) for speed in SPEEDS]
    assert over == pytest.approx([0.484, 0.257, -0.139, 0.399, 0.600], abs=5e-4)


@COLUMNS
def test_a_code_gives_less_thrust_at_a_higher_speed(i: int) -> None:
    for code in TESTED_CODES:
        at = [THRUST.thrust(code, speed) for speed in SPEEDS[i : i + 2]]
        assert at == sorted(at, reverse=True)


# Between the tabulated speeds ---------------------------------------------------------------------------------------


def test_between_two_speeds_is_the_weighted_mean_of_both() -> None:
    """At 1.2 m/s, 0.6 of the column of 1 m/s and 0.4 of that of 1.5 m/s, at the same thrust, or the same code."""
    assert CODE.at(20.0, 1.2) == pytest.approx(0.6 * printed_4(20.0, 2) + 0.4 * printed_4(20.0, 3), rel=1e-13)
    assert THRUST.thrust(90, 1.2) == pytest.approx(0.6 * printed_2(90, 2) + 0.4 * printed_2(90, 3), rel=1e-13)
    assert CODE.thrust_max(1.2) == pytest.approx(0.6 * 34.5 + 0.4 * 29.9, rel=1e-13)
    edge = THRUST.dead_zone(1.2)
    assert 0.6 * printed_2(edge, 2) + 0.4 * printed_2(edge, 3) == pytest.approx(0.0, abs=1e-12)


@given(speed=SPEED, thrusts=st.tuples(st.floats(0.51, 42.0), st.floats(0.51, 42.0)))
def test_codes_rise_with_thrust_at_any_speed(speed: float, thrusts: tuple[float, float]) -> None:
    low, high = sorted(min(T, CODE.thrust_max(speed)) for T in thrusts)
    difference = CODE.at(high, speed) - CODE.at(low, speed)
    # The flattest column has 2.23 codes a newton (that at rest, at 28.6 N).
    assert difference >= 2.2 * (high - low) - 1e-9


@given(speed=SPEED, code=st.integers(-126, 126))
def test_thrust_rises_with_the_code_and_falls_with_the_speed(speed: float, code: int) -> None:
    assert THRUST.thrust(code + 1, speed) >= THRUST.thrust(code, speed)
    assert abs(THRUST.thrust(code, min(2.0, speed + 0.01))) <= abs(THRUST.thrust(code, speed))
    assert THRUST.thrust(-code, speed) == -THRUST.thrust(code, speed)


@given(place=st.sampled_from([0.5, 1.0, 1.5]), thrust=st.floats(0.51, 24.0), code=st.integers(1, 127))
def test_the_maps_are_continuous_at_the_tabulated_speeds(place: float, thrust: float, code: int) -> None:
    step = 1e-9
    for near in (place - step, place + step):
        # The code of a thrust changes by up to 60 over 0.5 m/s, the thrust of a code by up to 8 N.
        assert CODE.at(thrust, near) == pytest.approx(CODE.at(thrust, place), abs=200 * step)
        assert THRUST.thrust(code, near) == pytest.approx(THRUST.thrust(code, place), abs=20 * step)
        assert CODE.thrust_max(near) == pytest.approx(CODE.thrust_max(place), abs=20 * step)


@pytest.mark.parametrize("speed", [0.125, 0.25, 0.375, 0.75, 1.25, 1.625, 1.75, 1.875])
def test_between_the_speeds_the_two_maps_agree_as_well_as_at_them(speed: float) -> None:
    """Largest residual 0.72 N, at 0.75 m/s; at the tabulated speeds up to 0.77 N."""
    assert np.abs(round_trip(DRIVE, speed).smooth).max() < 0.72
    assert CODE.code(CODE.thrust_max(speed), speed) == 127


# Saturation, rounding, bad input ------------------------------------------------------------------------------------


def test_thrust_beyond_the_largest_is_saturated() -> None:
    for speed in (*SPEEDS, 0.3):
        at = CODE.at(CODE.thrust_max(speed), speed)
        assert CODE.at(1e6, speed) == at
        assert CODE.code(1e6, speed) == -CODE.code(-1e6, speed) == 127
    assert (REST.code(43.0), REST.code(-43.0), REST.code(1e6), REST.code(-1e6)) == (127, -127, 127, -127)
    assert REST.at(43.0) == pytest.approx(127.68, abs=0.01)  # saturated: nearest would be 128
    assert REST.at(-43.0) == pytest.approx(-128.84, abs=0.01)


def test_codes_are_rounded_halves_away_from_zero() -> None:
    values = [0.0, 0.49, 0.5, 1.5, 2.5, -0.5, -2.5, 126.5, 127.4, 300.0, -300.0]
    assert [nearest_code(value, 127) for value in values] == [0, 0, 1, 2, 3, -1, -3, 127, 127, 127, -127]


@pytest.mark.parametrize("speed", [-0.1, 2.1, math.nan, math.inf, -math.inf, -1e-12])
def test_speeds_outside_the_table_are_refused(speed: float) -> None:
    for ask in (
        lambda: THRUST.thrust(50, speed),
        lambda: THRUST.dead_zone(speed),
        lambda: CODE.code(10.0, speed),
        lambda: CODE.thrust_max(speed),
        lambda: DRIVE.code(10.0, speed),
    ):
        with pytest.raises(InputError, match=r"^speed: expected a number from 0 to 2 m/s, found"):
            ask()


def test_a_noisy_speed_is_clamped_explicitly() -> None:
    speeds = DRIVE.speeds
    assert [speeds.clamp(speed) for speed in (-0.1, 0.0, 0.7, 2.0, 2.1, 1e9)] == [0.0, 0.0, 0.7, 2.0, 2.0, 2.0]
    for bad in (math.nan, math.inf):
        with pytest.raises(InputError, match="speed: expected a finite number"):
            speeds.clamp(bad)


@pytest.mark.parametrize(
    ("code", "found"),
    [(128, "128"), (-128, "-128"), (2.0, r"2\.0"), (2.5, r"2\.5"), (math.nan, "nan"), ("5", "'5'"), (True, "True")],
)
def test_what_is_no_code_is_refused(code: Any, found: str) -> None:
    for ask in (
        lambda: THRUST.thrust(code, 1.0),
        lambda: DRIVE.torque(code, 20.0),
        lambda: DRIVE.rest_shaft_speed(code),
        lambda: require_code(code, 127),
    ):
        with pytest.raises(InputError, match=f"^code: expected a whole number.* found {found}$"):
            ask()


def test_whole_numbers_of_numpy_are_codes() -> None:
    assert require_code(np.int16(-127), 127) == -127


@pytest.mark.parametrize("thrust", [math.nan, math.inf, -math.inf])
def test_thrust_that_is_not_finite_is_refused(thrust: float) -> None:
    for ask in (lambda: CODE.code(thrust, 1.0), lambda: REST.code(thrust)):
        with pytest.raises(InputError, match="thrust: expected a finite number"):
            ask()


@pytest.mark.parametrize(
    ("change", "where", "reason"),
    [
        ({"code_max": 0}, "code_max", "greater than or equal to 1"),
        ({"code_max": 127.5}, "code_max", "integer"),
        ({"speed": [0.0]}, "speed", "expected at least 2 numbers, found 1"),
        ({"speed": [0.1, 0.5, 1.0, 1.5, 2.0]}, "speed", "expected 0, found 0.1"),
        ({"speed": [0.0, 1.0, 0.5, 1.5, 2.0]}, "speed", "expected a number above 1 before it, found 0.5"),
        ({"speed": [0.0, 0.5, 1.0, 1.5]}, "constant", "expected 4 numbers, one a speed, found 5"),
        ({"torque_droop": -0.01}, "torque_droop", "greater than or equal to 0"),
        (
            {"thrust_from_code": {"constant": [-4, -5, 8, -11, -15]}},
            "constant",
            "expected a number not above 0, found 8",
        ),
        ({"thrust_from_code": {"linear": [0.254, 0.215, 0.0, 0.21, 0.208]}}, "linear", "expected a number above 0"),
        ({"thrust_from_code": {"quadratic": [-1e-4] * 5}}, "quadratic", "expected a number not below 0"),
        ({"thrust_from_code": {"constant": [-4, -5, -8, -11, -90]}}, "constant", "expected thrust from code 127"),
        ({"code_from_thrust": {"thrust_max": [42, 38.5, 39.0, 29.9, 24.8]}}, "thrust_max", "not above 38.5 before it"),
        (
            {"code_from_thrust": {"quadratic": [-0.073, -0.2, -0.06, -0.07, -0.03]}},
            "linear",
            "expected a code that rises",
        ),
        ({"code_from_thrust": {"constant": [11.7, 20.6, -9.0, 43.2, 60.0]}}, "linear", "not below 0 at 0.5 N"),
        ({"code_from_thrust": {"cubic": [1e-4, 1e-4, 1e-4, 1e-4]}}, "cubic", "expected 5 numbers"),
        ({"rest_code_from_thrust": {"astern": [12.7, 4.7, 0.089, 9.7e-4]}}, "astern", "expected a code not below 0"),
        ({"rest_code_from_thrust": {"ahead": [12.7, -4.3, 0.0, 0.0]}}, "ahead", "expected a code that rises"),
        ({"rest_code_from_thrust": {"dead_zone": 50.0}}, "dead_zone", "expected a number below 43"),
    ],
)
def test_tables_that_are_no_maps_are_refused(change: dict[str, Any], where: str, reason: str) -> None:
    content = drive_data().model_dump()
    for name, value in change.items():
        content[name] = content[name] | value if isinstance(value, dict) else value
    with pytest.raises(ValidationError) as refused:
        DriveData.model_validate(content)
    (problem,) = refused.value.errors()
    cause = problem.get("ctx", {}).get("error")
    place = [*problem["loc"], *getattr(cause, "field", ())]
    assert where in place
    assert reason in problem["msg"]


def test_speeds_are_few_numbers() -> None:
    speeds = Speeds(SPEEDS)
    assert (len(speeds), speeds.tabulated, speeds.largest) == (5, SPEEDS, 2.0)
    assert speeds.place(1.0) == (2, 0.0)
    assert speeds.place(2.0) == (4, 0.0)
    i, weight = speeds.place(1.7)
    assert i == 3
    assert weight == pytest.approx(0.4, rel=1e-14)
