"""Control by integer code: law, speed and settings, with shafts and propellers that turn behind it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from marine_model import Vessel, load_vessel
from marine_model.code_maps.consistency import round_trip
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.settings import with_parameters
from support.marching_thruster import SPEEDS, drive, driven_vessel, straight_vessel
from thruster_drivers import DriverInputs, DriverOutput, Drivers, DriverSettings
from thruster_drivers.controllers import make_controller, tuning_of
from thruster_drivers.drivers import NOMINAL, SPEED_LOST
from thruster_drivers.settings import CodeMapSettings
from thruster_drivers.shaft_model import shaft_models
from vessel_sim.propulsion import PropulsionPlant, columns

DRIVE = drive()
THRUST, CODE, REST = DRIVE.thrust_from_code, DRIVE.code_from_thrust, DRIVE.rest_code_from_thrust
STRAIGHT, MMT300 = straight_vessel(), driven_vessel()
N = len(STRAIGHT.thrusters)
H = STRAIGHT.simulation.time_step
STILL = np.zeros(N)
DEEP = np.full(N, 10.0)
COMPENSATED = DriverSettings(controller="code_map")
AT_REST = DriverSettings(controller="code_map", code_map=CodeMapSettings(compensated=False))
# Largest difference of thrust between the truth, (3) with a torque that falls straight, and Table 2, N, by speed: what
# test_code_drive.py measures, over all codes that give thrust.
TRUTH = dict(zip(SPEEDS, (1e-6, 0.396, 0.871, 0.236, 0.440), strict=True))


class Rig:
    """The drivers, and the simulator's shafts and propellers in a flow."""

    def __init__(self, vessel: Vessel, settings: DriverSettings) -> None:
        self.drivers = Drivers(vessel, settings)
        self.plant = PropulsionPlant(vessel)
        self.output: DriverOutput | None = None

    def step(self, thrust: FloatArray, speed: float | None, flow: FloatArray) -> DriverOutput:
        state = self.plant.state
        measured = state[:, columns.SHAFT_SPEED].copy(), state[:, columns.MOTOR_TORQUE].copy()
        inputs = DriverInputs(thrust, STILL, 0.0, *measured, STILL, surge_speed=speed)
        self.output = self.drivers.step(inputs, H)
        self.plant.step(self.output.torque, STILL, None, flow, DEEP, H)
        return self.output

    def settle(self, thrust: FloatArray, speed: float | None, flow: FloatArray) -> FloatArray:
        """Return the thrusts after 3 s: 0.5 s for the thrust rate, and time constants of the shafts below 0.05 s."""
        for _ in range(150):
            self.step(thrust, speed, flow)
        return self.plant.state[:, columns.THRUST].copy()


# What the driver, the shaft and the propeller make of it -------------------------------------------------------------


@pytest.mark.parametrize("speed", SPEEDS)
def test_compensated_thrust_is_within_the_residual_of_the_maps(speed: float) -> None:
    thrust = CODE.thrust_max(speed) * np.array([0.1, 0.3, 0.5, 0.75, 1.0])
    rig = Rig(STRAIGHT, COMPENSATED)
    achieved = rig.settle(thrust, speed, np.full(N, speed))
    assert rig.output is not None
    assert rig.output.code.tolist() == [CODE.code(T, speed) for T in thrust.tolist()]
    own = np.abs(round_trip(DRIVE, speed).whole).max()
    assert np.abs(achieved - thrust).max() < own + TRUTH[speed]
    # And what it comes from: the code by Table 2, within what the truth is off it.
    by_table = [THRUST.thrust(code, speed) for code in rig.output.code.tolist()]
    np.testing.assert_allclose(achieved, by_table, atol=TRUTH[speed] + 1e-6)  # settled


@pytest.mark.parametrize("speed", SPEEDS[1:])
def test_uncompensated_thrust_falls_short_by_what_table_2_implies(speed: float) -> None:
    # From 15 N on the codes at rest give thrust at every speed.
    thrust = np.array([15.0, 18.0, 21.0, 23.0, 24.8])
    rig = Rig(STRAIGHT, AT_REST)
    achieved = rig.settle(thrust, speed, np.full(N, speed))
    assert rig.output is not None
    codes = rig.output.code.tolist()
    assert codes == [REST.code(T) for T in thrust.tolist()] == [64, 72, 80, 84, 88]
    implied = thrust - [THRUST.thrust(code, speed) for code in codes]
    assert implied.min() > 2.0  # N
    np.testing.assert_allclose(thrust - achieved, implied, atol=TRUTH[speed])


def test_at_2_m_per_s_in_numbers() -> None:
    """As it comes out. By Table 2 codes 77 and 88 give 6.16 N and 10.02 N there, 115 and 127 20.39 N and 25.40 N."""
    thrust, flow = np.array([20.0, 24.8, 20.0, 24.8, 0.0]), np.full(N, 2.0)
    without, with_speed = Rig(STRAIGHT, AT_REST), Rig(STRAIGHT, COMPENSATED)
    found = without.settle(thrust, 2.0, flow)[:2], with_speed.settle(thrust, 2.0, flow)[:2]
    assert without.output is not None
    assert with_speed.output is not None
    assert without.output.code.tolist() == [77, 88, 77, 88, 0]
    assert with_speed.output.code.tolist() == [115, 127, 115, 127, 0]
    np.testing.assert_allclose(found[0], [5.727, 9.583], atol=1e-3)
    np.testing.assert_allclose(found[1], [20.137, 25.299], atol=1e-3)


def test_thrust_against_the_motion_takes_the_code_of_no_speed() -> None:
    """The tables are made for thrust along the motion. At 2 m/s the propeller that turns astern gives far more.

    (8) as printed, odd in the thrust, would add to it: its code 115 is good for 46 N against the motion.
    """
    rig, thrust = Rig(STRAIGHT, COMPENSATED), np.array([-20.0, -10.0, 20.0, -5.0, 0.0])
    achieved = rig.settle(thrust, 2.0, np.full(N, 2.0))
    assert rig.output is not None
    assert rig.output.code.tolist() == [CODE.code(-20.0, 0.0), CODE.code(-10.0, 0.0), 115, CODE.code(-5.0, 0.0), 0]
    assert (CODE.code(-20.0, 0.0), CODE.code(-20.0, 2.0)) == (-76, -115)
    np.testing.assert_allclose(achieved[[0, 1, 3]], [-29.305, -17.118, -10.233], atol=1e-3)


def test_a_thruster_at_an_angle_has_its_part_of_the_speed() -> None:
    """Marching thrusters at 22.5 deg see 0.924 of the surge speed, the bow thruster across nothing of it."""
    rig = Rig(MMT300, COMPENSATED)
    along = 2.0 * math.cos(math.radians(22.5))
    thrust = np.array([20.0, 12.0, 16.0, 25.0, 20.0])
    achieved = rig.settle(thrust, 2.0, np.array([along] * 4 + [0.0]))
    assert rig.output is not None
    assert rig.output.code.tolist() == [*(CODE.code(T, along) for T in thrust[:4].tolist()), CODE.code(20.0, 0.0)]
    assert abs(achieved[4] - 20.0) < 0.9  # the residual at rest; the truth has none there
    assert np.abs(achieved[:4] - thrust[:4]).max() < 0.86 + TRUTH[2.0]


def test_torque_is_that_of_the_code_at_the_measured_shaft_speed() -> None:
    rig = Rig(STRAIGHT, COMPENSATED)
    thrust = np.array([30.0, 10.0, -10.0, -30.0, 0.2])
    rig.settle(thrust, 1.0, np.full(N, 1.0))
    shaft = rig.plant.state[:, columns.SHAFT_SPEED].copy()
    output = rig.step(thrust, 1.0, np.full(N, 1.0))
    expected = [DRIVE.torque(int(code), n) for code, n in zip(output.code, shaft, strict=True)]
    assert output.torque.tolist() == expected
    assert output.code.dtype == np.int16
    assert output.shaft_speed_reference.tolist() == [DRIVE.rest_shaft_speed(int(code)) for code in output.code]


def test_the_torque_stays_within_the_motors_limit_and_does_without_a_sensor() -> None:
    law = make_controller("code_map", shaft_models(STRAIGHT)[0], tuning_of(STRAIGHT.drivers, 0))
    limit = STRAIGHT.thrusters[0].shaft.torque_max
    assert DRIVE.torque(127, 0.0) > limit
    assert law.step(42.0, 0.0, math.nan, H).torque == limit
    assert law.step(-43.0, 0.0, math.nan, H).torque == -limit
    assert law.code == -127
    for lost in (math.nan, math.inf):
        assert law.step(20.0, lost, math.nan, H).torque == DRIVE.torque(REST.code(20.0), math.nan)


# The speed ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [None, math.nan, math.inf])
def test_without_a_speed_codes_are_those_at_rest_and_it_is_said(speed: float | None) -> None:
    rig, thrust = Rig(STRAIGHT, COMPENSATED), np.array([20.0, -20.0, 43.0, 0.4, 5.0])
    rig.settle(thrust, speed, STILL)
    assert rig.output is not None
    assert rig.output.code.tolist() == [REST.code(T) for T in (20.0, -20.0, 42.0, 0.4, 5.0)]  # T_max is 42 N
    assert (rig.output.status, rig.output.speed_beyond) == (SPEED_LOST, 0.0)
    assert rig.step(thrust, 0.0, STILL).status == NOMINAL


@pytest.mark.parametrize(
    ("speed", "held", "beyond"), [(-0.1, 0.0, -0.1), (2.1, 2.0, 0.1), (2.0, 2.0, 0.0), (0.0, 0.0, 0.0)]
)
def test_a_speed_outside_the_tables_is_clamped_and_said(speed: float, held: float, beyond: float) -> None:
    rig = Rig(STRAIGHT, COMPENSATED)
    thrust = np.full(N, 20.0)
    rig.settle(thrust, speed, STILL)
    assert rig.output is not None
    assert rig.output.code.tolist() == [CODE.code(20.0, held)] * N
    assert rig.output.speed_beyond == pytest.approx(beyond, abs=1e-15)
    assert rig.output.status == NOMINAL


def test_uncompensated_laws_do_not_look_at_the_speed() -> None:
    rig = Rig(STRAIGHT, AT_REST)
    for speed in (None, math.nan, 5.0, 1.0):
        rig.settle(np.full(N, 20.0), speed, STILL)
        assert rig.output is not None
        assert rig.output.code.tolist() == [REST.code(20.0)] * N
        assert (rig.output.status, rig.output.speed_beyond) == (NOMINAL, 0.0)


def test_codes_are_sent_by_code_laws_only() -> None:
    some = Drivers(STRAIGHT, DriverSettings(controller="code_map, torque, shaft_speed, code_map, power"))
    inputs = DriverInputs(np.full(N, 20.0), STILL, 0.0, STILL, STILL, STILL, surge_speed=1.0)
    for _ in range(50):
        output = some.step(inputs, H)
    code = CODE.code(20.0, 1.0)
    assert output.code.tolist() == [code, 0, 0, code, 0]
    assert some.sends_codes
    some.apply(DriverSettings(controller="torque"))
    assert some.step(inputs, H).code.shape == (0,)
    assert not some.sends_codes


def test_a_command_that_goes_stale_ends_at_code_0() -> None:
    rig = Rig(STRAIGHT, COMPENSATED)
    rig.settle(np.full(N, 20.0), 0.0, STILL)
    inputs = DriverInputs(np.full(N, 20.0), STILL, 5.0, STILL, STILL, STILL, surge_speed=0.0)
    for _ in range(50):
        output = rig.drivers.step(inputs, H)
    assert output.command_stale
    assert output.code.tolist() == [0] * N


@pytest.mark.parametrize("other", ["torque", "shaft_speed", "power"])
def test_a_change_of_law_or_of_compensation_goes_on_from_the_torque(other: str) -> None:
    rig, thrust, flow = Rig(STRAIGHT, COMPENSATED), np.full(N, 15.0), np.full(N, 1.0)
    rig.settle(thrust, 1.0, flow)
    for settings in (AT_REST, DriverSettings(controller=other), COMPENSATED):
        assert rig.output is not None
        before, n = rig.output.torque, rig.plant.state[:, columns.SHAFT_SPEED].copy()
        rig.drivers.apply(settings)
        after = rig.step(thrust, 1.0, flow).torque
        # A law of shaft speed moves its integral by one sample; the others begin where the last ended.
        moved: FloatArray = np.zeros(N)
        if settings.controller == "shaft_speed":
            gains, inertia = STRAIGHT.drivers.shaft_speed, STRAIGHT.thrusters[0].shaft.inertia
            assert rig.output is not None
            error = rig.output.shaft_speed_reference - n
            moved = 2.0 * math.pi * inertia * gains.bandwidth * error * H / gains.integral_time
        np.testing.assert_allclose(after, before + moved, rtol=0.0, atol=1e-9)
        rig.settle(thrust, 1.0, flow)
    assert np.abs(rig.plant.state[:, columns.THRUST] - 15.0).max() < 0.97 + TRUTH[1.0]


# Settings -------------------------------------------------------------------------------------------------------------


def test_a_thruster_without_a_drive_cannot_follow_codes() -> None:
    reason = "expected a law without codes at thruster 'tunnel_bow', found 'code_map', which needs a section 'drive'"
    vessel = load_vessel("cybership3")
    with pytest.raises(InputError, match=reason):
        Drivers(vessel, COMPENSATED)
    assert not DriverSettings().needs_speed(vessel)
    with pytest.raises(InputError, match="expected a thruster with a drive for 'code_map'"):
        make_controller("code_map", shaft_models(vessel)[0], tuning_of(vessel.drivers, 0))


def test_a_torque_that_falls_too_steeply_for_the_time_step_is_refused() -> None:
    """The limit is 2 pi J / h = 2 pi 3e-4 / 0.02 = 0.0942 N m/Hz."""
    content = STRAIGHT.model_dump()
    content["thrusters"][1]["drive"]["torque_droop"] = 0.0943
    reason = r"expected a drive\.torque_droop of at most 0\.09425 N m/Hz at thruster 'lower' for 'code_map'"
    with pytest.raises(InputError, match=reason):
        Drivers(Vessel.model_validate(content), COMPENSATED)
    content["thrusters"][1]["drive"]["torque_droop"] = 0.0942
    Drivers(Vessel.model_validate(content), COMPENSATED)


def test_who_needs_the_speed() -> None:
    assert COMPENSATED.needs_speed(STRAIGHT)
    assert not AT_REST.needs_speed(STRAIGHT)
    assert not DriverSettings().needs_speed(STRAIGHT)
    assert DriverSettings(controller="torque,torque,torque,code_map,torque").needs_speed(STRAIGHT)


@pytest.mark.parametrize("value", ["yes", 1])
def test_compensated_is_true_or_false(value: Any) -> None:
    with pytest.raises(InputError, match=r"code_map\.compensated"):
        with_parameters(DriverSettings(), {"code_map.compensated": value})


def test_an_azimuth_thruster_has_the_part_of_the_speed_where_it_points() -> None:
    """At 60 deg half of it; where the sensor is lost, all of it."""
    content = load_vessel("ukwial_azimuth").model_dump()
    turning = [j for j, thruster in enumerate(content["thrusters"]) if thruster["type"] == "azimuth"]
    for thruster in content["thrusters"]:
        thruster["drive"] = STRAIGHT.model_dump()["thrusters"][0]["drive"]
    vessel = Vessel.model_validate(content)
    n = len(vessel.thrusters)
    drivers = Drivers(vessel, COMPENSATED)
    azimuth = np.full(n, math.radians(60.0))
    azimuth[turning[0]] = math.nan
    inputs = DriverInputs(np.full(n, 20.0), azimuth, 0.0, np.zeros(n), np.zeros(n), azimuth, surge_speed=2.0)
    inputs = replace(inputs, azimuth_command=np.zeros(n))
    for _ in range(200):
        output = drivers.step(inputs, H)
    assert output.code[turning[0]] == CODE.code(20.0, 2.0)
    assert [output.code[j] for j in turning[1:]] == [CODE.code(20.0, 1.0)] * (len(turning) - 1)
