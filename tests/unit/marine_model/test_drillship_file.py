"""The drillship's file follows the formulas of docs/add_a_vessel.md, so that a user who does gets a like vessel."""

from __future__ import annotations

import math

import numpy as np
import pytest

from marine_model import Vessel, load_vessel
from marine_model.constants import GRAVITY

# The file has three digits of most numbers, and what it derives is worked out from those.
DIGITS = 0.01


@pytest.fixture(scope="module")
def ship() -> Vessel:
    return load_vessel("drillship")


def masses(ship: Vessel) -> list[float]:
    model = ship.on_surface()[0]
    return [model.rigid_body_mass[i][i] + model.added_mass[i][i] for i in range(3)]


def test_hull(ship: Vessel) -> None:
    hull, model, rho = ship.hull, ship.on_surface()[0], ship.density
    length, beam, draught = hull.length, hull.beam, hull.draught
    volume = hull.mass / rho
    block = volume / (length * beam * draught)
    near = pytest.approx
    assert block == near(0.80, rel=DIGITS)
    assert model.rigid_body_mass[2][2] == near(hull.mass * (0.25 * length) ** 2, rel=DIGITS)
    assert model.added_mass[0][0] == near(2.7 * rho * volume ** (5.0 / 3.0) / length**2, rel=DIGITS)
    thin = math.pi * (draught / length) ** 2
    sway = thin * (1.0 + 0.16 * block * beam / draught - 5.1 * (beam / length) ** 2)
    yaw = thin * (1.0 / 12.0 + 0.017 * block * beam / draught - 0.33 * beam / length)
    assert model.added_mass[1][1] == near(0.5 * rho * length**3 * sway, rel=DIGITS)
    assert model.added_mass[2][2] == near(0.5 * rho * length**5 * yaw, rel=DIGITS)
    assert model.quadratic_damping == near(
        (
            0.5 * rho * beam * draught * 0.1,
            0.5 * rho * length * draught * 0.7,
            rho * draught * 0.7 * length**4 / 64.0,
        ),
        rel=DIGITS,
    )
    hull_time = math.sqrt(length / GRAVITY)
    damping = [mass / (times * hull_time) for mass, times in zip(masses(ship), (33.0, 20.0, 11.0), strict=True)]
    assert [model.linear_damping[i][i] for i in range(3)] == near(damping, rel=DIGITS)


def test_controller(ship: Vessel) -> None:
    omega, zeta = 0.06, 0.8
    for i, mass in enumerate(masses(ship)):
        damping = ship.on_surface()[0].linear_damping[i][i]
        assert ship.controller.proportional[i] == pytest.approx(mass * omega**2, rel=DIGITS)
        assert ship.controller.derivative[i] == pytest.approx(2.0 * zeta * mass * omega - damping, rel=DIGITS)
        assert ship.controller.integral[i] == pytest.approx(mass * omega**3 / 10.0, rel=DIGITS)
        # The page's claim: two poles near omega and one near omega / 10.
        gains = ship.controller
        poles = np.roots([mass, damping + gains.derivative[i], gains.proportional[i], gains.integral[i]])
        assert (poles.real < 0.0).all()
        slow, *fast = sorted(abs(poles))
        assert slow == pytest.approx(omega / 10.0, rel=0.25)
        assert fast == pytest.approx([omega, omega], rel=0.25)


def test_observer(ship: Vessel) -> None:
    gains = ship.observer
    assert [gains.mass[i][i] for i in range(3)] == pytest.approx(masses(ship), rel=DIGITS)
    for i in range(3):
        mass, damping = gains.mass[i][i], gains.damping[i][i]
        cutoff = gains.cutoff_ratio[i] * gains.wave_frequency[i]
        polynomial = [
            1.0,
            cutoff + damping / mass,
            gains.velocity_gain[i] / mass + cutoff * damping / mass,
            gains.bias_gain[i] / mass,
        ]
        slow, fast, _ = sorted(-np.roots(polynomial).real)
        assert slow == pytest.approx(0.06 / 5.0, rel=DIGITS)
        assert fast == pytest.approx(2.0 * 0.06, rel=DIGITS)


def test_propellers_and_wash(ship: Vessel) -> None:
    for thruster in ship.thrusters:
        model = thruster.propeller.build()
        thrust, torque = (float(k) for k in model.coefficients(0.0))
        n = math.sqrt(thruster.thrust.max / (thrust * ship.density * model.diameter**4))
        power = 2.0 * math.pi * torque * ship.density * n**3 * model.diameter**5
        assert power == pytest.approx(5.5e6, rel=DIGITS)
    # Nobody's wash meets a neighbour: the force along p - q is forbidden, and 14 deg either way (15 less rounding).
    spread = math.radians(14.0)
    for j, thruster in enumerate(ship.thrusters):
        for k in range(len(ship.thrusters)):
            away = ship.lever_x[j] - ship.lever_x[k], ship.lever_y[j] - ship.lever_y[k]
            if j != k and math.hypot(*away) < 30.0:
                angle = math.atan2(away[1], away[0])
                for turn in (-spread, 0.0, spread):
                    assert any(sector.has_inside(angle + turn) for sector in ship.sectors[j]), thruster.name
        reversed_direction = ship.fixed_direction[j] + math.pi
        assert not any(sector.has_inside(reversed_direction) for sector in ship.sectors[j]), thruster.name
