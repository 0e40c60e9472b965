"""Four azimuth propellers that turn together: the paper's example, its slip, and what the asteroid gives away."""

from __future__ import annotations

from math import atan, cbrt, cos, degrees, pi, radians, sin

import numpy as np
import pytest

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.feasible import AzimuthSquare, next_angle, pseudo_inverse, share_within
from thrust_allocator.feasible.garus_azimuth import (
    asteroid_area,
    asteroid_excess,
    asteroid_load,
    best_angle,
    check_moment,
    check_range,
    fold,
    force_limit,
    largest_moment,
    load_at,
    reserved_thrust,
)

X = 0.4 * cos(radians(30.0)) * np.array([1.0, 1.0, -1.0, -1.0])
Y = 0.4 * sin(radians(30.0)) * np.array([-1.0, 1.0, -1.0, 1.0])
SQUARE = AzimuthSquare.of((0, 1, 2, 3), X, Y, np.full(4, 250.0))
DEMANDS = np.random.default_rng(17).uniform(-900.0, 900.0, (10_000, 2))
ALL = np.ones(4, dtype=bool)


def configuration(angle: float) -> FloatArray:
    azimuth = SQUARE.directions(angle)
    return np.array([np.cos(azimuth), np.sin(azimuth), X * np.sin(azimuth) - Y * np.cos(azimuth)])


def test_example_of_the_paper() -> None:
    reserved = reserved_thrust(SQUARE, 50.0, 0.0)
    assert reserved == pytest.approx(62.5, rel=1e-12)
    limit = force_limit(SQUARE, reserved, 0.0)
    assert limit == pytest.approx(750.0, rel=1e-12)
    assert asteroid_excess(700.0, -120.0, limit) == pytest.approx(20.6, abs=0.05)
    choice = next_angle(700.0, -120.0, 0.3, limit, 750.0, 0.0)
    # 501 and 85.9 to three digits.
    assert (choice.surge, choice.sway) == pytest.approx((501.0, -85.9), abs=0.5)
    assert choice.sway == pytest.approx(-85.9, abs=0.05)
    assert degrees(choice.angle) == pytest.approx(29.1, abs=0.05)
    assert choice.load == pytest.approx(700.0 / choice.surge, rel=1e-14)


def test_step_2_keeps_an_angle_that_cannot_give_it() -> None:
    """(100, 400) N passes (17) against 750 N, and takes 937 N at 29.1 deg."""
    present = radians(29.1)
    assert asteroid_excess(100.0, 400.0, 750.0) < 0.0
    assert 750.0 * load_at(100.0, 400.0, present, 750.0) == pytest.approx(937.0, abs=0.5)
    printed = next_angle(100.0, 400.0, present, 750.0, 750.0, 0.0, as_printed=True)
    assert printed.angle == present
    right = next_angle(100.0, 400.0, present, 750.0, 750.0, 0.0)
    assert right.angle == pytest.approx(atan(cbrt(4.0)))
    assert load_at(100.0, 400.0, right.angle, 750.0) == pytest.approx(asteroid_load(100.0, 400.0, 750.0), rel=1e-12)


def test_angle_stays_while_it_serves() -> None:
    choice = next_angle(300.0, 100.0, 0.5, 750.0, 750.0, 0.0)
    assert (choice.surge, choice.sway, choice.angle) == (300.0, 100.0, 0.5)


def test_no_demand() -> None:
    for printed in (False, True):
        choice = next_angle(0.0, 0.0, 0.7, 750.0, 750.0, 0.1, as_printed=printed)
        assert (choice.surge, choice.sway, choice.angle, choice.load) == (0.0, 0.0, 0.7, 0.0)


@pytest.mark.parametrize(("surge", "sway", "angle"), [(2000.0, 0.0, 0.0), (0.0, -2000.0, pi / 2.0)])
def test_demand_along_an_axis(surge: float, sway: float, angle: float) -> None:
    """(18) divides by tau_d2; here a corner of the asteroid."""
    choice = next_angle(surge, sway, 0.7, 750.0, 750.0, 0.0)
    assert abs(choice.surge) + abs(choice.sway) == pytest.approx(750.0)
    assert choice.angle == angle
    # The range ends before.
    assert next_angle(surge, sway, 0.7, 750.0, 750.0, 0.2).angle == pytest.approx(abs(angle - 0.2))


@pytest.mark.parametrize("angle_min", [0.0, 0.1, 0.5])
@pytest.mark.parametrize("moment", [0.0, 50.0, 120.0])
def test_permissible_at_its_angle(angle_min: float, moment: float) -> None:
    """Forces and angle of (18), with any yaw up to the reserved moment: no thrust beyond its limit."""
    reserved = reserved_thrust(SQUARE, moment, angle_min)
    limit, room = force_limit(SQUARE, reserved, angle_min), 4.0 * (250.0 - reserved)
    outside = 0
    for surge, sway in DEMANDS[:1000].tolist():
        choice = next_angle(surge, sway, 0.4, limit, room, angle_min)
        outside += choice.load > 1.0
        # Summed as the triangle (F), which is exact for the pseudo-inverse: see below.
        assert load_at(choice.surge, choice.sway, choice.angle, room) <= 1.0 + 1e-12
        assert angle_min <= choice.angle <= pi / 2.0 - angle_min
        assert choice.surge * sway == pytest.approx(choice.sway * surge, rel=1e-12)
    assert outside > 100
    for angle in np.linspace(angle_min, pi / 2.0 - angle_min, 31).tolist():
        assert moment / (4.0 * SQUARE.distance * sin(angle + SQUARE.bearing)) <= reserved * (1.0 + 1e-12)


def test_largest_thrust_is_the_sum_of_three_terms() -> None:
    """(F), against the pseudo-inverse of the matrix."""
    for angle in (0.2, 0.5, 1.2):
        inverse = pseudo_inverse(configuration(angle), ALL)
        tau = np.column_stack((DEMANDS, np.random.default_rng(1).uniform(-80.0, 80.0, len(DEMANDS))))
        largest = np.abs(tau @ inverse.T).max(axis=1)
        terms = np.abs(tau) @ (0.25 / np.array([cos(angle), sin(angle), 0.4 * sin(angle + SQUARE.bearing)]))
        np.testing.assert_allclose(largest, terms, rtol=1e-12)


def test_best_angle_is_best() -> None:
    """Against a search over all angles."""
    angles = np.linspace(0.0, pi / 2.0, 2001)[1:-1]
    demands = DEMANDS[:300]
    totals = np.abs(demands[:, :1]) / np.cos(angles) + np.abs(demands[:, 1:]) / np.sin(angles)
    for (surge, sway), total in zip(demands.tolist(), totals, strict=True):
        ours = load_at(surge, sway, best_angle(surge, sway, 0.0), 750.0)
        assert ours == pytest.approx(asteroid_load(surge, sway, 750.0), rel=1e-12)
        assert ours <= total.min() / 750.0 * (1.0 + 1e-12)


def test_directions_are_those_of_the_paper() -> None:
    np.testing.assert_allclose(np.degrees(SQUARE.directions(radians(29.0))) % 360.0, [29.0, 331.0, 151.0, 209.0])
    for azimuth in SQUARE.directions(0.6).tolist():
        assert fold(azimuth) == pytest.approx(0.6)
    assert SQUARE.bearing == pytest.approx(radians(30.0))


def test_asteroid_against_what_the_propellers_could_do() -> None:
    """50 N m reserved: the asteroid has 60 % of the area that one common angle allows with all the thrusters' freedom.

    The fourth degree of freedom, thrusts alike in all four that give nothing, takes the sum of three terms down to the
    largest sum of two of them: what is reserved for yaw costs nothing where one of the others is small.
    """
    for angle in (0.2, 0.9):
        B = configuration(angle)
        np.testing.assert_allclose(B @ np.ones(4), 0.0, atol=1e-12)
        tau = np.column_stack((DEMANDS, np.full(len(DEMANDS), 50.0)))
        thrusts = tau @ pseudo_inverse(B, ALL).T
        evened = thrusts - 0.5 * (thrusts.max(axis=1) + thrusts.min(axis=1))[:, None]
        terms = np.abs(tau) * (0.25 / np.array([cos(angle), sin(angle), 0.4 * sin(angle + SQUARE.bearing)]))
        pairs = np.max(terms.sum(axis=1)[:, None] - terms, axis=1)
        np.testing.assert_allclose(np.abs(evened).max(axis=1), pairs, rtol=1e-12)
    # 250 N for two terms, 187.5 N beside the reserved moment.
    assert asteroid_area(750.0) / _area_at_one_angle(1000.0, 750.0) == pytest.approx(0.597, abs=0.002)
    # The method of the check itself, on an asteroid: 0.5 deg steps.
    assert _area_at_one_angle(750.0, 750.0) == pytest.approx(asteroid_area(750.0), rel=2e-4)


def _area_at_one_angle(total: float, single: float) -> float:
    """Return the area of the union over angles of |X|/c + |Y|/s <= total, |X|/c <= single, |Y|/s <= single."""
    angles = np.linspace(1e-6, pi / 2.0 - 1e-6, 1501)
    c, s = np.cos(angles), np.sin(angles)
    rays = np.linspace(0.0, pi / 2.0, 721)
    u, v = np.cos(rays)[:, None], np.sin(rays)[:, None]
    reach = np.minimum(total / (u / c + v / s), single / np.maximum(u / c, v / s)).max(axis=1)
    return 4.0 * float((0.5 * reach**2 * (rays[1] - rays[0]))[:-1].sum())


def test_share_within() -> None:
    base, rest = np.array([10.0, -5.0]), np.array([20.0, -30.0])
    assert share_within(base, rest, np.full(2, -20.0), np.full(2, 20.0)) == pytest.approx(0.5)
    assert share_within(base, rest, np.full(2, -50.0), np.full(2, 50.0)) == 1.0
    assert share_within(base, np.zeros(2), np.full(2, -20.0), np.full(2, 20.0)) == 1.0
    assert share_within(2.0 * base, rest, np.full(2, -9.0), np.full(2, 9.0)) == 0.0


@pytest.mark.parametrize("angle_min", [-0.1, pi / 4.0, float("nan")])
def test_bad_range(angle_min: float) -> None:
    with pytest.raises(InputError, match=r"angle_min: expected 0 or more and less than pi/4 rad, found"):
        check_range(angle_min)


@pytest.mark.parametrize("moment", [-1.0, 200.0, float("nan")])
def test_bad_moment(moment: float) -> None:
    assert largest_moment(SQUARE, 0.0) == pytest.approx(200.0)
    with pytest.raises(InputError, match=r"reserved_moment: expected 0 or more and less than 200 N m, which all four"):
        check_moment(SQUARE, moment, 0.0)


def test_not_a_square() -> None:
    strength = np.full(4, 250.0)
    with pytest.raises(InputError, match=r"expected four azimuth thrusters .* found 3 azimuth thrusters"):
        AzimuthSquare.of((0, 1, 2), X[:3], Y[:3], strength[:3])
    with pytest.raises(InputError, match=r"found them at \(0\.5, -0\.2\) m"):
        AzimuthSquare.of((0, 1, 2, 3), np.array([0.5, *X[1:]]), Y, strength)
    with pytest.raises(InputError, match="found them at"):
        AzimuthSquare.of((0, 1, 2, 3), X, np.zeros(4), strength)
    with pytest.raises(InputError, match=r"found \[250\.0, 250\.0, 250\.0, 200\.0\] N"):
        AzimuthSquare.of((0, 1, 2, 3), X, Y, np.array([250.0, 250.0, 250.0, 200.0]))
