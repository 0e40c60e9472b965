"""The underwater simulator: thrusters on a body that turns in space, current, sensors, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.frames import attitude_rotation, wrap_angle
from vessel_sim import (
    CurrentSettings,
    InitialState,
    PropulsionSettings,
    Simulator,
    SimulatorInputs,
    SimulatorOutput,
    SimulatorSettings,
    SimulatorTruth,
    UnderwaterSimulator,
    WaveSettings,
    WindSettings,
    make_simulator,
)

Array = NDArray[np.float64]
ROV, TURNING, AUV = (load_vessel(name) for name in ("ukwial", "ukwial_azimuth", "mmt300"))
H = ROV.simulation.time_step


def quiet(vessel: Vessel, **changed: Any) -> UnderwaterSimulator:
    start = InitialState(north=1.0, east=-2.0, heading=0.7, depth=20.0)
    settings = {"sensor_noise": False, "initial": start} | changed
    return UnderwaterSimulator(vessel, SimulatorSettings.for_vessel(vessel, **settings))


def set_points(vessel: Vessel, share: list[float], turning: float = 0.0) -> SimulatorInputs:
    """Shares of the largest torque of every motor."""
    torque = np.array(share) * [thruster.shaft.torque_max for thruster in vessel.thrusters]
    return SimulatorInputs(torque, np.full(len(share), turning))


def sail(sim: UnderwaterSimulator, inputs: SimulatorInputs, duration: float, dt: float = H) -> SimulatorOutput:
    output = sim.output
    for _ in range(round(duration / dt)):
        output = sim.step(inputs, dt)
    return output


def six(horizontal: Array, vertical: Array | None) -> Array:
    """A vector in six degrees of freedom from its two triples."""
    assert vertical is not None
    return np.array([*horizontal[:2], *vertical, horizontal[2]])


def at_work(vessel: Vessel, share: list[float], turning: float = 0.0) -> SimulatorTruth:
    """The truth in the middle of a manoeuvre out of every plane, in a current."""
    sim = quiet(vessel, current=CurrentSettings(speed=0.3, direction=2.0))
    sail(sim, set_points(vessel, share, turning), 3.0)
    return sim.truth()


MANOEUVRES = {
    "ukwial": (ROV, [0.6, 0.2, -0.3, 0.1, 0.4, -0.2], 0.0),
    "ukwial_azimuth": (TURNING, [0.6, 0.2, 0.3, 0.1, 0.4, -0.2], 0.5),
    "mmt300": (AUV, [0.6, 0.2, 0.5, 0.3, -0.4], 0.0),
}


def test_the_vessel_says_which_simulator_it_needs() -> None:
    assert isinstance(make_simulator(ROV), UnderwaterSimulator)
    assert isinstance(make_simulator(load_vessel("cybership3")), Simulator)
    with pytest.raises(InputError, match="vessel: expected one with a section underwater, found 'cybership3' without"):
        UnderwaterSimulator(load_vessel("cybership3"))
    with pytest.raises(InputError, match="expected one on the surface, found 'ukwial', which is submerged"):
        Simulator(ROV)


@pytest.mark.parametrize("vessel", [ROV, TURNING, AUV], ids=lambda v: str(v.name))
def test_left_alone_it_hovers_where_it_began(vessel: Vessel) -> None:
    sim = UnderwaterSimulator(vessel)
    end = sail(sim, set_points(vessel, [0.0] * len(vessel.thrusters)), 30.0)
    # What the file rounds off buoyancy against weight, a 1e-4 of a newton, moves it by millimetres.
    np.testing.assert_allclose(end.position, [0.0, 0.0, 0.0], atol=1e-9)
    assert end.vertical_position == pytest.approx([vessel.hull.length, 0.0, 0.0], abs=1e-2)


@pytest.mark.parametrize("name", MANOEUVRES)
def test_force_of_the_thrusters_is_that_of_the_configuration_matrix(name: str) -> None:
    """[Ruth] (4.3) by hand: every thrust along its direction in space, at its place."""
    vessel, share, turning = MANOEUVRES[name]
    truth = at_work(vessel, share, turning)
    expected = np.zeros(6)
    for thruster, thrust, azimuth in zip(vessel.thrusters, truth.thrust, truth.azimuth, strict=True):
        n1, n2 = (np.array(axis) for axis in thruster.plane)
        force = thrust * (math.cos(azimuth) * n1 + math.sin(azimuth) * n2)
        expected += np.concatenate([force, np.cross(thruster.position, force)])
    np.testing.assert_allclose(truth.thruster_force6, expected, atol=1e-9)
    assert truth.thruster_force6 is not None
    np.testing.assert_array_equal(truth.thruster_force, truth.thruster_force6[[0, 1, 5]])
    if turning:
        # 3 s at 0.5 rad/s less the lag of the servo.
        turned = [wrap_angle(a - f) for a, f in zip(truth.azimuth, vessel.fixed_direction, strict=True)]
        np.testing.assert_allclose(turned[:4], 1.45, atol=0.01)


@pytest.mark.parametrize("name", MANOEUVRES)
def test_water_at_the_propellers_in_space(name: str) -> None:
    """V_A = direction . (v - current + w x r), depth by the rotation matrix."""
    vessel, share, turning = MANOEUVRES[name]
    truth = at_work(vessel, share, turning)
    assert truth.vertical_position is not None
    depth, roll, pitch = truth.vertical_position
    turn = attitude_rotation(roll, pitch, truth.position[2])
    velocity = six(truth.velocity, truth.vertical_velocity)
    through = velocity[:3] - turn.T @ [*truth.current, 0.0]
    assert np.abs(truth.vertical_position[1:]).max() > 0.01  # not upright
    for j, thruster in enumerate(vessel.thrusters):
        n1, n2 = (np.array(axis) for axis in thruster.plane)
        direction = math.cos(truth.azimuth[j]) * n1 + math.sin(truth.azimuth[j]) * n2
        advance = direction @ (through + np.cross(velocity[3:], thruster.position))
        assert truth.advance_speed[j] == pytest.approx(advance, abs=1e-12)
        assert truth.submergence[j] == pytest.approx(depth + (turn @ thruster.position)[2], abs=1e-12)


def test_advance_speed_takes_thrust_away() -> None:
    flowing = quiet(ROV)
    bollard = quiet(ROV, propulsion=PropulsionSettings(inflow=False))
    ahead = set_points(ROV, [0.4, 0.4, -0.4, -0.4, 0.0, 0.0])
    sail(flowing, ahead, 5.0)
    sail(bollard, ahead, 5.0)
    assert flowing.truth().advance_speed[0] > 0.5
    assert flowing.truth().thrust[0] < 0.95 * bollard.truth().thrust[0]


def test_steady_speed_balances_thrust_and_drag() -> None:
    """d1 u + d2 u |u| of the file against the thrust that is left at that speed."""
    sim = quiet(AUV)
    end = sail(sim, set_points(AUV, [0.5] * 4 + [0.0]), 60.0)
    data, truth = AUV.underwater, sim.truth()
    assert data is not None
    assert truth.thruster_force6 is not None
    u = end.velocity[0]
    drag = data.linear_damping[0] * u + data.quadratic_damping[0] * u * abs(u)
    assert drag == pytest.approx(truth.thruster_force6[0], rel=1e-3)  # after 60 s it still gains that much
    assert u > 0.5


def test_fins_keep_a_slender_body_from_turning_broadside() -> None:
    """Cruise at 1.5 m/s without control: the Munk moment of 143 kg u w is far above what rights it, 33 N m/rad."""
    assert AUV.underwater is not None
    bare = AUV.model_copy(update={"underwater": AUV.underwater.model_copy(update={"fins": None})})
    largest = []
    for vessel in (AUV, bare):
        sim, pitch = quiet(vessel), 0.0
        for _ in range(60):
            output = sail(sim, set_points(vessel, [0.4] * 4 + [0.0]), 1.0)
            assert output.vertical_position is not None
            pitch = max(pitch, abs(output.vertical_position[2]))
        largest.append(pitch)
    assert largest[0] < 0.1
    assert largest[1] > 0.5


def test_second_order_with_thrusters_and_current() -> None:
    """Against a step that is 16 times as fine, while shafts and azimuths start from rest."""

    def end(dt: float) -> Array:
        sim = quiet(TURNING, current=CurrentSettings(speed=0.3, direction=2.0))
        output = sail(sim, set_points(TURNING, [0.5, 0.3, 0.4, 0.2, 0.3, -0.1], 0.3), 2.0, dt)
        place, speed = six(output.position, output.vertical_position), six(output.velocity, output.vertical_velocity)
        return np.concatenate([place, speed])

    reference = end(H / 16)
    coarse, fine = (np.abs(end(dt) - reference).max() for dt in (H, H / 2))
    # 4 for order 2, a little more against a reference with an error of its own.
    assert 3.4 < coarse / fine < 4.8
    assert coarse < 2e-3  # m, rad, m/s, rad/s


def test_a_free_vehicle_goes_with_the_current_in_the_end() -> None:
    sim = quiet(ROV, current=CurrentSettings(speed=0.4, direction=1.2))
    np.testing.assert_allclose(sim.output.velocity, 0.0, atol=1e-15)  # at rest over ground at the start
    end = sail(sim, set_points(ROV, [0.0] * 6), 120.0)
    heading = end.position[2]
    # Linear damping alone, 20 N s/m on 300 kg, leaves exp(-8) of it, quadratic less.
    along = [0.4 * math.cos(1.2 - heading), 0.4 * math.sin(1.2 - heading)]
    np.testing.assert_allclose(end.velocity[:2], along, atol=1e-3)


def test_velocity_over_ground_does_not_jump_with_the_current() -> None:
    sim = quiet(ROV)
    before = sail(sim, set_points(ROV, [0.3, 0.1, -0.2, 0.2, 0.1, 0.3]), 4.0)
    sim.apply(sim.settings.model_copy(update={"current": CurrentSettings(speed=0.5, direction=-1.0)}))
    truth = sim.truth()
    np.testing.assert_allclose(truth.velocity, before.velocity, atol=1e-12)
    np.testing.assert_allclose(truth.vertical_velocity, before.vertical_velocity, atol=1e-12)
    np.testing.assert_allclose(truth.current, [0.5 * math.cos(1.0), -0.5 * math.sin(1.0)], atol=1e-15)
    assert truth.current_force6 is not None
    assert np.abs(truth.current_force6[:2]).max() > 10.0


def test_a_current_that_varies_goes_on_with_the_seed() -> None:
    current = CurrentSettings(speed=0.3, variation=0.1, time_constant=5.0)
    ends = [
        sail(quiet(ROV, current=current, seed=seed), set_points(ROV, [0.0] * 6), 10.0).position for seed in (1, 1, 2)
    ]
    np.testing.assert_array_equal(ends[0], ends[1])
    assert np.abs(ends[0] - ends[2]).max() > 1e-3


def test_it_comes_to_the_surface_and_no_further() -> None:
    sim = quiet(ROV, initial=InitialState(depth=2.0))
    up = set_points(ROV, [0.0, 0.0, 0.0, 0.0, -0.3, -0.3])
    depths = []
    for _ in range(30):
        output = sail(sim, up, 1.0)
        assert output.vertical_position is not None
        depths.append(output.vertical_position[0])
    # Some 100 N of thrust upwards are the buoyancy of 5 % of its height of 0.6 m.
    assert 0.2 < depths[-1] < 0.35
    assert min(depths) > 0.0


@pytest.mark.parametrize("failed", [0, 4])
def test_a_failed_motor_gives_no_torque(failed: int) -> None:
    switches = tuple(j == failed for j in range(6))
    sim = quiet(ROV, propulsion=PropulsionSettings(failed=switches))
    end = sail(sim, set_points(ROV, [0.3] * 6), 1.0)
    assert [j for j in range(6) if end.torque[j] == 0.0] == [failed]


# Sensors ------------------------------------------------------------------------------------------------------------


def noisy_auv(**changed: float) -> Vessel:
    values = {"depth_noise": 0.05, "attitude_noise": 0.002} | changed
    return AUV.model_copy(update={"measurement": AUV.measurement.model_copy(update=values)})


def test_pose_has_six_numbers_with_the_noise_of_the_file() -> None:
    vessel = noisy_auv()
    sim = UnderwaterSimulator(vessel, SimulatorSettings.for_vessel(vessel, seed=3))
    inputs = set_points(vessel, [0.0] * 5)
    errors = []
    for _ in range(1000):
        pose = sim.measure()
        assert pose is not None
        assert pose.shape == (6,)
        again = sim.measure()
        assert again is not None
        np.testing.assert_array_equal(again, pose)
        truth = sim.truth()
        errors.append(pose - six(truth.position, truth.vertical_position))
        sim.step(inputs, H)
    data = vessel.measurement
    deviation = [data.position_noise] * 2 + [0.05, 0.002, 0.002, data.heading_noise]
    # 1000 samples: standard error of a deviation 2.2 %.
    np.testing.assert_allclose(np.std(errors, axis=0), deviation, rtol=0.1)


def test_noise_off_shows_the_truth_and_shifts_nothing() -> None:
    vessel = noisy_auv()
    sims = [
        UnderwaterSimulator(vessel, SimulatorSettings.for_vessel(vessel, seed=3, sensor_noise=on))
        for on in (True, False)
    ]
    inputs = set_points(vessel, [0.2, 0.1, 0.2, 0.1, 0.3])
    for sim in sims:
        for _ in range(50):
            sim.measure()
            sim.step(inputs, H)
    truth, clean = sims[1].truth(), sims[1].measure()
    assert clean is not None
    # The heading is wrapped: rounding.
    np.testing.assert_allclose(clean, six(truth.position, truth.vertical_position), rtol=0.0, atol=1e-15)
    sims[0].measure()
    sims[1].apply(sims[1].settings.model_copy(update={"sensor_noise": True}))
    for sim in sims:
        sim.step(inputs, H)
    one, other = (sim.measure() for sim in sims)
    assert one is not None
    assert other is not None
    np.testing.assert_array_equal(one, other)


def test_poses_are_lost_as_often_as_asked() -> None:
    sim = UnderwaterSimulator(ROV, SimulatorSettings.for_vessel(ROV, pose_dropout=0.3))
    inputs = set_points(ROV, [0.0] * 6)
    lost = 0
    for _ in range(1000):
        lost += sim.measure() is None
        sim.step(inputs, H)
    assert lost / 1000 == pytest.approx(0.3, abs=0.06)  # four standard errors
    assert sim.measure_wind() is None


# Refusals -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"waves": WaveSettings(amplitude=0.1, period=5.0)}, "waves.amplitude: expected 0, because nothing is known"),
        (
            {"waves": WaveSettings(kind="jonswap", significant_height=0.5, peak_period=6.0)},
            "waves.significant_height: expected 0",
        ),
        ({"wind": WindSettings(speed=5.0)}, "wind.speed: expected 0, because vessel 'ukwial' has no section"),
        ({"initial": InitialState(depth=0.1)}, "initial.depth: expected at least 0.3 m, half the height of 'ukwial'"),
        ({"propulsion": PropulsionSettings(failed=(True,))}, "propulsion.failed: expected 6 elements"),
    ],
)
def test_settings_that_make_no_sense_are_refused(changed: dict[str, Any], message: str) -> None:
    settings = SimulatorSettings.for_vessel(ROV, **changed)
    with pytest.raises(InputError, match=message):
        UnderwaterSimulator(ROV, settings)
    sim = UnderwaterSimulator(ROV)
    with pytest.raises(InputError, match=message):
        sim.apply(settings)


def test_a_ship_has_no_depth_at_the_start() -> None:
    settings = SimulatorSettings(initial=InitialState(depth=3.0))
    with pytest.raises(InputError, match=r"initial.depth: expected 0, because vessel 'cybership3' is on the surface"):
        Simulator(load_vessel("cybership3"), settings)


def test_bad_set_points_move_nothing() -> None:
    sim = quiet(ROV)
    good = set_points(ROV, [0.2] * 6)
    sail(sim, good, 1.0)
    before, output = sim.truth(), sim.output
    for bad, message in (
        (SimulatorInputs(np.full(6, math.nan), np.zeros(6)), "torque: expected finite numbers, found nan"),
        (SimulatorInputs(np.zeros(5), np.zeros(6)), "torque: expected shape"),
        (SimulatorInputs(np.zeros(6), np.zeros(6), np.full(6, 0.5)), "fixed pitch"),
    ):
        with pytest.raises(InputError, match=message):
            sim.step(bad, H)
    with pytest.raises(InputError, match="dt: expected above 0"):
        sim.step(good, 2.0 * H)
    assert sim.output is output
    assert sim.truth().time == before.time
    np.testing.assert_array_equal(sim.truth().velocity, before.velocity)


def test_what_is_fixed_at_the_start_stays() -> None:
    sim = quiet(ROV)
    with pytest.raises(InputError, match="initial: cannot change during a run"):
        sim.apply(sim.settings.model_copy(update={"initial": InitialState(depth=9.0)}))
