"""Table 2.2: which model-scale results may be scaled, with the numbers of [Ruth] 2.1 for D = 0.25 m."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from marine_model.errors import InputError
from marine_model.propellers import FroudeScale, ModelRun, check_scaling

# The chord is not printed: 0.091 m is what makes R_n = 2e5 at the printed 4 Hz with nu = 1e-6.
RUN = ModelRun(
    shaft_speed=6.0,
    diameter=0.25,
    advance_speed=0.0,
    shaft_depth=0.3,
    chord=0.091,
    scale=16.0,
    regime="non_ventilated",
)


def at(speed: float, **changes: object) -> ModelRun:
    return replace(RUN, shaft_speed=speed, **changes)


def test_weber_numbers_of_section_2_1_4() -> None:
    """W between 15 and 368 in tests of 1 to 25 Hz, and above 180 from 12 Hz: printed without decimals."""
    assert round(at(1.0).weber_number) == 15
    assert round(at(25.0).weber_number) == 368
    limit = 180.0 / at(1.0).weber_number
    assert round(limit) == 12
    assert not check_scaling(at(12.0)).requirements[6].met
    assert check_scaling(at(12.5)).requirements[6].met


def test_reynolds_number_of_section_2_1_1() -> None:
    assert at(4.0).reynolds_number == pytest.approx(2.0e5, rel=0.005)
    assert at(4.0).inflow_speed == pytest.approx(0.7 * math.pi)  # n D = 1 m/s
    assert not check_scaling(at(3.9)).may_be_scaled
    assert check_scaling(at(3.9)).reasons_against == ("Reynolds number: expected above 200000, found 1.95e+05",)
    assert check_scaling(at(4.1)).may_be_scaled
    assert "to be corrected" in check_scaling(at(4.1)).requirements[3].reason
    assert "constant" in check_scaling(at(10.5)).requirements[3].reason


def test_froude_number_of_section_2_1_2() -> None:
    """What ships reach, 1.4, is 0 to 9 Hz with D = 0.25 m (one digit)."""
    assert at(9.0).froude_number == pytest.approx(1.437, abs=5e-4)
    assert round(1.4 / at(1.0).froude_number) == 9


def test_cavitation_number_by_hand() -> None:
    """(2.21) with (0.7 pi)^2: h/R = 2.4, g / (D n^2) = 9.81 / 9, J = 0."""
    run = at(6.0, regime="fully_ventilated")
    assert run.cavitation_number == pytest.approx(2.4 * (9.81 / 9.0) / (0.7 * math.pi) ** 2)
    run = replace(run, advance_speed=0.75)  # J = 0.5
    assert run.cavitation_number == pytest.approx(2.4 * (9.81 / 9.0) / ((0.7 * math.pi) ** 2 + 0.25))


@pytest.mark.parametrize(
    ("regime", "required"),
    [
        ("non_ventilated", {1, 2, 3, 4}),
        ("fully_ventilated", {1, 2, 3, 4, 5, 6}),
        ("partially_ventilated", {1, 2, 3, 4, 5, 6}),
    ],
)
def test_table_2_2(regime: str, required: set[int]) -> None:
    check = check_scaling(at(6.0, regime=regime))
    assert [r.number for r in check.requirements] == [1, 2, 3, 4, 5, 6, 7]
    assert {r.number for r in check.requirements if r.required} == required
    assert check.may_be_scaled == (regime != "partially_ventilated")


def test_partial_ventilation_cannot_be_scaled_at_atmospheric_pressure() -> None:
    for speed in (5.0, 9.0, 30.0):
        (*_, reason) = check_scaling(at(speed, regime="partially_ventilated")).reasons_against
        assert reason.startswith("cavitation number: ")
        assert "atmospheric pressure" in reason


@pytest.mark.parametrize(("speed", "may"), [(8.0, True), (15.0, False), (24.0, False), (26.0, True)])
def test_full_ventilation_needs_a_froude_number_of_a_ship_or_above_4(speed: float, may: bool) -> None:
    check = check_scaling(at(speed, regime="fully_ventilated"))
    assert check.may_be_scaled is may
    assert len(check.reasons_against) == (0 if may else 2)  # Froude, and the cavitation number that follows from it


def test_the_ships_run_is_told() -> None:
    reasons = [r.reason for r in check_scaling(RUN).requirements]
    assert reasons[0] == "for a ship with D = 4 m"
    assert reasons[1] == "for a ship at J = 0"
    assert reasons[2] == "for a ship with its shaft at 4.8 m"
    assert reasons[4] == "for a ship at n = 1.5 Hz"


def test_froude_scale_keeps_the_coefficients() -> None:
    """K_T = T / (rho D^4 n^2), K_Q = Q / (rho D^5 n^2), J = V_A / (n D), P = 2 pi n Q."""
    s = FroudeScale(30.0, 1.025)
    assert s.thrust / (s.density_ratio * s.length**4 * s.shaft_speed**2) == pytest.approx(1.0)
    assert s.torque / (s.density_ratio * s.length**5 * s.shaft_speed**2) == pytest.approx(1.0)
    assert s.speed / (s.shaft_speed * s.length) == pytest.approx(1.0)
    assert s.power == pytest.approx(s.shaft_speed * s.torque)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"diameter": 0.0}, "diameter: expected a number above 0, found 0.0"),
        ({"shaft_speed": -1.0}, "shaft_speed: expected a number above 0, found -1.0"),
        ({"chord": math.nan}, "chord: expected a finite number, found nan"),
        ({"scale": 0.0}, "scale: expected a number above 0, found 0.0"),
        ({"shaft_depth": math.inf}, "shaft_depth: expected a finite number, found inf"),
        ({"regime": "ventilated"}, "regime: expected one of non_ventilated, .*, found 'ventilated'"),
    ],
)
def test_refusals(changes: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(RUN, **changes)
