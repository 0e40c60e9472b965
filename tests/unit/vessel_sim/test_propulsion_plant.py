"""The whole plant: balances, losses, actuators, one thruster against many, refusals."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.mixed_propellers import with_every_model
from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.propellers.sections import BollardData
from marine_model.thruster import AzimuthThruster
from vessel_sim.propulsion import PlantTables, PropulsionPlant, columns
from vessel_sim.propulsion.step import GOOD, advance_rows, first_bad

Array = NDArray[np.float64]
VESSEL = load_vessel("cybership3")
MIXED = with_every_model(VESSEL)
TABLES = PlantTables.of(MIXED)
N = len(VESSEL.thrusters)
H = VESSEL.simulation.time_step
STILL = np.zeros(N)
DEEP = np.full(N, 10.0)  # m: nothing ventilates


def state(plant: PropulsionPlant, column: int) -> list[float]:
    return [float(value) for value in plant.state[:, column]]


def without_ventilation(vessel: Vessel) -> Vessel:
    return Vessel.model_validate(vessel.model_dump() | {"ventilation": None})


# Balances ------------------------------------------------------------------------------------------------------------


def test_shaft_settles_where_motor_and_propeller_torque_agree() -> None:
    plant = PropulsionPlant(MIXED)
    torque = np.array([0.0005, 0.02, 0.1, 0.1])
    flow = np.array([0.1, 0.4, 0.3, -0.2])
    for _ in range(1000):
        plant.step(torque, STILL, None, flow, DEEP, H)
    # The slowest shaft has a time constant of 0.1 s; 20 s leave nothing but rounding.
    assert state(plant, columns.PROPELLER_TORQUE) == pytest.approx(torque.tolist(), rel=1e-9)
    speed, thrust = state(plant, columns.SHAFT_SPEED), state(plant, columns.THRUST)
    for i, model in enumerate(MIXED.propeller_models):
        expected, load = model.forces(speed[i], flow[i], MIXED.density)
        assert float(load) == pytest.approx(torque[i], rel=1e-9)
        assert thrust[i] == pytest.approx(float(expected), rel=1e-9)


def test_motor_limits_its_torque() -> None:
    plant = PropulsionPlant(VESSEL)
    plant.step(np.full(N, 100.0), STILL, None, STILL, DEEP, H)
    assert state(plant, columns.MOTOR_TORQUE) == [t.shaft.torque_max for t in VESSEL.thrusters]
    plant.step(np.full(N, -100.0), STILL, None, STILL, DEEP, H)
    assert state(plant, columns.MOTOR_TORQUE) == [-t.shaft.torque_max for t in VESSEL.thrusters]


def test_a_turning_propeller_in_a_flow_windmills() -> None:
    """[Ruth] (3.6)-(3.7): without motor torque K_Q = 0, so n = -a_Q V_A / (K_Q0 D); the flow is slowed down."""
    plant = PropulsionPlant(VESSEL)
    plant.state[:, columns.SHAFT_SPEED] = 1.0
    flow = np.full(N, 1.0)
    for _ in range(5000):
        plant.step(STILL, STILL, None, flow, DEEP, H)
    data = [t.propeller for t in VESSEL.thrusters if isinstance(t.propeller, BollardData)]
    assert len(data) == N
    expected = [-p.torque_slope / (p.torque_coefficient * p.diameter) for p in data]
    assert state(plant, columns.SHAFT_SPEED) == pytest.approx(expected, rel=1e-6)
    assert max(state(plant, columns.THRUST)) < 0.0


@pytest.mark.parametrize("steps", [20, 40])
def test_second_order_in_a_changing_flow(steps: int) -> None:
    """Every propeller model, flow and pitch changing, against an error-controlled integrator."""
    seconds = 0.4
    torque = np.array([0.0005, 0.03, 0.15, 0.15])
    amplitude, rate, asked = 0.3, 12.0, np.array([MIXED.pitch_ratio[0], 0.8, 1.0, 1.1])
    inertia = np.array([2.0 * math.pi * t.shaft.inertia for t in MIXED.thrusters])

    def derivative(time: float, n: Array) -> Array:
        error = asked - MIXED.pitch_ratio
        # Rate limit 0.1 1/s, time constant 0.3 s: saturated as long as |error| > 0.03, all of the 0.4 s.
        pitch = MIXED.pitch_ratio + np.sign(error) * 0.1 * time
        flow = amplitude * math.sin(rate * time)
        load = [
            float(m.forces(v, flow, MIXED.density, p)[1])
            for m, v, p in zip(MIXED.propeller_models, n.tolist(), pitch.tolist(), strict=True)
        ]
        return np.asarray((torque - load) / inertia)

    start = np.array([20.0, 10.0, 8.0, 8.0])
    expected = solve_ivp(derivative, (0.0, seconds), start, method="DOP853", rtol=1e-9, atol=1e-9).y[:, -1]
    errors = []
    for count in (steps, 2 * steps):
        plant = PropulsionPlant(MIXED)
        plant.state[:, columns.SHAFT_SPEED] = start
        plant.flood(STILL, DEEP)
        plant.state[:, columns.SHAFT_SPEED] = start  # no time has gone by
        for k in range(1, count + 1):
            flow = np.full(N, amplitude * math.sin(rate * k * seconds / count))
            plant.step(torque, STILL, asked, flow, DEEP, seconds / count)
        errors.append(np.abs(np.array(state(plant, columns.SHAFT_SPEED)) - expected))
    assert (errors[0] < 0.05).all()  # Hz of some 20, at steps of 0.02 s and less
    # A quarter; the limits of the models' ranges are kinks that cost one or the other some of it.
    assert errors[1].sum() / errors[0].sum() == pytest.approx(0.25, abs=0.1)


# Losses --------------------------------------------------------------------------------------------------------------


def test_out_of_the_water_there_is_no_thrust_and_the_shaft_races() -> None:
    plant, covered = PropulsionPlant(VESSEL), PropulsionPlant(VESSEL)
    torque = np.array([0.0005, 0.02, 0.1, 0.1])
    for _ in range(10):
        plant.step(torque, STILL, None, STILL, np.full(N, -1.0), H)
        covered.step(torque, STILL, None, STILL, DEEP, H)
    assert state(plant, columns.THRUST) == [0.0] * N
    assert state(plant, columns.PROPELLER_TORQUE) == [0.0] * N
    # Nothing but inertia (and no friction in this file): n = Q t / (2 pi J).
    inertia = np.array([t.shaft.inertia for t in VESSEL.thrusters])
    assert state(plant, columns.SHAFT_SPEED) == pytest.approx((torque * 10 * H / (2.0 * math.pi * inertia)).tolist())
    assert (np.array(state(plant, columns.SHAFT_SPEED)) > np.array(state(covered, columns.SHAFT_SPEED))).all()


def test_losses_come_at_once_and_go_at_the_rise_rate() -> None:
    plant = PropulsionPlant(VESSEL)
    assert VESSEL.ventilation is not None
    rate = VESSEL.ventilation.thrust_rise_rate
    hold = np.array([0.0005, 0.04, 0.15, 0.15])
    for _ in range(200):
        plant.step(hold, STILL, None, STILL, DEEP, H)
    assert state(plant, columns.THRUST_LOSS) == [1.0] * N
    at_surface = np.array([t.propeller.diameter for t in VESSEL.thrusters]) * 0.5
    plant.step(hold, STILL, None, STILL, at_surface, H)
    lost = state(plant, columns.THRUST_WETTED)
    assert max(lost[1:]) < 0.5
    for k in range(1, 10):
        plant.step(hold, STILL, None, STILL, DEEP, H)
        expected = [min(1.0, value + rate * k * H) for value in lost]
        assert state(plant, columns.THRUST_WETTED) == pytest.approx(expected, rel=1e-12)
        # Deep again, the disc is covered at once.
        assert state(plant, columns.THRUST_LOSS) == pytest.approx(expected, rel=1e-12)


def test_a_vessel_without_the_section_loses_nothing() -> None:
    plant = PropulsionPlant(without_ventilation(VESSEL))
    off = PropulsionPlant(VESSEL)
    off.ventilation = False
    torque = np.array([0.0005, 0.04, 0.15, 0.15])
    for _ in range(50):
        for one in (plant, off):
            one.step(torque, STILL, None, STILL, np.full(N, -1.0), H)
            assert state(one, columns.THRUST_LOSS) == [1.0] * N
            assert state(one, columns.TORQUE_LOSS) == [1.0] * N
    assert plant.state.tolist() == off.state.tolist()


@given(
    torque=st.floats(-0.2, 0.2),
    depth=st.floats(-0.1, 0.3),
    flow=st.floats(-0.5, 0.5),
    speed=st.floats(-25.0, 25.0),
)
def test_loss_factors_stay_within_0_and_1(torque: float, depth: float, flow: float, speed: float) -> None:
    plant = PropulsionPlant(MIXED)
    plant.state[:, columns.SHAFT_SPEED] = speed
    for _ in range(5):
        plant.step(np.full(N, torque), STILL, None, np.full(N, flow), np.full(N, depth), H)
        assert np.isfinite(plant.state).all()
        losses = plant.state[:, [columns.THRUST_LOSS, columns.TORQUE_LOSS]]
        assert (losses >= 0.0).all()
        assert (losses <= 1.0).all()
        # A torque loss is the smaller one, Table 2.5.
        assert (losses[:, 1] >= losses[:, 0] - 1e-15).all()


# One and many --------------------------------------------------------------------------------------------------------


@given(seed=st.integers(0, 2**32 - 1))
def test_every_row_is_a_plant_of_its_own(seed: int) -> None:
    draw = np.random.default_rng(seed)
    which = draw.integers(0, N, 20)
    fleet = PropulsionPlant.from_tables(TABLES.rows(which))
    singles = [PropulsionPlant.from_tables(TABLES.rows([i])) for i in which]
    limit = np.array([MIXED.thrusters[i].shaft.torque_max for i in which])
    diameter = np.array([MIXED.propeller_models[i].diameter for i in which])
    controllable = np.array([MIXED.thrusters[i].pitch is not None for i in which])
    for _ in range(4):
        inputs = {
            "torque": draw.uniform(-1.0, 1.0, 20) * limit,
            "azimuth_rate": draw.uniform(-1.5, 1.5, 20),
            "pitch_ratio": np.where(controllable, draw.uniform(0.5, 1.3, 20), MIXED.pitch_ratio[which]),
            "advance_speed": draw.uniform(-0.5, 0.5, 20),
            "submergence": draw.uniform(-0.5, 2.0, 20) * diameter,
        }
        fleet.step(**inputs, dt=0.1)
        for i, single in enumerate(singles):
            single.step(**{name: values[i : i + 1] for name, values in inputs.items()}, dt=0.1)
            assert single.state[0].tolist() == fleet.state[i].tolist()


@pytest.mark.parametrize("count", [1, 999, 3500])
@pytest.mark.parametrize("threads", [2, 3])
def test_the_number_of_threads_changes_no_bit(count: int, threads: int) -> None:
    draw = np.random.default_rng(5)
    tables = TABLES.rows(np.resize(range(N), count))
    alone, shared = PropulsionPlant.from_tables(tables), PropulsionPlant.from_tables(tables)

    def spread(work: Callable[[], None]) -> None:
        helpers = [threading.Thread(target=work) for _ in range(threads - 1)]
        for helper in helpers:
            helper.start()
        work()
        for helper in helpers:
            helper.join()

    shared.spread = spread
    limit = tables.parameters[:, columns.TORQUE_MAX]
    for _ in range(5):
        inputs = (
            draw.uniform(-1.0, 1.0, count) * limit,
            draw.uniform(-1.5, 1.5, count),
            None,
            draw.uniform(-0.5, 0.5, count),
            draw.uniform(-0.1, 0.5, count),
        )
        for plant in (alone, shared):
            plant.step(*inputs, 0.02)
        np.testing.assert_array_equal(shared.state, alone.state)
    assert alone.state[:, columns.SHAFT_SPEED].any()
    bad = np.zeros(count)
    bad[-1] = math.nan
    with pytest.raises(InputError, match="advance_speed: expected finite numbers, found nan"):
        shared.step(*inputs[:3], bad, inputs[4], 0.02)
    np.testing.assert_array_equal(shared.state, alone.state)


def test_steps_of_changing_length() -> None:
    """What depends on the length of a step alone is kept from step to step, and made anew for another length."""
    plant = PropulsionPlant(VESSEL)
    rate = 0.5
    for dt in (0.02, 0.02, 0.1, 0.0, 0.02):
        plant.step(STILL, np.full(N, rate), None, STILL, DEEP, dt)
    for i, thruster in enumerate(VESSEL.thrusters):
        if isinstance(thruster, AzimuthThruster):
            # 0.16 s in all, with one demand: a first-order lag from rest.
            expected = rate * (1.0 - math.exp(-0.16 / thruster.azimuth_drive.time_constant))
            assert plant.state[i, columns.AZIMUTH_RATE] == pytest.approx(expected, rel=1e-12)


def test_a_step_of_no_length_changes_nothing_but_the_water() -> None:
    plant = PropulsionPlant(MIXED)
    plant.step(np.array([0.0005, 0.02, 0.1, 0.1]), np.ones(N), None, STILL, DEEP, H)
    moving = [columns.SHAFT_SPEED, columns.AZIMUTH, columns.AZIMUTH_RATE, columns.PITCH_RATIO]
    before = plant.state[:, moving].tolist()
    plant.step(STILL, STILL, None, np.full(N, 0.1), DEEP, 0.0)
    assert plant.state[:, moving].tolist() == before
    assert state(plant, columns.ADVANCE_SPEED) == [0.1] * N


# Set points ----------------------------------------------------------------------------------------------------------


def test_the_last_pitch_set_point_stays_where_none_is_given() -> None:
    once, always = PropulsionPlant(MIXED), PropulsionPlant(MIXED)
    asked = np.array([MIXED.pitch_ratio[0], 0.7, 1.0, 1.1])
    for k in range(50):
        once.step(STILL, STILL, asked if k == 0 else None, STILL, DEEP, H)
        always.step(STILL, STILL, asked, STILL, DEEP, H)
    assert once.state.tolist() == always.state.tolist()
    assert once.state[1, columns.PITCH_RATIO] != MIXED.pitch_ratio[1]


def test_a_command_with_the_water_found_later_is_a_step() -> None:
    apart, together = PropulsionPlant(MIXED), PropulsionPlant(MIXED)
    torque, rate = np.array([0.0005, 0.02, 0.1, 0.1]), np.array([0.0, 0.5, -0.5, 0.1])
    for k in range(20):
        flow = np.full(N, 0.01 * k)
        parameters, propellers, ventilation, rows, inputs, before = apart.command(torque, rate, None)
        assert first_bad(parameters, rows, inputs, before, 0, columns.ADVANCE_SPEED_INPUT) == GOOD
        inputs[columns.ADVANCE_SPEED_INPUT], inputs[columns.SUBMERGENCE_INPUT] = flow, DEEP
        advance_rows(parameters, propellers, ventilation, rows, inputs, apart.ventilation, H, 0, N)
        apart.accept()
        together.step(torque, rate, None, flow, DEEP, H)
    assert apart.state.tolist() == together.state.tolist()


NAN = np.array([0.0, math.nan, 0.0, 0.0])
INF = np.array([0.0, 0.0, 0.0, math.inf])


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"torque": np.zeros(3)}, r"torque: expected shape \(4,\), found \(3,\)"),
        ({"azimuth_rate": np.zeros((4, 1))}, r"azimuth_rate: expected shape \(4,\), found \(4, 1\)"),
        ({"pitch_ratio": np.zeros(0)}, r"pitch_ratio: expected shape \(4,\), found"),
        ({"advance_speed": 0.0}, r"advance_speed: expected shape \(4,\), found 0\.0"),
        ({"torque": NAN}, "torque: expected finite numbers, found nan for thruster 'azimuth_bow'"),
        ({"azimuth_rate": INF}, "azimuth_rate: expected finite numbers, found inf for thruster 'azimuth_starboard'"),
        ({"pitch_ratio": NAN}, "pitch_ratio: thruster 'tunnel_bow' has a fixed pitch, expected 0.81, found 0.0"),
        ({"pitch_ratio": np.array([0.81, 0.7, 0.7, 0.7])}, "'azimuth_port' has a fixed pitch, expected 1.0, found 0.7"),
        ({"advance_speed": INF}, "advance_speed: expected finite numbers, found inf"),
        ({"submergence": NAN}, "submergence: expected finite numbers, found nan"),
        ({"dt": -0.02}, "dt: expected a finite number not below 0, found -0.02"),
        ({"dt": math.nan}, "dt: expected a finite number not below 0, found nan"),
    ],
)
def test_what_is_refused_moves_nothing(changed: dict[str, object], message: str) -> None:
    good: dict[str, object] = {
        "torque": np.array([0.0005, 0.02, 0.1, 0.1]),
        "azimuth_rate": np.ones(N),
        "pitch_ratio": np.array([0.81, 0.8, 1.0, 1.1]),
        "advance_speed": STILL,
        "submergence": DEEP,
        "dt": H,
    }
    plant, untouched = PropulsionPlant(MIXED), PropulsionPlant(MIXED)
    plant.step(**good)
    untouched.step(**good)
    with pytest.raises(InputError, match=message):
        plant.step(**good | changed)
    assert plant.state.tolist() == untouched.state.tolist()
    rest = good | {"pitch_ratio": None}
    plant.step(**rest)
    untouched.step(**rest)
    assert plant.state.tolist() == untouched.state.tolist()
