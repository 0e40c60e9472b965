"""Heave, roll and pitch: the loop against its closed form, switches, limits, set points, axes that are not there."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from dp_controller import Controller, ControllerInputs, ControllerOutput, ControllerSettings
from dp_controller.node_health import Tally, health_of
from dp_controller.vertical import VerticalController, VerticalInputs, VerticalOutput
from marine_model import Vessel, load_vessel
from marine_model.axes import VERTICAL
from marine_model.errors import InputError
from marine_model.vertical import VerticalControllerGains, VerticalReferenceGains

DT = 0.2
GAINS = VerticalControllerGains(
    proportional=(20.0, 5.0, 18.0),
    integral=(1.0, 0.8, 2.5),
    derivative=(120.0, 8.0, 60.0),
    reference=VerticalReferenceGains(frequency=0.3, damping=1.0, velocity_max=(0.2, 0.1, 0.1)),
)
AXIS_MODES = ("off", "joystick", "automatic")
AUTOMATIC = {f"axis_{axis}": "automatic" for axis in VERTICAL}
STICK = (30.0, -2.0, 5.0)
# Sums of a few numbers below 100.
CONTINUITY = 1e-12


def chosen(vertical: dict[str, Any] | None = None, **settings: Any) -> ControllerSettings:
    return ControllerSettings.model_validate({"mode": "semi_automatic", "vertical": vertical or AUTOMATIC} | settings)


class Loop:
    """A vertical controller, fed with what the test says, and an allocator that grants everything up to a limit."""

    def __init__(self, settings: ControllerSettings, limit: float = math.inf) -> None:
        self.controller = VerticalController(GAINS, VERTICAL, settings)
        self.limit = limit
        self.position, self.velocity, self.achieved = np.zeros(3), np.zeros(3), np.zeros(3)
        self.valid = True
        self.time = 0.0

    def step(self, dt: float = DT) -> VerticalOutput:
        inputs = VerticalInputs(self.position, self.velocity, self.achieved) if self.valid else None
        output = self.controller.step(inputs, self.time, dt, dt)
        self.time += dt
        self.achieved = np.clip(output.tau_desired, -self.limit, self.limit)
        return output

    def run(self, steps: int) -> VerticalOutput:
        for _ in range(steps):
            output = self.step()
        return output

    def wander(self) -> None:
        """Be somewhere else."""
        t = self.time
        self.position = np.array([5.0 + 0.3 * math.sin(0.1 * t), 0.1 * math.cos(0.2 * t), 0.05 * math.sin(0.3 * t)])
        self.velocity = np.array([0.03 * math.cos(0.1 * t), -0.02 * math.sin(0.2 * t), 0.015 * math.cos(0.3 * t)])


# The loop -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_loop_is_its_closed_form(axis: int) -> None:
    """Mass, damping, stiffness, a force that nobody knows, PID with the reference at rest: one linear recursion."""
    m, d, k = (320.0, 20.0, 110.0)[axis], (60.0, 4.0, 40.0)[axis], (0.0, 10.0, 33.0)[axis]
    unknown = (-8.0, 0.3, 0.5)[axis]
    plant = np.zeros((3, 3))
    plant[0, 1], plant[1] = 1.0, (-k / m, -d / m, 1.0 / m)
    hold = expm(plant * DT)  # of x, v and a held force
    kp, ki, kd = GAINS.proportional[axis], GAINS.integral[axis], GAINS.derivative[axis]
    loop = Loop(chosen())
    loop.step()  # at rest: takes over the present position
    # Of (x, v, I) at a sample and 1: the integral is advanced by the error of this sample before it is used.
    advance = np.eye(4)
    advance[2, 0] = -ki * DT
    demand = np.array([-kp, -kd, 1.0, 0.0])
    move = np.eye(4)
    move[:2, :2] = hold[:2, :2]
    move[:2] += np.outer(hold[:2, 2], demand)
    move[:2, 3] += hold[:2, 2] * unknown
    expected, state = np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(2)
    for _ in range(1500):
        loop.position[axis], loop.velocity[axis] = state
        output = loop.step()
        expected = advance @ expected
        assert output.tau_desired[axis] == pytest.approx(demand @ expected, abs=1e-9)  # rounding of 1500 steps
        expected = move @ expected
        state = hold[:2, :2] @ state + hold[:2, 2] * (output.tau_desired[axis] + unknown)
        loop.position, loop.velocity = np.zeros(3), np.zeros(3)
    # 300 s, of which the integral needs some 20 s a factor e: nothing is left but it.
    assert abs(state[0]) < 1e-6
    assert output.integral[axis] == pytest.approx(-unknown, rel=1e-4)


def test_reference_is_a_second_order_filter_below_its_velocity_limit() -> None:
    loop = Loop(chosen())
    loop.position = np.array([5.0, 0.0, 0.0])
    loop.step()
    target = np.array([6.0, -0.2, 0.1])  # at most 2 z v_max / w away: 1.33 m, 0.67 rad
    loop.controller.set_setpoint((6.0, -0.2, 0.1))
    for k in range(1, 100):
        output = loop.step()
        t = 0.3 * DT * k
        expected = target + (loop.position - target) * (1.0 + t) * math.exp(-t)
        # The sample that takes the set point moves at once.
        np.testing.assert_allclose(output.reference, expected, atol=1e-12)
        np.testing.assert_allclose(output.error, output.reference - loop.position, atol=1e-12)


def test_every_axis_keeps_its_velocity_limit_for_itself() -> None:
    loop = Loop(chosen(AUTOMATIC | {"velocity_scale": [0.5, 1.0, 1.0]}))
    loop.step()
    loop.controller.set_setpoint((10.0, 0.0, 3.0))
    references = np.array([loop.step().reference for _ in range(200)])
    speeds = np.abs(np.diff(references, axis=0)).max(axis=0) / DT
    # Approached from below, within 1 - exp(-0.6 t).
    np.testing.assert_allclose(speeds, [0.1, 0.0, 0.1], rtol=1e-3, atol=1e-12)


def test_angles_go_the_shorter_way() -> None:
    loop = Loop(chosen())
    loop.position = np.array([0.0, 3.1, 0.0])
    loop.step()
    loop.controller.set_setpoint((0.0, -3.1, 0.0))
    output = loop.run(200)
    assert output.reference[1] == pytest.approx(-3.1, abs=1e-4)
    assert output.error[1] == pytest.approx(2.0 * (math.pi - 3.1), abs=1e-4)


# Switches -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("before", "after"), list(itertools.permutations(AXIS_MODES, 2)))
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_every_switch_is_bumpless(axis: int, before: str, after: str) -> None:
    loop = Loop(chosen(AUTOMATIC | {f"axis_{VERTICAL[axis]}": before}))
    output = loop.step()
    for _ in range(60):
        loop.controller.set_joystick(STICK, loop.time)
        loop.wander()
        output = loop.step()
    last = output.tau_desired[axis]
    loop.controller.apply(chosen(AUTOMATIC | {f"axis_{VERTICAL[axis]}": after}))
    for k in range(40):
        loop.controller.set_joystick(STICK, loop.time)
        loop.wander()
        output = loop.step()
        parts = output.proportional + output.integral + output.derivative + output.joystick + output.transfer
        np.testing.assert_allclose(parts, output.tau_desired, atol=CONTINUITY)
        if k == 0:
            offset = output.transfer[axis]
            assert output.axis_mode[axis] == after
            assert output.tau_desired[axis] == pytest.approx(last, abs=CONTINUITY)
        # What is left of the step fades in a straight line within 5 s.
        assert output.transfer[axis] == pytest.approx(offset * max(0.0, 1.0 - k * DT / 5.0), abs=1e-9)


@pytest.mark.parametrize(
    "change",
    [
        {"vertical": AUTOMATIC | {"proportional_scale": [2.0, 2.0, 2.0]}},
        {"vertical": AUTOMATIC | {"derivative_scale": [0.0, 0.0, 0.0]}},
        {"velocity_feedback": "error"},
    ],
)
def test_a_change_of_the_law_is_bumpless(change: dict[str, Any]) -> None:
    loop = Loop(chosen())
    for k in range(61):
        before = loop.achieved
        if k == 60:
            loop.controller.apply(chosen(**change))
        loop.wander()
        if k == 40:
            loop.controller.set_setpoint((5.5, 0.0, 0.1))
        output = loop.step()
    assert np.abs(output.transfer).max() > 1e-3  # there was something to bridge
    np.testing.assert_allclose(output.tau_desired, before, atol=CONTINUITY)


def test_without_an_estimate_the_integral_holds_and_the_target_stays() -> None:
    loop = Loop(chosen())
    loop.position = np.array([5.0, 0.0, 0.0])
    loop.step()
    loop.controller.set_setpoint((5.5, 0.0, 0.0))
    before = loop.run(50)
    loop.valid = False
    first = loop.step()
    np.testing.assert_allclose(first.tau_desired, before.tau_desired, atol=CONTINUITY)
    lost = loop.run(30)  # beyond the transfer time
    np.testing.assert_allclose(lost.tau_desired, lost.integral, atol=CONTINUITY)
    np.testing.assert_array_equal(lost.integral, first.integral)
    loop.valid = True
    back = loop.run(400)
    assert back.reference[0] == pytest.approx(5.5, abs=1e-6)


def test_an_axis_that_became_automatic_without_an_estimate_holds_where_it_is_found() -> None:
    loop = Loop(chosen())
    loop.valid = False
    loop.run(3)
    loop.valid = True
    loop.position = np.array([7.0, 0.1, -0.1])
    output = loop.run(20)
    np.testing.assert_allclose(output.reference, loop.position, atol=1e-12)
    np.testing.assert_allclose(output.tau_desired, 0.0, atol=1e-12)


# Limits -------------------------------------------------------------------------------------------------------------


def wind_up(anti_windup_time: float) -> VerticalOutput:
    loop = Loop(chosen(anti_windup_time=anti_windup_time), limit=10.0)
    loop.step()
    loop.position = np.array([-2.0, 0.0, 0.0])  # 40 N of proportional force where 10 N can be had
    return loop.run(1000)


def test_the_integral_gives_way_to_thrusters_that_saturate() -> None:
    # 200 s of 2 N/s; with back-calculation the integral rests where K_I e = excess / T, on the sample.
    assert wind_up(0.0).integral[0] == pytest.approx(400.0, rel=0.01)
    output = wind_up(20.0)
    share = -math.expm1(-DT / 20.0)
    excess = 2.0 * DT / share
    assert output.tau_desired[0] - 10.0 == pytest.approx(excess, rel=1e-3)


def test_demands_are_limited_and_the_limit_does_not_wind_up() -> None:
    loop = Loop(chosen(AUTOMATIC | {"tau_max": [10.0, 0.0, 0.0]}))
    loop.step()
    loop.position = np.array([-2.0, 0.5, 0.0])
    output = loop.run(1000)
    assert output.tau_desired[0] == 10.0
    assert output.integral[0] < 50.0
    assert output.tau_desired[1] < -2.5  # 0: no limit


# Operator -----------------------------------------------------------------------------------------------------------


class Vehicle:
    """A controller of a shipped vehicle that stays where the test puts it."""

    def __init__(self, vessel: Vessel, **settings: Any) -> None:
        base = ControllerSettings.for_vessel(vessel).model_dump()
        vertical = base["vertical"] | settings.pop("vertical", {})
        self.controller = Controller(
            vessel, ControllerSettings.model_validate(base | settings | {"vertical": vertical})
        )
        self.place = np.array([5.0, 0.05, -0.05])

    def step(self, valid: bool = True) -> ControllerOutput:
        below = VerticalInputs(self.place, np.zeros(3), np.zeros(3))
        return self.controller.step(ControllerInputs(np.zeros(3), np.zeros(3), np.zeros(3), valid, None, below), DT)

    def change(self, **settings: Any) -> None:
        base = self.controller.settings.model_dump()
        vertical = base["vertical"] | settings.pop("vertical", {})
        self.controller.apply(ControllerSettings.model_validate(base | settings | {"vertical": vertical}))


MMT300, UKWIAL = load_vessel("mmt300"), load_vessel("ukwial")
SETPOINT = [1.0, 2.0, 6.0, 0.1, 0.2, 0.3]


def below(output: ControllerOutput) -> VerticalOutput:
    assert output.vertical is not None
    return output.vertical


@pytest.mark.parametrize(
    ("vessel", "plane", "vertical"),
    [
        (MMT300, ("automatic", "off", "automatic"), ("automatic", "off", "automatic")),
        (UKWIAL, ("automatic", "automatic", "automatic"), ("automatic", "off", "off")),
    ],
)
def test_a_mode_for_all_axes_is_for_those_that_the_vehicle_has(
    vessel: Vessel, plane: tuple[str, ...], vertical: tuple[str, ...]
) -> None:
    vehicle = Vehicle(vessel, mode="setpoint")
    vehicle.step()
    vehicle.controller.set_setpoint([1.0, 2.0, 6.0, 0.3, 0.3, 0.3])
    for _ in range(50):
        output = vehicle.step()
    assert output.axis_mode == vehicle.controller.axis_modes == plane
    assert below(output).axis_mode == vehicle.controller.vertical_modes == vertical
    for axis, mode in zip((0, 1, 2), plane, strict=True):
        assert (output.tau_desired[axis] != 0.0) == (mode == "automatic")
    for axis, mode in zip((0, 1, 2), vertical, strict=True):
        assert (below(output).tau_desired[axis] != 0.0) == (mode == "automatic")
    assert vehicle.controller.message.endswith("0.3000 rad")  # no axis is left out


@pytest.mark.parametrize(
    ("vessel", "changes", "found"),
    [
        (MMT300, {"axis_sway": "joystick"}, "axis_sway: expected off, because vessel 'mmt300' controls surge, heave"),
        (MMT300, {"vertical": {"axis_roll": "automatic"}}, "vertical.axis_roll: expected off"),
        (UKWIAL, {"vertical": {"axis_pitch": "automatic"}}, "vertical.axis_pitch: expected off"),
        (load_vessel("cybership3"), {"vertical": {"axis_heave": "automatic"}}, "vertical.axis_heave: expected off"),
    ],
)
def test_axes_that_the_vessel_has_not_are_refused(vessel: Vessel, changes: dict[str, Any], found: str) -> None:
    with pytest.raises(InputError, match=found):
        Vehicle(vessel, **changes)
    vehicle = Vehicle(vessel)
    before = vehicle.controller.settings
    with pytest.raises(InputError, match=found):
        vehicle.change(**changes)
    assert vehicle.controller.settings is before


def test_a_vessel_on_the_surface_has_no_vertical_part() -> None:
    controller = Controller(load_vessel("cybership3"))
    output = controller.step(ControllerInputs(np.zeros(3), np.zeros(3)), DT)
    assert output.vertical is None
    assert controller.vertical_modes is None


def test_a_set_point_waits_for_an_axis_and_is_used_once_by_all() -> None:
    vehicle = Vehicle(MMT300, mode="standby")
    vehicle.step()
    vehicle.controller.set_setpoint(SETPOINT)
    assert vehicle.controller.message.endswith("waits for an automatic axis")
    vehicle.step()
    # Heave follows; what the set point has for the other axes is dropped, in whatever plane they are.
    off = {"axis_surge": "off", "axis_yaw": "off"}
    vehicle.change(mode="semi_automatic", **off, vertical={"axis_pitch": "off"})
    for _ in range(400):
        output = vehicle.step()
    assert below(output).reference[0] == pytest.approx(6.0, abs=1e-4)  # 80 s at 0.2 rad/s: 17 exp(-16)
    vehicle.change(axis_surge="automatic", axis_yaw="automatic", vertical={"axis_pitch": "automatic"})
    for _ in range(400):
        output = vehicle.step()
    np.testing.assert_allclose(output.reference_position, 0.0, atol=1e-9)
    assert below(output).reference[2] == pytest.approx(-0.05, abs=1e-9)


def test_a_set_point_that_the_plane_follows_is_dropped_below() -> None:
    vehicle = Vehicle(MMT300, mode="semi_automatic", vertical={"axis_heave": "off", "axis_pitch": "off"})
    vehicle.step()
    vehicle.controller.set_setpoint(SETPOINT)
    assert vehicle.controller.message.endswith("for yaw only")
    vehicle.step()
    vehicle.change(vertical={"axis_heave": "automatic"})
    for _ in range(200):
        output = vehicle.step()
    assert below(output).reference[0] == pytest.approx(5.0, abs=1e-9)


def test_depth_follows_a_set_point_on_a_path() -> None:
    vehicle = Vehicle(MMT300, mode="tracking")
    vehicle.controller.set_path([0.0, 1.0], [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    vehicle.step()
    vehicle.controller.set_setpoint(SETPOINT)
    assert vehicle.controller.message.endswith("for heave, pitch; the rest waits for the end of mode tracking")
    for _ in range(400):
        output = vehicle.step()
    assert below(output).reference[0] == pytest.approx(6.0, abs=1e-4)  # 80 s at 0.2 rad/s: 17 exp(-16)
    assert output.reference_position[0] == pytest.approx(0.0, abs=1e-9)
    vehicle.change(mode="setpoint")
    for _ in range(400):
        output = vehicle.step()
    assert output.reference_position[0] == pytest.approx(1.0, abs=0.1)  # along the heading that turns


def test_a_joystick_moves_what_is_manual_and_a_stale_one_is_told() -> None:
    vehicle = Vehicle(MMT300, mode="semi_automatic", axis_surge="automatic", vertical={"axis_heave": "joystick"})
    vehicle.step()
    vehicle.controller.set_joystick([1.0, 2.0, 30.0, 4.0, 5.0, 6.0])
    output = vehicle.step()
    assert below(output).joystick.tolist() == [30.0, 0.0, 0.0]
    assert output.joystick.tolist() == [0.0, 0.0, 0.0]
    for _ in range(11):  # 2 s of timeout
        output = vehicle.step()
    assert output.status == "joystick_stale"
    for _ in range(26):
        output = vehicle.step()
    assert below(output).tau_desired[0] == 0.0


@pytest.mark.parametrize(
    ("call", "value", "found"),
    [
        ("set_setpoint", [1.0, 2.0, 3.0], "set point: expected shape"),
        ("set_setpoint", [1.0, 2.0, math.nan, 0.0, 0.0, 0.0], "set point: expected finite"),
        ("set_joystick", [1.0, 2.0, 3.0], "joystick: expected shape"),
        ("set_joystick", [0.0, 0.0, math.inf, 0.0, 0.0, 0.0], "joystick: expected finite"),
    ],
)
def test_bad_operator_input_is_refused(call: str, value: list[float], found: str) -> None:
    vehicle = Vehicle(UKWIAL, mode="setpoint")
    vehicle.step()
    with pytest.raises(InputError, match=found):
        getattr(vehicle.controller, call)(value)
    assert vehicle.controller.message.startswith(f"refused: {found.partition(':')[0]}")
    assert below(vehicle.step()).reference[0] == 5.0


def test_bad_estimates_are_refused_and_change_nothing() -> None:
    vehicle, plain = Vehicle(UKWIAL, mode="setpoint"), Vehicle(UKWIAL, mode="setpoint")
    for one in (vehicle, plain):
        one.step()
        one.place = np.array([5.5, 0.0, 0.0])
    nowhere = ControllerInputs(np.zeros(3), np.zeros(3), None, True)
    with pytest.raises(InputError, match="expected an estimate for a submerged vehicle, found none"):
        vehicle.controller.step(nowhere, DT)
    for place in (np.zeros(2), np.array([np.nan, 0.0, 0.0])):
        wrong = VerticalInputs(place, np.zeros(3))
        with pytest.raises(InputError, match="depth, roll and pitch: expected"):
            vehicle.controller.step(ControllerInputs(np.zeros(3), np.zeros(3), None, True, None, wrong), DT)
    np.testing.assert_array_equal(below(vehicle.step()).tau_desired, below(plain.step()).tau_desired)


# Health -------------------------------------------------------------------------------------------------------------


def test_depth_error_is_told_and_an_alarm_beyond_its_limit() -> None:
    tally = Tally()
    tally.acted("nominal", (0.0, 0.0, 0.0), [-0.3, 0.01, 0.02])
    health = health_of(tally, chosen({"depth_alarm": 0.5}))
    assert (health.values["depth_error_m"], health.values["pitch_error_rad"]) == (-0.3, 0.02)
    assert health.alarms == ()
    health = health_of(tally, chosen({"depth_alarm": 0.2}))
    assert [alarm.kind.code for alarm in health.alarms] == ["CONTROLLER-DEPTH-ERROR"]
    tally.acted("nominal", (0.0, 0.0, 0.0))
    assert "depth_error_m" not in health_of(tally, chosen()).values
