"""Thrusters that fail in the simulator: motors without torque, azimuth motors without rate."""

from __future__ import annotations

import math

import numpy as np
import pytest

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.propellers.sections import BollardData
from marine_model.settings import parameters_of, with_parameters
from marine_model.thruster import AzimuthThruster
from vessel_sim import Simulator, SimulatorInputs, SimulatorSettings
from vessel_sim.propulsion import PropulsionPlant, columns

VESSEL = load_vessel("cybership3")
N = len(VESSEL.thrusters)
H = VESSEL.simulation.time_step
STILL = np.zeros(N)
DEEP = np.full(N, 10.0)  # m: nothing ventilates
TORQUE = np.array([0.0005, 0.02, 0.1, 0.1])


def column(plant: PropulsionPlant, which: int) -> np.ndarray:
    return plant.state[:, which].copy()


def test_a_failed_motor_gives_no_torque_and_its_shaft_slows_down_as_the_water_brakes_it() -> None:
    plant = PropulsionPlant(VESSEL)
    for _ in range(500):
        plant.step(TORQUE, STILL, None, STILL, DEEP, H)
    before = column(plant, columns.SHAFT_SPEED)
    plant.fail((False, True, False, False), ())
    for _ in range(50):
        plant.step(TORQUE, STILL, None, STILL, DEEP, H)
    after = column(plant, columns.SHAFT_SPEED)
    assert column(plant, columns.MOTOR_TORQUE).tolist() == [0.0005, 0.0, 0.1, 0.1]
    # 2 pi J dn/dt = -c n^2 with c = Q_0 / n_0^2 has n = n_0 / (1 + Q_0 t / (2 pi J n_0)).
    inertia = VESSEL.thrusters[1].shaft.inertia
    expected = before[1] / (1.0 + TORQUE[1] * 50 * H / (2.0 * math.pi * inertia * before[1]))
    assert after[1] == pytest.approx(expected, rel=1e-6)  # before is settled to far better than that
    assert after[[0, 2, 3]] == pytest.approx(before[[0, 2, 3]], rel=1e-9)
    plant.fail((), ())
    for _ in range(500):
        plant.step(TORQUE, STILL, None, STILL, DEEP, H)
    assert column(plant, columns.SHAFT_SPEED) == pytest.approx(before, rel=1e-9)


def test_a_failed_propeller_windmills() -> None:
    plant = PropulsionPlant(VESSEL)
    for _ in range(100):
        plant.step(TORQUE, STILL, None, np.full(N, 0.5), DEEP, H)
    plant.fail((True,) * N, ())
    for _ in range(2000):
        plant.step(TORQUE, STILL, None, np.full(N, 0.5), DEEP, H)
    assert (column(plant, columns.MOTOR_TORQUE) == 0.0).all()
    # It turns at the advance number at which it takes no torque, (3.6), and drags.
    for i, thruster in enumerate(VESSEL.thrusters):
        propeller = thruster.propeller
        assert isinstance(propeller, BollardData)
        no_torque = -propeller.torque_coefficient / propeller.torque_slope
        speed = 0.5 / (no_torque * propeller.diameter)
        assert column(plant, columns.SHAFT_SPEED)[i] == pytest.approx(
            speed, rel=1e-6
        )  # 40 s are some 100 time constants
    assert (column(plant, columns.THRUST) < 0.0).all()


def test_a_failed_azimuth_motor_comes_to_rest_within_its_time_constant_and_stays() -> None:
    plant = PropulsionPlant(VESSEL)
    rate = np.array([0.0, 1.0, 1.0, 1.0])
    for _ in range(100):
        plant.step(STILL, rate, None, STILL, DEEP, H)
    before = column(plant, columns.AZIMUTH)
    plant.fail((), (False, False, True, False))
    for _ in range(100):
        plant.step(STILL, rate, None, STILL, DEEP, H)
    turned = column(plant, columns.AZIMUTH) - before
    port = VESSEL.thrusters[2]
    assert isinstance(port, AzimuthThruster)
    assert turned[2] == pytest.approx(1.0 * port.azimuth_drive.time_constant, rel=1e-6)  # 2 s are 40 time constants
    assert turned[[1, 3]] == pytest.approx([2.0, 2.0], rel=1e-6)
    plant.fail((), (False,) * N)
    for _ in range(100):
        plant.step(STILL, rate, None, STILL, DEEP, H)
    assert column(plant, columns.AZIMUTH)[2] - before[2] > 1.9


@pytest.mark.parametrize("name", ["motors", "azimuths"])
def test_another_number_of_thrusters_is_refused(name: str) -> None:
    plant = PropulsionPlant(VESSEL)
    before = plant.parameters.copy()
    failed = {"motors": (True,) * N, "azimuths": (True,) * N, name: (True,) * (N - 1)}
    with pytest.raises(InputError, match=rf"{name}: expected 4 elements or none, found 3"):
        plant.fail(**failed)
    assert (plant.parameters == before).all()


@pytest.mark.parametrize("name", ["failed", "azimuth_failed"])
def test_settings_of_another_vessel_are_refused_whole(name: str) -> None:
    simulator = Simulator(VESSEL)
    kept = simulator.settings
    message = rf"propulsion\.{name}: expected 4 elements, one a thruster \(tunnel_bow, .*\), found 2"
    wrong = with_parameters(kept, {f"propulsion.{name}": [True, True], "waves.amplitude": 0.03})
    with pytest.raises(InputError, match=message):
        simulator.apply(wrong)
    assert simulator.settings == kept
    with pytest.raises(InputError, match=message):
        Simulator(VESSEL, wrong)


def test_settings_for_a_vessel_name_every_thruster() -> None:
    flat = parameters_of(SimulatorSettings.for_vessel(VESSEL))
    assert flat["propulsion.failed"] == flat["propulsion.azimuth_failed"] == (False,) * N


def test_a_failure_takes_effect_at_the_next_step_of_the_simulator() -> None:
    simulator = Simulator(VESSEL, SimulatorSettings.for_vessel(VESSEL, sensor_noise=False))
    inputs = SimulatorInputs(TORQUE, STILL)
    for _ in range(100):
        simulator.step(inputs, H)
    assert (simulator.output.torque == TORQUE).all()
    simulator.apply(with_parameters(simulator.settings, {"propulsion.failed": [False, False, True, False]}))
    assert simulator.step(inputs, H).torque.tolist() == [0.0005, 0.02, 0.0, 0.1]
