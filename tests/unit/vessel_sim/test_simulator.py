"""The whole simulator: convergence, balances, sensors, determinism, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from benchmarks.mixed_propellers import with_every_model
from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.frames import rotation
from marine_model.propellers.kernel import thrust_torque
from support.box_hull import DRIFT_COEFFICIENT, box_of, with_box_hull
from vessel_sim import (
    CurrentSettings,
    InitialState,
    PropulsionSettings,
    Simulator,
    SimulatorInputs,
    SimulatorOutput,
    SimulatorSettings,
    WaveSettings,
)
from vessel_sim.inflow import Inflow
from vessel_sim.propulsion.columns import AZIMUTH
from vessel_sim.sail import SURGE, YAW_RATE
from vessel_sim.waves import Waves

Array = NDArray[np.float64]
VESSEL = with_box_hull(load_vessel("cybership3"))
H = VESSEL.simulation.time_step
N = len(VESSEL.thrusters)
STILL = SimulatorInputs(np.zeros(N), np.zeros(N))
QUIET = SimulatorSettings(sensor_noise=False)
# Propellers as at bollard pull.
BOLLARD = SimulatorSettings(sensor_noise=False, propulsion=PropulsionSettings(inflow=False, ventilation=False))


def sail(sim: Simulator, seconds: float, inputs: SimulatorInputs = STILL, dt: float = H) -> SimulatorOutput:
    for _ in range(round(seconds / dt)):
        output = sim.step(inputs, dt)
    return output


# Integrator ----------------------------------------------------------------------------------------------------------


def reference(settings: SimulatorSettings, inputs: SimulatorInputs, seconds: float) -> Array:
    """Position and velocity through the water at the end, from an error-controlled integrator, in matrix form."""
    data = VESSEL.on_surface()[0]
    mass = np.array(data.rigid_body_mass) + np.array(data.added_mass)
    linear, quadratic = np.array(data.linear_damping), np.array(data.quadratic_damping)
    inertia = 2.0 * math.pi * np.array([t.shaft.inertia for t in VESSEL.thrusters])
    lag = np.array([1.0, 0.05, 0.05, 0.05])
    current = settings.current.speed * np.array(
        [math.cos(settings.current.direction), math.sin(settings.current.direction), 0.0]
    )
    c0, c1, _ = DRIFT_COEFFICIENT
    pressure = 0.5 * VESSEL.density * 9.81 * settings.waves.amplitude**2

    sea = Waves(box_of(VESSEL), settings.waves)
    water = Inflow(VESSEL)

    def rate(time: float, x: Array) -> Array:
        heading, nu, speed = x[2], x[3:6], x[6:10]
        angle, turn = x[10:14], x[14:18]
        place, relative = tuple(x[:3].tolist()), tuple(nu.tolist())
        _, flow = water.at(place, relative, angle.copy(), sea, time, tuple(current[:2].tolist()))
        if not settings.propulsion.inflow:
            flow = np.zeros(N)
        # Test of the integration, not of the propeller models: their own code does.
        thrust, torque = np.array(
            [
                thrust_torque(row, model.diameter, VESSEL.density, n, v, model.pitch_ratio)
                for row, model, n, v in zip(
                    VESSEL.propeller_table, VESSEL.propeller_models, speed.tolist(), flow.tolist(), strict=True
                )
            ]
        ).T
        fx, fy = thrust * np.cos(angle), thrust * np.sin(angle)
        b = settings.waves.direction - heading
        tau = np.array(
            [
                fx.sum() + c0 * pressure * VESSEL.hull.beam * math.cos(b),
                fy.sum() + c1 * pressure * VESSEL.hull.length * math.sin(b) * abs(math.sin(b)),
                (VESSEL.lever_x * fy - VESSEL.lever_y * fx).sum(),
            ]
        )
        p = mass @ nu
        coriolis = np.array([-p[1] * nu[2], p[0] * nu[2], p[1] * nu[0] - p[0] * nu[1]])
        acceleration = np.linalg.solve(mass, tau - coriolis - linear @ nu - quadratic * np.abs(nu) * nu)
        return np.concatenate(
            [
                rotation(heading) @ nu + current,
                acceleration,
                (inputs.torque - torque) / inertia,
                turn,
                (inputs.azimuth_rate - turn) / lag,
            ]
        )

    start = np.zeros(18)
    start[3:6] = -current  # at rest over ground, heading north
    start[10:14] = VESSEL.fixed_direction
    return np.asarray(solve_ivp(rate, (0.0, seconds), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:6, -1])


@pytest.mark.parametrize("inflow", [False, True])
def test_second_order_convergence_to_an_error_controlled_integrator(inflow: bool) -> None:
    """Ship, shafts and azimuths together, from rest at full use: halving the step quarters the error.

    Without ventilation, whose limits have kinks.
    """
    settings = SimulatorSettings(
        waves=WaveSettings(amplitude=0.06, period=0.8, direction=2.6, ramp=0.0),
        current=CurrentSettings(speed=0.2, direction=1.0),
        propulsion=PropulsionSettings(inflow=inflow, ventilation=False),
        sensor_noise=False,
    )
    inputs = SimulatorInputs(np.array([-0.0005, 0.03, 0.12, 0.1]), np.array([0.0, 0.4, -0.3, 1.0]))
    seconds = 8.0
    expected = reference(settings, inputs, seconds)
    errors = []
    for dt in (H, H / 2.0, H / 4.0):
        sim = Simulator(VESSEL, settings)
        output = sail(sim, seconds, inputs, dt)
        errors.append(float(np.abs(np.concatenate([output.position, sim._relative]) - expected).max()))
    # Measured 5.2e-5 (m, rad, m/s, rad/s) at 0.02 s without and 4.4e-5 with inflow, a twentieth of the position
    # noise, in a manoeuvre of 8 s.
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_without_forces_the_ship_only_loses_energy() -> None:
    sim = Simulator(VESSEL, QUIET)
    sim._motion[SURGE : YAW_RATE + 1] = 1.0, 0.4, -0.5
    energy = sim.kinetic_energy()
    for _ in range(6000):
        sim.step(STILL, H)
        assert sim.kinetic_energy() < energy
        energy = sim.kinetic_energy()
    # Two minutes are eight time constants of the slowest motion, surge: 95.2 / 6.9 s; energy goes with the square.
    assert energy < 100.0 * math.exp(-2.0 * 120.0 / (95.2 / 6.9)) * 1.0


def test_thrusters_at_their_limits_reversing_keep_the_ship_bounded() -> None:
    sim = Simulator(VESSEL, QUIET)
    limit = np.array([t.shaft.torque_max for t in VESSEL.thrusters])
    largest = 1.3 * float(np.maximum(VESSEL.thrust_max, -VESSEL.thrust_min).sum())  # torque_max is 1.3 Q(T_max)
    for k in range(3000):
        sign = 1.0 if (k // 25) % 2 else -1.0
        output = sim.step(SimulatorInputs(100.0 * sign * limit, np.full(N, 50.0 * sign)), H)
        assert np.abs(output.torque) == pytest.approx(limit)
        assert np.abs(output.azimuth_rate).max() <= 1.05 * (1.0 + 1e-12)
    # No speed can pass the one at which linear damping alone takes all the thrust there is.
    assert np.abs(output.velocity[:2]).max() < largest / 6.9


# Balances ------------------------------------------------------------------------------------------------------------


def test_free_ship_drifts_with_the_current() -> None:
    sim = Simulator(VESSEL, SimulatorSettings(current=CurrentSettings(speed=0.2, direction=2.0)))
    output = sail(sim, 200.0)
    over_ground = rotation(float(output.position[2])) @ output.velocity
    # Half of the start decays in 10 s: what is left after 200 s is e^-13 of 0.2 m/s.
    assert over_ground == pytest.approx([0.2 * math.cos(2.0), 0.2 * math.sin(2.0), 0.0], abs=1e-5)


def test_drift_force_of_head_seas_is_balanced_by_drag() -> None:
    waves = WaveSettings(amplitude=0.06, period=0.8, direction=math.pi)
    # Drifting astern is unstable in yaw (Munk moment), so no longer than rounding needs to grow.
    output = sail(Simulator(VESSEL, SimulatorSettings(waves=waves)), 100.0)
    force = 0.5 * 1000.0 * 9.81 * 0.06**2 * 0.44 / 2.0  # N, 3.88
    speed = brentq(lambda v: 6.9 * v + 3.5 * v * v - force, 0.0, 5.0)
    # The approach decays with (6.9 + 7.0 v) / 95.2 = 0.1 per second: e^-10 of v is left.
    assert output.velocity == pytest.approx([-speed, 0.0, 0.0], abs=5e-5)


def test_thrust_ahead_reaches_the_speed_where_drag_takes_it() -> None:
    torque = np.array([0.0, 0.0, 0.1, 0.1])
    shaft_speed = np.sqrt(0.1 / VESSEL.propellers.torque_per_speed_squared[2:])
    thrust = VESSEL.propellers.thrust_per_speed_squared[2:] * shaft_speed**2
    sim = Simulator(VESSEL, BOLLARD)
    sim._plant.state[:, AZIMUTH] = [0.5 * math.pi, 0.5 * math.pi, 0.0, 0.0]
    # Port and starboard thrusts differ: compare the force, then what the drag says to it in straight motion.
    output = sail(sim, 5.0, SimulatorInputs(torque, np.zeros(N)))
    assert output.shaft_speed[2:] == pytest.approx(shaft_speed, rel=1e-6)
    truth = sim.truth()
    assert truth.thrust[2:] == pytest.approx(thrust, rel=1e-6)
    assert truth.thruster_force == pytest.approx(
        [thrust.sum(), 0.0, 0.11 * thrust[0] - 0.11 * thrust[1]], rel=1e-6, abs=1e-9
    )


def test_developed_power_at_full_thrust() -> None:
    # [Ruth] (3.11) at T_max of azimuth_port; torque for 13.5 N is K_Q D T / K_T.
    q = 0.0442 * 0.09 * 13.5 / 0.42
    output = sail(Simulator(VESSEL, BOLLARD), 20.0, SimulatorInputs(np.array([0.0, 0.0, q, 0.0]), np.zeros(N)))
    assert output.power[2] == pytest.approx(float(VESSEL.propellers.power(np.full(N, 13.5))[2]), rel=1e-6)
    assert output.power == pytest.approx(2.0 * math.pi * output.shaft_speed * output.torque, rel=1e-12)


def test_current_force_is_what_a_ship_at_rest_feels() -> None:
    sim = Simulator(VESSEL, SimulatorSettings(current=CurrentSettings(speed=0.1, direction=math.pi / 2.0)))
    # 19.3 * 0.1 + 110 * 0.01 N to starboard on a ship that heads north; 0.59 * 0.1 N m.
    assert sim.truth().current_force == pytest.approx([0.0, 3.03, 0.059], abs=1e-12)
    still = Simulator(VESSEL, QUIET)
    assert still.truth().current_force == pytest.approx(np.zeros(3), abs=0.0)


# Propulsion ----------------------------------------------------------------------------------------------------------


def test_thrust_is_lost_to_the_advance_speed() -> None:
    """Steaming ahead: thrust and shaft speed are those of the linear model at the advance number of the ship."""
    torque = np.array([0.0, 0.0, 0.1, 0.1])
    sim = Simulator(VESSEL, QUIET)
    sim._plant.state[:, AZIMUTH] = [0.5 * math.pi, 0.5 * math.pi, 0.0, 0.0]
    sail(sim, 8.0, SimulatorInputs(torque, np.zeros(N)))
    truth = sim.truth()
    assert truth.velocity[0] > 0.3
    for i in (2, 3):
        model = VESSEL.propeller_models[i]
        # By hand: at the side of the ship the propeller meets u - L_y r.
        flow = truth.velocity[0] - VESSEL.lever_y[i] * truth.velocity[2]
        assert truth.advance_speed[i] == pytest.approx(flow, rel=1e-9)
        thrust, load = model.forces(truth.shaft_speed[i], flow, VESSEL.density)
        # The plant has the velocity that the predictor of the step saw, off by (0.02 s)^2 of the jerk.
        assert truth.thrust[i] == pytest.approx(float(thrust), rel=1e-4)
        # The shaft follows the load of a ship that still gathers way: a hundredth behind.
        assert float(load) == pytest.approx(0.1, rel=0.01)
    assert truth.thrust_loss.tolist() == [1.0] * N


def test_a_propeller_near_the_surface_loses_thrust_until_ventilation_is_switched_off() -> None:
    trimmed = with_box_hull(load_vessel("cybership3_trimmed"))
    sea = SimulatorSettings(sensor_noise=False, waves=WaveSettings(amplitude=0.05, period=1.2, ramp=0.0))
    sim = Simulator(trimmed, sea)
    inputs = SimulatorInputs(np.array([0.0, 0.0, 0.12, 0.12]), np.zeros(N))
    least, deepest, shallowest = np.ones(N), np.zeros(N), np.full(N, np.inf)
    for _ in range(500):
        sim.step(inputs, H)
        truth = sim.truth()
        least = np.minimum(least, truth.thrust_loss)
        deepest, shallowest = np.maximum(deepest, truth.submergence), np.minimum(shallowest, truth.submergence)
    assert (least[2:] < 0.5).all()
    assert least[:2].tolist() == [1.0, 1.0]  # deep, or at rest
    # The mean is the depth at rest; the waves are followed in part only.
    assert 0.5 * (deepest + shallowest) == pytest.approx(trimmed.shaft_depth, abs=0.005)
    assert (deepest - shallowest > 0.02).all()
    sim.apply(sea.model_copy(update={"propulsion": PropulsionSettings(ventilation=False)}))
    sim.step(inputs, H)
    assert sim.truth().thrust_loss.tolist() == [1.0] * N
    assert sim.truth().torque_loss.tolist() == [1.0] * N


def test_controllable_pitch() -> None:
    vessel = with_every_model(VESSEL)
    sim = Simulator(vessel, QUIET)
    own = vessel.pitch_ratio
    assert sim.output.pitch_ratio == pytest.approx(own, abs=0.0)
    asked = np.array([own[0], 0.7, own[2], 1.5])
    for _ in range(500):
        sim.step(SimulatorInputs(np.zeros(N), np.zeros(N), asked), H)
    # 10 s are more than thirty time constants; 1.5 is beyond what the actuator does.
    assert sim.output.pitch_ratio == pytest.approx([own[0], 0.7, own[2], 1.2], abs=1e-12)
    assert sim.step(STILL, H).pitch_ratio == pytest.approx([own[0], 0.7, own[2], 1.2], abs=1e-12)
    with pytest.raises(InputError, match=r"pitch_ratio: thruster 'tunnel_bow' has a fixed pitch, expected 0\.81"):
        sim.step(SimulatorInputs(np.zeros(N), np.zeros(N), np.ones(N)), H)
    assert sim.truth().pitch_ratio == pytest.approx([own[0], 0.7, own[2], 1.2], abs=1e-12)


# Sensors -------------------------------------------------------------------------------------------------------------


def record(settings: SimulatorSettings, seconds: float = 4.0) -> list[list[float] | None]:
    sim = Simulator(VESSEL, settings)
    inputs = SimulatorInputs(np.array([0.0003, 0.02, 0.05, 0.04]), np.array([0.0, 0.2, -0.1, 0.1]))
    rows: list[list[float] | None] = []
    for k in range(round(seconds / H)):
        if k % 10 == 0:
            pose = sim.measure()
            rows.append(None if pose is None else pose.tolist())
        out = sim.step(inputs, H)
        rows.append(np.concatenate([out.shaft_speed, out.torque, out.power, out.azimuth, out.azimuth_rate]).tolist())
    return rows


SEA = WaveSettings(amplitude=0.06, period=0.8)


def test_same_seed_gives_the_same_bits_and_another_seed_does_not() -> None:
    settings = SimulatorSettings(waves=SEA, seed=5, pose_dropout=0.2)
    first = record(settings)
    assert record(settings) == first
    assert record(settings.model_copy(update={"seed": 6})) != first
    assert None in first


def test_first_draws_of_seed_zero_are_fixed() -> None:
    """The order of draws is part of the contract: a change of it would silently change every recorded run."""
    pose_stream, thruster_stream = np.random.SeedSequence(0).spawn(2)
    pose_normal = np.random.Generator(np.random.PCG64(pose_stream)).standard_normal(3)
    thruster_normal = np.random.Generator(np.random.PCG64(thruster_stream)).standard_normal(2 * N)
    sim = Simulator(VESSEL, SimulatorSettings())
    assert sim.measure() == pytest.approx(pose_normal * 0.001, rel=1e-12)
    assert sim.output.shaft_speed == pytest.approx(thruster_normal[:N] * 0.1, rel=1e-12)
    expected = VESSEL.fixed_direction + np.concatenate([[0.0], thruster_normal[N + 1 :] * 0.005])
    assert sim.output.azimuth == pytest.approx(expected, rel=1e-12)


def test_noise_has_the_size_that_the_vessel_file_says() -> None:
    sim = Simulator(VESSEL, SimulatorSettings(seed=3))
    poses = []
    speeds = []
    for _ in range(2000):
        speeds.append(sim.step(STILL, H).shaft_speed)
        pose = sim.measure()
        assert pose is not None
        poses.append(pose)
    # The sample deviation of 2000 draws is within 4 of its own deviations, 1 / sqrt(2 * 2000), of the true one.
    tolerance = 4.0 / math.sqrt(4000.0)
    assert np.std(poses, axis=0) == pytest.approx([0.001, 0.001, 0.001], rel=tolerance)
    assert np.std(speeds, axis=0) == pytest.approx([0.1] * N, rel=tolerance)


def test_noise_off_and_on_again_shifts_no_later_draw() -> None:
    noisy, switched = (Simulator(VESSEL, SimulatorSettings(seed=1)) for _ in range(2))
    switched.apply(SimulatorSettings(seed=1, sensor_noise=False))
    for _ in range(7):
        a, b = noisy.step(STILL, H), switched.step(STILL, H)
        assert noisy.measure() is not None
        clean = switched.measure()
        assert clean is not None
        assert clean.tolist() == [0.0, 0.0, 0.0]
        assert b.shaft_speed.tolist() == [0.0] * N
    switched.apply(SimulatorSettings(seed=1))
    a, b = noisy.step(STILL, H), switched.step(STILL, H)
    assert a.shaft_speed.tolist() == b.shaft_speed.tolist()
    assert noisy.measure() == pytest.approx(switched.measure(), abs=0.0)


def test_lost_measurements() -> None:
    sim = Simulator(VESSEL, SimulatorSettings(pose_dropout=0.3))
    lost = 0
    for _ in range(2000):
        sim.step(STILL, H)
        lost += sim.measure() is None
    assert lost == pytest.approx(600, abs=4.0 * math.sqrt(2000 * 0.3 * 0.7))  # four deviations of the binomial
    sim.apply(SimulatorSettings(pose_dropout=1.0))
    sim.step(STILL, H)
    assert sim.measure() is None


def test_measuring_twice_at_one_instant_gives_one_measurement() -> None:
    sim, other = (Simulator(VESSEL, SimulatorSettings(seed=2)) for _ in range(2))
    assert sim.measure() is sim.measure()
    other.measure()
    sim.step(STILL, H)
    other.step(STILL, H)
    assert sim.measure() == pytest.approx(other.measure(), abs=0.0)


def test_pose_holds_low_frequency_and_wave_motion() -> None:
    waves = WaveSettings(amplitude=0.02, period=2.5, direction=2.0)
    start = InitialState(north=2.0, east=-3.0, heading=3.1)
    sim = Simulator(VESSEL, SimulatorSettings(waves=waves, initial=start, sensor_noise=False))
    sail(sim, 11.0)
    truth, pose = sim.truth(), sim.measure()
    assert pose is not None
    assert np.abs(truth.wave_position).max() > 0.001
    total = truth.position + truth.wave_position
    assert pose[:2] == pytest.approx(total[:2], abs=1e-15)
    assert math.sin(pose[2] - total[2]) == pytest.approx(0.0, abs=1e-12)
    assert -math.pi <= pose[2] < math.pi


# Changes while running, and refusals ----------------------------------------------------------------------------------


def test_velocity_over_ground_does_not_jump_when_the_current_changes() -> None:
    sim = Simulator(VESSEL, QUIET)
    before = sail(sim, 10.0, SimulatorInputs(np.array([0.0, 0.02, 0.05, 0.05]), np.zeros(N)))
    sim.apply(QUIET.model_copy(update={"current": CurrentSettings(speed=0.3, direction=1.2)}))
    assert sim.truth().velocity == pytest.approx(before.velocity, abs=1e-12)
    after = sim.step(STILL, H)
    # At most 110 N s^2/m^2 * 0.3^2 m^2/s^2 and 19.3 N s/m * 0.3 m/s on 101 kg for 0.02 s.
    assert np.abs(after.velocity[:2] - before.velocity[:2]).max() < 4e-3


@pytest.mark.parametrize(
    ("changed", "name"), [({"seed": 1}, "seed"), ({"initial": InitialState(north=1.0)}, "initial")]
)
def test_what_is_fixed_at_the_start_cannot_change(changed: dict[str, object], name: str) -> None:
    sim = Simulator(VESSEL, SimulatorSettings())
    asked = SimulatorSettings(waves=SEA).model_copy(update=changed)
    with pytest.raises(InputError, match=f"{name}: cannot change during a run"):
        sim.apply(asked)
    assert sim.settings == SimulatorSettings()


@pytest.mark.parametrize(
    ("inputs", "dt", "message"),
    [
        (SimulatorInputs(np.zeros(3), np.zeros(N)), H, r"torque: expected shape \(4,\), found \(3,\)"),
        (SimulatorInputs(np.zeros(N), np.zeros((N, 1))), H, r"azimuth_rate: expected shape \(4,\), found \(4, 1\)"),
        (SimulatorInputs(np.array([0.0, math.nan, 0.0, 0.0]), np.zeros(N)), H, "torque: expected finite.*nan"),
        (
            SimulatorInputs(np.zeros(N), np.array([0.0, math.inf, -math.inf, 0.0])),
            H,
            "azimuth_rate: expected finite.*inf",
        ),
        (STILL, 0.0, "dt: expected above 0"),
        (STILL, 0.03, r"dt: expected above 0 and at most 0\.02 s, found 0\.03"),
        (STILL, math.nan, "dt: expected above 0"),
    ],
)
def test_bad_input_is_refused_and_nothing_moves(inputs: SimulatorInputs, dt: float, message: str) -> None:
    sim, untouched = (Simulator(VESSEL, SimulatorSettings(waves=SEA)) for _ in range(2))
    good = SimulatorInputs(np.array([0.0003, 0.02, 0.05, 0.04]), np.zeros(N))
    sail(sim, 1.0, good)
    sail(untouched, 1.0, good)
    with pytest.raises(InputError, match=message):
        sim.step(inputs, dt)
    assert sim.step(good, H).position.tolist() == untouched.step(good, H).position.tolist()
    assert sim.output.shaft_speed.tolist() == untouched.output.shaft_speed.tolist()


def test_a_tunnel_thruster_does_not_turn() -> None:
    output = sail(Simulator(VESSEL, QUIET), 1.0, SimulatorInputs(np.zeros(N), np.ones(N)))
    assert output.azimuth[0] == 0.5 * math.pi
    assert output.azimuth_rate[0] == 0.0
    assert output.azimuth[1] > 0.5 * math.pi + 0.5
