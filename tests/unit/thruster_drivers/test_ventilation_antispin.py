"""Low-level anti-spin: the share of the thrust, the speed limit, and a shaft that would race without them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.ventilation.static import loss_factors
from thruster_drivers import DriverInputs, Drivers, DriverSettings
from thruster_drivers.ventilation import AntiSpin, AntiSpinSettings, VentilationMonitor, VentilationSettings

VESSEL = load_vessel("cybership3")
DT = VESSEL.simulation.time_step
AFT = 2
LOAD = float(VESSEL.propellers.torque_per_speed_squared[AFT])
INERTIA = 2.0 * math.pi * VESSEL.thrusters[AFT].shaft.inertia
ON = AntiSpinSettings(enabled=True)


def test_the_share_falls_fast_and_rises_slowly() -> None:
    antispin = AntiSpin(VESSEL, ON)
    falling = [antispin.thrust(AFT, 10.0, True, 0.4, DT) for _ in range(6)]
    np.testing.assert_allclose(falling, [8.0, 6.0, 4.0, 4.0, 4.0, 4.0])  # 10 1/s for 20 ms: a fifth a step
    rising = [antispin.thrust(AFT, 10.0, False, 0.9, DT) for _ in range(100)]
    np.testing.assert_allclose(rising, np.minimum(4.0 + 0.1 * np.arange(1, 101), 10.0))  # 0.5 1/s
    assert antispin.share == (1.0,) * 4


@given(
    st.lists(st.tuples(st.booleans(), st.floats(0.0, 2.0)), min_size=1, max_size=60),
    st.floats(-10.0, 10.0),
)
def test_the_thrust_never_jumps_and_never_grows(steps: list[tuple[bool, float]], demanded: float) -> None:
    antispin, last = AntiSpin(VESSEL, ON), demanded
    for ventilating, beta in steps:
        thrust = antispin.thrust(AFT, demanded, ventilating, beta, DT)
        move = (ON.reduction_rate if abs(thrust) < abs(last) else ON.release_rate) * DT * abs(demanded)
        assert abs(thrust - last) <= move * (1.0 + 1e-9) + 1e-12  # rounding
        assert ON.thrust_floor * abs(demanded) * (1.0 - 1e-9) <= abs(thrust) <= abs(demanded)
        last = thrust


def test_switched_off_it_lets_go_slowly() -> None:
    antispin = AntiSpin(VESSEL, ON)
    for _ in range(20):
        antispin.thrust(AFT, 1.0, True, 0.3, DT)
    antispin.apply(AntiSpinSettings())
    assert antispin.active
    assert antispin.thrust(AFT, 1.0, True, 0.3, DT) == pytest.approx(0.3 + 0.5 * DT)
    for _ in range(80):
        antispin.thrust(AFT, 1.0, True, 0.3, DT)
    assert not antispin.active


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_torque_leads_the_shaft_to_its_limit_and_no_further(sign: float) -> None:
    """The worst there is: all load gone at full torque. The observed load here is the true one."""
    antispin = AntiSpin(VESSEL, ON)
    limit = antispin.speed_limit[AFT]
    speed, largest = sign * 20.0, 0.0
    for _ in range(200):
        motor = antispin.torque(AFT, sign * 0.166, 0.0, speed)
        speed += DT * motor / INERTIA
        largest = max(largest, abs(speed))
    assert largest <= limit * (1.0 + 1e-12)  # rounding
    assert abs(speed) == pytest.approx(limit, rel=1e-3)


def test_what_is_refused_and_what_is_let_through() -> None:
    antispin = AntiSpin(VESSEL, ON)
    with pytest.raises(InputError, match=r"beta_q: expected a finite number, found nan"):
        antispin.thrust(AFT, 1.0, True, math.nan, DT)
    assert antispin.torque(AFT, 0.1, 0.0, math.nan) == 0.1  # nothing can be limited without a shaft speed
    assert AntiSpin(VESSEL).torque(AFT, 0.1, 0.0, 1e3) == 0.1  # off
    with pytest.raises(ValueError, match=r"antispin.enabled must be false while ventilation.enabled is"):
        DriverSettings(antispin=ON, ventilation=VentilationSettings(enabled=False))
    bare = VESSEL.model_copy(update={"drivers": VESSEL.drivers.model_copy(update={"ventilation": None})})
    with pytest.raises(
        InputError, match=r"antispin.enabled: expected false, because vessel 'cybership3' has no section"
    ):
        Drivers(bare, DriverSettings(antispin=ON))


def sail(control: str, antispin: AntiSpin | None, seconds: float = 60.0) -> tuple[float, float, int]:
    """Run an aft shaft in power or torque control through the submergence of [Ruth] (2.62), T_d in steps as in (2.61).

    Returns the largest shaft speed (Hz), the largest change of motor torque in a step (N m), and the number of flags.
    """
    ventilation = VESSEL.ventilation
    assert ventilation is not None
    row = ventilation.row().copy()
    monitor = VentilationMonitor(VESSEL)
    random = np.random.default_rng(3)
    factor = float(VESSEL.propellers.thrust_per_speed_squared[AFT])
    diameter = VESSEL.thrusters[AFT].propeller.diameter
    torque_max = VESSEL.thrusters[AFT].shaft.torque_max
    speed, torque, held, fastest, jump = 10.0, 0.0, 1.0, 0.0, 0.0
    seen = monitor.step(np.full(4, speed), np.zeros(4), DT)
    for k in range(round(seconds / DT)):
        time = k * DT
        demanded = (6.0, 9.0, 12.0)[int(time // 20.0)]  # N, the steps of (2.61) at the size of this propeller
        if antispin is not None:
            demanded = antispin.thrust(AFT, demanded, bool(seen.ventilating[AFT]), float(seen.beta_q[AFT]), DT)
        wanted = math.sqrt(demanded / factor)
        measured = speed + VESSEL.measurement.shaft_speed_noise * random.standard_normal()
        if control == "power":  # (3.11)-(3.12): Q = P_d / (2 pi n)
            motor = LOAD * wanted**3 / max(measured, 1.0)
        else:  # (3.10)
            motor = LOAD * wanted**2
        motor = min(motor, torque_max)
        if antispin is not None:
            motor = antispin.torque(AFT, motor, float(seen.torque[AFT]), float(seen.shaft_speed[AFT]))
        jump, torque = max(jump, abs(motor - torque) if k else 0.0), motor
        area, _, wetted = loss_factors(row, speed, diameter, 1.0, 1.2 + 1.2 * math.sin(2.0 * math.pi * time / 10.0))
        held = min(wetted, held + ventilation.torque_rise_rate * DT)
        for _ in range(20):
            speed += DT / 20.0 * (torque - area * held * LOAD * speed * abs(speed)) / INERTIA
        fastest = max(fastest, speed)
        measured = speed + VESSEL.measurement.shaft_speed_noise * random.standard_normal()
        seen = monitor.step(np.full(4, measured), np.full(4, torque), DT)
    return fastest, jump, int(monitor.events[AFT])


@pytest.mark.parametrize("control", ["power", "torque"])
def test_a_ventilating_shaft_races_without_and_not_with_anti_spin(control: str) -> None:
    antispin = AntiSpin(VESSEL, ON)
    limit = antispin.speed_limit[AFT]
    free, _, events = sail(control, None)
    held, _, _ = sail(control, antispin)
    assert events > 0
    assert free > 1.1 * limit
    # The load is observed with a delay of a few steps and with noise: the measured overshoot is below 2 %.
    assert held < 1.02 * limit


def test_with_the_drivers_the_reduction_shows_in_the_reference() -> None:
    drivers = Drivers(VESSEL, DriverSettings(antispin=ON))
    command, azimuth = np.array([0.0, 0.0, 10.0, 0.0]), VESSEL.fixed_direction
    speed, torque = VESSEL.propellers.shaft_speed(command), np.zeros(4)
    factor = 1.0
    references = []
    for k in range(200):
        if k == 100:
            factor = 0.25
        # Shafts that follow their reference at once: load and speed belong together.
        torque = factor * VESSEL.propellers.torque(speed)
        output = drivers.step(DriverInputs(command, azimuth, 0.0, speed, torque, azimuth), DT)
        references.append(float(output.thrust_reference[AFT]))
    assert references[99] == pytest.approx(10.0)
    assert output.ventilating.tolist() == [False, False, True, False]
    assert references[-1] == pytest.approx(2.5, abs=0.1)  # beta_Q settled to a hundredth
    # 10 1/s for 20 ms, and nothing jumps.
    assert np.abs(np.diff(references)).max() <= 2.0 + 1e-9
    events = drivers.ventilation_events
    assert events is not None
    assert events.tolist() == [0, 0, 1, 0]
    drivers.apply(DriverSettings(ventilation=VentilationSettings(enabled=False)))
    output = drivers.step(DriverInputs(command, azimuth, 0.0, speed, torque, azimuth), DT)
    assert drivers.ventilation_events is None
    assert output.ventilating.tolist() == [False] * 4
    assert output.beta_q.tolist() == output.beta_q2.tolist() == [1.0] * 4
    assert 2.5 < output.thrust_reference[AFT] < 2.7  # comes back at its rate
