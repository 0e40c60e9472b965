"""Tracking of timed paths, and holding station, in closed loop with a linear VESSEL."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dp_controller import Controller, ControllerInputs, ControllerSettings
from support.controller_rig import VESSEL, basin, rig

DT = 0.2


def straight(seconds: float, speed: float, heading: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    times = np.linspace(0.0, seconds, 21)
    along = np.column_stack((np.cos(heading) * speed * times, np.sin(heading) * speed * times, 0 * times + heading))
    return times, along


def test_straight_path_is_tracked_without_steady_velocity_error() -> None:
    controller = Controller(VESSEL, ControllerSettings(mode="tracking"))
    controller.set_path(*straight(400.0, 0.05, heading=0.7))
    ship = basin(force=[1.0, -0.5, 0.1])
    ship.position = np.array([0.0, 0.0, 0.7])
    outputs = ship.sail(controller, 360.0)
    # The integral settles with a time constant of K_P / K_I = 25 s: e^-13 of centimetres after 330 s.
    assert ship.velocity == pytest.approx([0.05, 0.0, 0.0], abs=1e-5)
    assert outputs[-1].error == pytest.approx([0.0, 0.0, 0.0], abs=1e-5)
    assert outputs[-1].reference_velocity == pytest.approx([0.05, 0.0, 0.0], abs=1e-12)
    # Reference and path are one.
    expected = 0.05 * controller.time * np.array([math.cos(0.7), math.sin(0.7)])
    assert outputs[-1].reference_position[:2] == pytest.approx(expected, abs=1e-9)


def test_first_pose_is_held_before_the_start_and_the_last_after_the_end() -> None:
    ship = rig(mode="tracking")
    ship.controller.set_path([10.0, 40.0], [[0.0, 0.0, 0.0], [1.0, 0.5, 0.3]])
    for _ in range(50):  # 0 s ... 9.8 s
        output = ship.step()
        assert output.reference_position == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    ship.run(76)  # to 25.0 s, half of the way
    assert ship.controller.time == pytest.approx(25.0)
    output = ship.step()
    assert 0.5 < output.reference_position[0] < 0.52
    output = ship.run(400)
    assert output.reference_position == pytest.approx([1.0, 0.5, 0.3], abs=1e-9)
    assert output.reference_velocity == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


def test_path_is_joined_from_the_present_position_within_the_velocity_limits() -> None:
    ship = rig(mode="setpoint")
    ship.position = np.array([-1.0, 2.0, 3.0])
    ship.step()
    ship.controller.set_path(*straight(400.0, 0.03, heading=-3.0))
    ship.change(mode="tracking")
    before = ship.position
    for _ in range(600):
        output = ship.step()
        moved = output.reference_position - before
        before = output.reference_position
        assert np.abs(output.reference_velocity).max() <= 0.1 + 1e-12
        assert math.hypot(moved[0], moved[1]) <= 0.1 * math.sqrt(2.0) * DT + 1e-12
    along = 0.03 * ship.controller.time
    assert output.reference_position == pytest.approx([along * math.cos(3.0), -along * math.sin(3.0), -3.0], abs=1e-9)


def test_four_full_turns_can_be_sailed_as_a_path() -> None:
    """The manoeuvre of [Ruth] Run E: the heading is not wrapped on the way."""
    ship = rig(mode="tracking")
    headings = np.arange(0.0, 8 * math.pi + 0.1, math.pi / 4)
    times = headings / 0.05
    wrapped = [math.remainder(h, 2 * math.pi) for h in headings]
    ship.controller.set_path(times, [[0.0, 0.0, h] for h in wrapped])
    turned = 0.0
    while ship.controller.time < times[-1] + 20.0:
        output = ship.step()
        ship.position = output.reference_position
        turned += output.reference_velocity[2] * DT
    assert turned == pytest.approx(8 * math.pi, abs=0.01)  # sum of rates for an integral


def test_new_path_is_joined_smoothly() -> None:
    ship = rig(mode="tracking")
    ship.controller.set_path(*straight(100.0, 0.05))
    ship.run(100)
    before = ship.step().reference_velocity
    times, positions = straight(100.0, 0.05, heading=0.5)
    ship.controller.set_path(times + 30.0, positions + np.array([3.0, 3.0, 0.0]))
    # The reference has no step of velocity: acceleration is at most 2 z w times twice the limit of velocity.
    for _ in range(200):
        after = ship.step().reference_velocity
        assert np.abs(after - before).max() <= 2 * 0.5 * 0.2 * DT + 0.1 * 0.1 * DT
        before = after


def test_a_path_faster_than_the_limit_is_caught_up_with() -> None:
    ship = rig(mode="tracking")
    ship.controller.set_path([0.0, 20.0, 21.0], [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [6.0, 0.0, 0.0]])
    assert "the reference will lag" in ship.controller.message
    highest = 0.0
    for _ in range(600):
        output = ship.step()
        assert abs(output.reference_velocity[0]) <= 0.1 + 1e-12
        highest = max(highest, output.reference_position[0])
    assert output.reference_position[0] == pytest.approx(6.0, abs=1e-6)
    assert highest <= 6.0 + 1e-9


def test_station_is_held_against_a_steady_force() -> None:
    controller = Controller(VESSEL, ControllerSettings(mode="setpoint"))
    ship = basin(force=[-4.0, 2.0, 0.3])
    outputs = ship.sail(controller, 300.0)
    assert ship.position == pytest.approx([0.0, 0.0, 0.0], abs=1e-4)
    assert outputs[-1].integral == pytest.approx([4.0, -2.0, -0.3], abs=1e-2)
    assert max(np.abs(output.error[:2]).max() for output in outputs) < 0.08  # 4 N / 75 N/m


def test_set_point_change_in_closed_loop() -> None:
    controller = Controller(VESSEL, ControllerSettings(mode="setpoint"))
    ship = basin()
    ship.sail(controller, 1.0)
    controller.set_setpoint([2.0, -1.0, 0.5])
    ship.sail(controller, 250.0)
    assert ship.position == pytest.approx([2.0, -1.0, 0.5], abs=1e-3)


def test_steps_of_any_length_give_the_same_reference() -> None:
    """Odometry that comes irregularly: the reference depends on time alone, not on the samples."""
    ends = []
    for pattern in ([0.2], [0.1], [0.4, 0.1, 0.3], [2.0]):
        controller = Controller(VESSEL, ControllerSettings(mode="setpoint"))
        at = ControllerInputs(np.zeros(3), np.zeros(3))
        controller.step(at, 0.2)
        controller.set_setpoint([0.2, 0.1, 0.05])
        while controller.time < 8.0 - 1e-9:
            for dt in pattern:
                output = controller.step(at, dt)
        ends.append(output.reference_position)
    for end in ends[1:]:
        assert end == pytest.approx(ends[0], abs=1e-12)  # exact discretisation: rounding only
