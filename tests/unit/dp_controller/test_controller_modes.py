"""Operator modes: what each does, and that no switch makes the demand jump."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from dp_controller import Controller, ControllerInputs, ControllerOutput, ControllerSettings
from marine_model.frames import rotation
from support.controller_rig import VESSEL, rig

MODES = ("standby", "joystick", "setpoint", "semi_automatic", "tracking")
AXIS_MODES = ("off", "joystick", "automatic")
TRANSFER_TIME = 5.0  # s, the default
DT = 0.2
STICK = [3.0, -2.0, 0.5]

# The demand of the first sample after a switch is that of the last before it by construction: sums of a few numbers
# below 100 N, hence 1e-12.
CONTINUITY = 1e-12


def drifting(seed: float = 0.0) -> Iterator[ControllerInputs]:
    """A vessel that moves and turns all the time, and an allocator that falls short now and then."""
    for k in itertools.count():
        t = DT * k + seed
        yield ControllerInputs(
            np.array([0.3 * math.sin(0.1 * t), 0.2 * math.cos(0.13 * t), 3.1 + 0.2 * math.sin(0.2 * t)]),
            np.array([0.03 * math.cos(0.1 * t), -0.02 * math.sin(0.3 * t), 0.04 * math.cos(0.2 * t)]),
            np.array([2.0 * math.sin(t), 1.0, 0.3 * math.cos(0.5 * t)]),
        )


def busy(**settings: Any) -> Controller:
    controller = Controller(VESSEL, ControllerSettings.model_validate(settings))
    controller.set_path([0.0, 20.0, 60.0, 90.0], [[0, 0, 3.0], [1, 0, -3.0], [2, 2, -2.0], [2, 3, -2.0]])
    return controller


def switch(controller: Controller, **changes: Any) -> None:
    controller.apply(ControllerSettings.model_validate(controller.settings.model_dump() | changes))


def parts(output: ControllerOutput) -> np.ndarray:
    total: np.ndarray = output.proportional + output.integral + output.derivative + output.joystick
    return total


def run(controller: Controller, inputs: Iterator[ControllerInputs], steps: int) -> list[ControllerOutput]:
    outputs = []
    for _ in range(steps):
        controller.set_joystick(STICK)
        outputs.append(controller.step(next(inputs), DT))
    return outputs


@pytest.mark.parametrize(("before", "after"), list(itertools.permutations(MODES, 2)))
def test_every_switch_of_mode_is_bumpless(before: str, after: str) -> None:
    controller, inputs = busy(mode=before), drifting()
    unswitched, same_inputs = busy(mode=before), drifting()
    last = run(controller, inputs, 60)[-1]
    run(unswitched, same_inputs, 60)
    switch(controller, mode=after)
    follow = run(controller, inputs, 40)
    assert follow[0].mode == after
    # An axis that stays automatic at a set point is not switched: its demand is that of a controller left alone.
    stays = [
        a == b and "tracking" not in (before, after) for a, b in zip(last.axis_mode, follow[0].axis_mode, strict=True)
    ]
    expected = np.where(stays, run(unswitched, same_inputs, 1)[0].tau_desired, last.tau_desired)
    assert follow[0].tau_desired == pytest.approx(expected, abs=CONTINUITY)
    # What is left of the step fades in a straight line and is gone after the transfer time.
    offset = follow[0].tau_desired - parts(follow[0])
    for k, output in enumerate(follow):
        left = max(0.0, 1.0 - k * DT / TRANSFER_TIME)
        assert output.tau_desired - parts(output) == pytest.approx(offset * left, abs=CONTINUITY)
    assert not follow[-1].transfer.any()


def test_without_transfer_time_the_same_switches_do_jump() -> None:
    jumps = 0
    for before, after in itertools.permutations(MODES, 2):
        controller, inputs = busy(mode=before, transfer_time=0.0), drifting()
        last = run(controller, inputs, 60)[-1]
        switch(controller, mode=after)
        jumps += bool(np.abs(run(controller, inputs, 1)[0].tau_desired - last.tau_desired).max() > 0.3)
    assert jumps >= 15


def test_switching_again_in_the_middle_of_a_transfer_is_bumpless() -> None:
    controller, inputs = busy(), drifting()
    last = run(controller, inputs, 10)[-1]
    for mode in MODES * 3:
        switch(controller, mode=mode)
        if mode == last.mode:
            continue
        output = run(controller, inputs, 1)[0]
        for i in range(3):
            if output.axis_mode[i] != last.axis_mode[i] or "tracking" in (output.mode, last.mode):
                assert output.tau_desired[i] == pytest.approx(last.tau_desired[i], abs=CONTINUITY)
        last = run(controller, inputs, 7)[-1]


@pytest.mark.parametrize("axes", list(itertools.product(AXIS_MODES, repeat=3)))
def test_every_mix_of_axes(axes: tuple[str, str, str]) -> None:
    controller = busy(mode="semi_automatic", axis_surge=axes[0], axis_sway=axes[1], axis_yaw=axes[2], transfer_time=0.0)
    output = run(controller, drifting(), 100)[-1]
    assert output.axis_mode == axes
    for i, axis in enumerate(axes):
        automatic = output.proportional[i] + output.integral[i] + output.derivative[i]
        if axis == "off":
            assert output.tau_desired[i] == 0.0
        elif axis == "joystick":
            assert (output.tau_desired[i], automatic) == (STICK[i], 0.0)
        else:
            assert output.error[i] != 0.0
            assert output.tau_desired[i] == pytest.approx(automatic, abs=CONTINUITY)
            assert output.joystick[i] == 0.0


def test_every_switch_of_axes_is_bumpless() -> None:
    names = ("axis_surge", "axis_sway", "axis_yaw")
    mixes = list(itertools.product(AXIS_MODES, repeat=3))
    controller, inputs = busy(mode="semi_automatic"), drifting()
    last = run(controller, inputs, 40)[-1]
    # Through all mixes and back, with strides that bring every mix after many different ones.
    for stride in (1, 2, 5, 7, 10, 13):
        for k in range(len(mixes)):
            axes = mixes[k * stride % len(mixes)]
            changed = [a != b for a, b in zip(axes, last.axis_mode, strict=True)]
            switch(controller, **dict(zip(names, axes, strict=True)))
            output = run(controller, inputs, 1)[0]
            assert output.tau_desired[changed] == pytest.approx(last.tau_desired[changed], abs=CONTINUITY)
            last = run(controller, inputs, 3)[-1]


def test_standby_asks_for_nothing() -> None:
    ship = rig(mode="standby")
    ship.controller.set_setpoint([1.0, 2.0, 0.3])
    ship.controller.set_joystick(STICK)
    ship.velocity = np.array([0.1, 0.2, 0.3])
    assert not ship.run(10).tau_desired.any()


def test_first_automatic_activation_holds_the_present_position() -> None:
    ship = rig(mode="setpoint")
    ship.position = np.array([3.0, -2.0, 1.0])
    output = ship.run(50)
    assert output.reference_position == pytest.approx(ship.position, abs=1e-12)
    assert not output.tau_desired.any()
    assert output.status == "nominal"


def test_entering_set_point_mode_holds_the_present_position_not_an_old_set_point() -> None:
    ship = rig(mode="setpoint")
    ship.controller.set_setpoint([1.0, 0.0, 0.0])
    ship.run(10)
    ship.change(mode="joystick")
    ship.position = np.array([5.0, 5.0, 1.0])
    ship.run(10)
    ship.change(mode="setpoint")
    assert ship.run(100).reference_position == pytest.approx(ship.position, abs=1e-12)


@pytest.mark.parametrize("mode", ["standby", "joystick"])
def test_a_set_point_given_before_waits_for_the_mode(mode: str) -> None:
    ship = rig(mode=mode)
    ship.run(5)
    ship.controller.set_setpoint([0.2, 0.1, 0.1])
    assert ship.controller.message.endswith("waits for an automatic axis")
    assert ship.run(50).reference_position == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    ship.change(mode="setpoint")
    # Starts from where the vessel is, and goes there as the filter does.
    assert ship.step().reference_position == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert ship.run(300).reference_position == pytest.approx([0.2, 0.1, 0.1], abs=1e-9)


def test_a_set_point_for_one_axis_does_not_wait_for_the_others() -> None:
    """Heading 0.5 rad with automatic yaw alone: (0, 0) must not be sailed to when surge and sway follow later."""
    ship = rig(mode="semi_automatic", axis_yaw="automatic")
    ship.position = np.array([8.0, 3.0, 0.0])
    ship.run(3)
    ship.controller.set_setpoint([0.0, 0.0, 0.5])
    assert ship.controller.message.endswith("for yaw only")
    ship.run(300)
    ship.change(mode="setpoint")
    assert ship.run(300).reference_position == pytest.approx([8.0, 3.0, 0.5], abs=1e-9)


def test_reference_takes_over_the_velocity_of_the_vessel() -> None:
    ship = rig(mode="joystick")
    ship.position, ship.velocity = np.array([0.0, 0.0, math.pi / 2]), np.array([0.05, 0.0, 0.02])
    ship.run(3)
    ship.change(mode="setpoint")
    assert ship.step().reference_velocity == pytest.approx([0.05, 0.0, 0.02], abs=1e-12)


@pytest.mark.parametrize(("start", "goal", "turn"), [(3.0, -3.0, 2 * math.pi - 6.0), (0.1, 6.2, 6.1 - 2 * math.pi)])
def test_heading_goes_the_shorter_way(start: float, goal: float, turn: float) -> None:
    ship = rig(mode="setpoint")
    ship.position = np.array([0.0, 0.0, start])
    ship.step()
    ship.controller.set_setpoint([0.0, 0.0, goal])
    turned = sum(ship.step().reference_velocity[2] * DT for _ in range(400))
    assert turned == pytest.approx(turn, abs=0.01)  # a sum of rates for an integral: rate_max dt / 2


def test_automatic_sway_goes_along_while_surge_is_sailed_by_hand() -> None:
    ship = rig(mode="semi_automatic", axis_surge="joystick", axis_sway="automatic", axis_yaw="joystick")
    for k in range(200):
        heading = 0.01 * k
        ship.position = ship.position + rotation(heading) @ np.array([0.1, 0.0, 0.0])
        ship.position[2] = heading
        output = ship.step()
        # Sailed ahead on a curve: nothing to correct abeam but the turn of one sample, 0.1 m * 0.01 rad, each step.
        assert abs(output.error[1]) < 0.05
    assert np.hypot(*ship.position[:2]) > 15.0
    ship.change(axis_surge="automatic")
    assert ship.step().error[0] == pytest.approx(0.0, abs=1e-12)


def test_automatic_sway_corrects_a_drift_abeam() -> None:
    ship = rig(mode="semi_automatic", axis_surge="joystick", axis_sway="automatic", axis_yaw="automatic")
    ship.position = np.array([4.0, 4.0, 0.7])
    ship.step()
    ship.position = ship.position + rotation(0.7) @ np.array([2.0, 0.3, 0.0])
    assert ship.step().error == pytest.approx([0.0, -0.3, 0.0], abs=1e-12)


def test_gain_change_is_bumpless() -> None:
    controller, inputs = busy(mode="setpoint"), drifting()
    last = run(controller, inputs, 60)[-1]
    for change in (
        {"proportional_scale": (2.0, 2.0, 2.0)},
        {"derivative_scale": (0.5, 0.5, 0.5)},
        {"integral_scale": (0.0, 3.0, 1.0), "velocity_scale": (0.1, 0.1, 0.1)},
        {"velocity_feedback": "error"},
        {"velocity_feedback": "vessel", "integral_scale": (1.0, 1.0, 1.0)},
    ):
        switch(controller, **change)
        output = run(controller, inputs, 1)[0]
        assert output.tau_desired == pytest.approx(last.tau_desired, abs=CONTINUITY)
        last = run(controller, inputs, 10)[-1]


def test_derivative_term_is_that_of_the_source_unless_told_otherwise() -> None:
    for feedback, reference in (("vessel", 0.0), ("error", 1.0)):
        ship = rig(mode="setpoint", velocity_feedback=feedback)
        ship.step()
        ship.controller.set_setpoint([1.0, 0.0, 0.0])
        ship.velocity = np.array([0.02, 0.0, 0.0])
        output = ship.run(10)
        expected = -98.0 * (0.02 - reference * output.reference_velocity[0])
        assert output.derivative[0] == pytest.approx(expected, abs=1e-12)


def test_demand_stays_within_its_limits() -> None:
    controller, inputs = busy(mode="joystick", tau_max=(1.0, 0.5, 0.0), transfer_time=0.0), drifting()
    output = run(controller, inputs, 5)[-1]
    assert output.tau_desired == pytest.approx([1.0, -0.5, 0.5], abs=0)


def test_leaving_a_path_holds_the_present_position() -> None:
    controller, inputs = busy(mode="tracking"), drifting()
    run(controller, inputs, 100)
    switch(controller, mode="setpoint")
    here = next(inputs)
    controller.step(here, DT)
    still = ControllerInputs(here.position, np.zeros(3), None)
    for _ in range(300):
        output = controller.step(still, DT)
    assert output.reference_position == pytest.approx(here.position, abs=1e-9)
