"""Portions of the marching thrusters: what each channel gets, and that no channel has a say in another."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.feasible import Cross, PortionedThrust, Portions, portion

DELTA = radians(22.5)
CROSS = Cross(DELTA, 1.0, 0.8, -42.0, 42.0)
PORTIONS = Portions(0.6, 0.4, 0.4)
T_MAX = 34.5  # at 1 m/s, Table 4
# Largest demands that the portions allow, (6).
SURGE = 4.0 * cos(DELTA) * 0.6 * T_MAX
TURN = 2.0 * sin(DELTA) * 1.0 * 0.4 * T_MAX


def divide(tau: FloatArray, portions: Portions = PORTIONS, thrust_max: float = T_MAX) -> PortionedThrust:
    """Divide demands (..., 4): surge, heave, pitch, yaw."""
    surge, heave, pitch, yaw = np.moveaxis(tau, -1, 0)
    return portion(surge, heave, pitch, yaw, CROSS, portions, thrust_max)


def forces(thrust: FloatArray) -> FloatArray:
    """Return surge, heave, pitch, yaw of thrusts (..., 5), each thruster's own: r x F at its place, body frame."""
    s, c = sin(DELTA), cos(DELTA)
    axes = np.array([[c, 0.0, -s], [c, 0.0, s], [c, -s, 0.0], [c, s, 0.0], [0.0, 0.0, -1.0]])
    places = np.array([[-1.0, 0.0, 0.0]] * 4 + [[0.8, 0.0, 0.0]])
    columns = np.hstack((axes, np.cross(places, axes)))[:, [0, 2, 4, 5]]
    found: FloatArray = thrust @ columns
    return found


def demands(count: int, scale: float = 1.0) -> FloatArray:
    return np.random.default_rng(5).uniform(-scale, scale, (count, 4)) * [SURGE, 30.0, TURN, TURN]


def test_5_in_this_frame() -> None:
    """(5) with the signs of this frame, thruster by thruster."""
    for i, thrust in enumerate(np.eye(5)):
        u, d, left, r, b = thrust
        s, c = sin(DELTA), cos(DELTA)
        expected = [
            (u + d + left + r) * c,
            -((u - d) * s + b),
            b * 0.8 - (u - d) * s * 1.0,
            -(r - left) * s * 1.0,
        ]
        np.testing.assert_allclose(forces(thrust), expected, atol=1e-15, err_msg=str(i))


def test_by_hand() -> None:
    found = divide(np.array([40.0, 0.0, 0.0, 0.0]), PORTIONS, T_MAX)
    np.testing.assert_allclose(found.thrust, [40.0 / (4.0 * cos(DELTA))] * 4 + [0.0], atol=1e-15)
    found = divide(np.array([0.0, 0.0, 0.0, 5.0]), PORTIONS, T_MAX)
    # Bow to starboard: the left thruster pushes the stern to port.
    turn = 5.0 / (2.0 * sin(DELTA))
    np.testing.assert_allclose(found.thrust, [0.0, 0.0, turn, -turn, 0.0], atol=1e-14)
    found = divide(np.array([1000.0, 0.0, 0.0, -1000.0]), PORTIONS, T_MAX)
    np.testing.assert_allclose(found.thrust[:4], np.array([0.6, 0.6, 0.2, 1.0]) * T_MAX, rtol=1e-14)
    assert found.load == pytest.approx(1000.0 / TURN)


def test_every_demand_within_its_portion_is_met() -> None:
    tau = demands(10_000)
    found = divide(tau, PORTIONS, T_MAX)
    assert (np.abs(found.thrust[:, :4]) <= T_MAX * (1.0 + 1e-12)).all()
    np.testing.assert_array_equal(np.clip(found.thrust[:, 4], -42.0, 42.0), found.thrust[:, 4])
    met = found.load <= 1.0
    assert met.sum() > 4000
    assert (~met).sum() > 500
    np.testing.assert_allclose(forces(found.thrust)[met], tau[met], atol=1e-12 * SURGE)


def test_channels_are_independent() -> None:
    """Whatever is asked of the others, surge and yaw come out the same to rounding; so do heave and pitch as a pair."""
    tau = demands(10_000, 3.0)
    out = forces(divide(tau, PORTIONS, T_MAX).thrust)
    for axis, others in ((0, [1, 2, 3]), (3, [0, 1, 2])):
        alone = tau.copy()
        alone[:, others] = 0.0
        np.testing.assert_allclose(
            forces(divide(alone, PORTIONS, T_MAX).thrust)[:, axis], out[:, axis], atol=1e-12 * SURGE
        )
        limit = (SURGE, np.nan, np.nan, TURN)[axis]
        np.testing.assert_allclose(out[:, axis], np.clip(tau[:, axis], -limit, limit), atol=1e-12 * SURGE)
    together = tau.copy()
    together[:, [0, 3]] = 0.0
    lonely = forces(divide(together, PORTIONS, T_MAX).thrust)
    np.testing.assert_allclose(lonely[:, 1:3], out[:, 1:3], atol=1e-12 * SURGE)


def test_as_printed_only_a_portion_is_served() -> None:
    """(6) to the letter gives 60 % of a demand that is far from any limit."""
    thrust = 20.0 / (4.0 * cos(DELTA))
    assert thrust < T_MAX
    printed = 0.6 * thrust
    assert 4.0 * cos(DELTA) * printed == pytest.approx(12.0)
    found = divide(np.array([20.0, 0.0, 0.0, 0.0]), PORTIONS, T_MAX)
    assert forces(found.thrust)[0] == pytest.approx(20.0)


def test_heave_and_pitch_by_hand() -> None:
    """T_B = (M - L_s Z) / 1.8 and 2 T_psi sin(delta) = (M + L_b Z) / 1.8: heave without by-product."""
    found = divide(np.array([0.0, 0.0, 9.0, 0.0]), PORTIONS, T_MAX)
    psi = 5.0 / (2.0 * sin(DELTA))
    np.testing.assert_allclose(found.thrust, [-psi, psi, 0.0, 0.0, 5.0], atol=1e-14)
    np.testing.assert_allclose(forces(found.thrust), [0.0, 0.0, 9.0, 0.0], atol=1e-14)
    # (6) takes all of it from the marching thrusters, and lifts the vehicle by 9 N.
    psi = 9.0 / (2.0 * sin(DELTA))
    np.testing.assert_allclose(forces(np.array([-psi, psi, 0.0, 0.0, 0.0])), [0.0, 9.0, 9.0, 0.0], atol=1e-14)


@pytest.mark.parametrize(("heave", "pitch"), [(10.0, 60.0), (-100.0, 2.0), (80.0, 120.0), (-300.0, -1.0)])
def test_heave_and_pitch_are_reduced_together(heave: float, pitch: float) -> None:
    """Beyond the bow thruster or the portion of pitch: neither turns round for the other."""
    found = divide(np.array([0.0, heave, pitch, 0.0]), PORTIONS, T_MAX)
    assert found.load > 1.0
    np.testing.assert_allclose(forces(found.thrust), np.array([0.0, heave, pitch, 0.0]) / found.load, atol=1e-12)
    at_limit = [abs(found.thrust[4]) == pytest.approx(42.0), abs(found.thrust[1]) == pytest.approx(0.4 * T_MAX)]
    assert any(at_limit)


def test_no_demand_and_no_thrust() -> None:
    zero = np.zeros(4)
    for limit in (0.0, T_MAX):
        found = divide(zero, PORTIONS, limit)
        np.testing.assert_array_equal(found.thrust, 0.0)
        assert found.load == 0.0
    found = divide(np.ones(4), PORTIONS, 0.0)
    np.testing.assert_array_equal(found.thrust[:4], 0.0)
    assert np.isinf(found.load)


@pytest.mark.parametrize(
    ("portions", "message"),
    [
        ((0.6, 0.4, 0.3), r"portions\.surge \+ portions\.pitch: expected 1, found 0\.9"),
        ((0.6, 0.5, 0.4), r"portions\.surge \+ portions\.yaw: expected 1, found 1\.1"),
        ((1.2, -0.2, -0.2), r"portions\.surge: expected a number from 0 to 1, found 1\.2"),
        ((float("nan"), 0.5, 0.5), r"portions\.surge: expected a number from 0 to 1, found nan"),
    ],
)
def test_bad_portions(portions: tuple[float, float, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Portions(*portions)


@pytest.mark.parametrize("limit", [-1.0, float("nan"), float("inf")])
def test_bad_limit(limit: float) -> None:
    with pytest.raises(InputError, match="thrust_max: expected a finite number, 0 or more, found"):
        divide(np.zeros(4), PORTIONS, limit)
