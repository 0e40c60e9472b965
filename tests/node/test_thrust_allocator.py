"""The allocator's node over real DDS: what it answers, refuses, and says of itself."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest
from dp_msgs.msg import AllocationStatus, ThrusterCommand, ThrusterFeedback
from geometry_msgs.msg import WrenchStamped

from dp_node import from_nanoseconds, to_nanoseconds
from marine_model import load_vessel
from marine_model.errors import InputError
from support.node_bench import NodeBench, node_bench
from thrust_allocator import Allocator, AllocatorSettings
from thrust_allocator.node import AllocatorNode

pytestmark = pytest.mark.usefixtures("ros_domain_id")

VESSEL = load_vessel("cybership3")
NAMES = list(VESSEL.thruster_names)
STEP = 200_000_000  # ns
START = 7_000_000_000
TAU = (3.0, 1.0, 0.5)


class Bench:
    """The node on its bench, with the demands and answers of this package."""

    def __init__(self, bench: NodeBench) -> None:
        self.bench = bench
        self.commands = bench.hear(ThrusterCommand, "thruster_command")
        self.achieved = bench.hear(WrenchStamped, "tau_achieved")
        self.statuses = bench.hear(AllocationStatus, "allocation_status")
        self.demands = bench.publisher(WrenchStamped, "tau_desired")

    def send(self, stamp: int, tau: tuple[float, float, float] = TAU, frame: str = "base_link_frd") -> None:
        message = WrenchStamped()
        message.header.stamp = from_nanoseconds(stamp)
        message.header.frame_id = frame
        message.wrench.force.x, message.wrench.force.y, message.wrench.torque.z = tau
        self.demands.publish(message)

    def ask(self, stamp: int, tau: tuple[float, float, float] = TAU) -> tuple[Any, Any, Any]:
        """Send a demand and return command, achieved force and status that answer it."""
        count = len(self.statuses) + 1
        self.send(stamp, tau)
        self.bench.wait_until(
            lambda: min(len(self.commands), len(self.achieved), len(self.statuses)) >= count, "three answers"
        )
        return self.commands[-1], self.achieved[-1], self.statuses[-1]

    def refused(self, count: int) -> str:
        """Wait until ``count`` inputs have been refused; return the reason of the last, and see it counted."""
        node = self.bench.node
        self.bench.wait_until(lambda: node._refused >= count, f"{count} refusals")
        assert self.bench.diagnostics()["refused_inputs"] == str(count)
        return node._last_refusal


@pytest.fixture
def start() -> Iterator[Any]:
    with ExitStack() as stack:
        yield lambda **parameters: Bench(stack.enter_context(node_bench(AllocatorNode, **parameters)))


def core(mode: str) -> Allocator:
    return Allocator(VESSEL, AllocatorSettings.for_vessel(VESSEL, azimuth_mode=mode))


def test_answers_are_the_core_s_with_the_demand_s_stamp(start: Any) -> None:
    bench, expected = start(azimuth_mode="rotating"), core("rotating")
    for k in range(5):
        stamp = START + k * STEP
        command, achieved, status = bench.ask(stamp)
        result = expected.step(TAU, 0.2)
        for message in (command, achieved, status):
            assert to_nanoseconds(message.header.stamp) == stamp
            assert message.header.frame_id == "base_link_frd"
        assert list(command.name) == NAMES
        np.testing.assert_array_equal(command.thrust, result.thrust)
        np.testing.assert_array_equal(command.azimuth, result.azimuth)
        found = [achieved.wrench.force.x, achieved.wrench.force.y, achieved.wrench.torque.z]
        np.testing.assert_array_equal(found, result.tau_achieved)
        assert (status.status, status.azimuth_mode, status.solver) == ("optimal", "rotating", "active_set")
        np.testing.assert_array_equal(status.slack, result.slack)
        assert status.cost == result.cost
        assert status.demanded_power == result.demanded_power
        assert tuple(status.rotating) == (False, True, True, True)
        assert tuple(status.thrust_saturated) == result.thrust_saturated
        assert tuple(status.azimuth_saturated) == result.azimuth_saturated
    health = bench.bench.diagnostics()
    assert (health["level"], health["message"]) == (0, "nominal")
    assert (health["demands"], health["steps_optimal"], health["steps_hold"]) == ("5", "5", "0")
    assert 0.0 < float(health["solve_time_mean_us"]) <= float(health["solve_time_max_us"])
    assert bench.bench.diagnostics()["message"] == "no tau_desired: no thruster_command"  # none since the last


def test_time_step_is_the_difference_of_stamps_and_limited_after_a_gap(start: Any) -> None:
    bench, expected = start(), core("fixed")
    stamp = START
    expected.step(TAU, 0.2)
    bench.ask(stamp)
    for dt in (0.1, 0.25, 30.0):
        stamp += round(dt * 1e9)
        tau = (60.0, 0.0, 0.0)
        command, _, _ = bench.ask(stamp, tau)
        np.testing.assert_allclose(command.thrust, expected.step(tau, min(dt, 0.3)).thrust, atol=1e-12)


def test_parameters_act_from_the_next_demand(start: Any) -> None:
    bench = start(azimuth_mode="fixed")
    assert not any(bench.ask(START)[2].rotating)
    assert bench.bench.set_parameters(azimuth_mode="rotating", solver="osqp").successful
    _, _, status = bench.ask(START + STEP)
    assert (status.azimuth_mode, status.solver, tuple(status.rotating)) == (
        "rotating",
        "osqp",
        (False, True, True, True),
    )
    assert bench.bench.set_parameters(thruster_enabled=[True, True, False, True]).successful
    for k in range(2, 8):
        command, _, status = bench.ask(START + k * STEP)
    assert command.thrust[2] == 0.0
    assert status.status == "optimal"


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"solver": "magic"}, "solver: expected one of active_set, daqp, "),
        ({"azimuth_mode": "sideways"}, "azimuth_mode: Input should be 'fixed', 'rotating', 'variable' or 'auto'"),
        ({"thrust_limit_scale": [1.0, 1.0, 1.0, 1.5]}, "thrust_limit_scale.3"),
        ({"thruster_enabled": [True, False]}, "thruster_enabled: expected 4 elements"),
        ({"azimuth_mode": "rotating", "solver": "magic"}, "solver: expected one of active_set, daqp, "),
        ({"initial_azimuth": "feedback"}, "read-only"),
    ],
)
def test_bad_parameters_are_refused_whole(start: Any, values: dict[str, Any], reason: str) -> None:
    bench = start()
    answer = bench.bench.set_parameters(**values)
    assert not answer.successful
    assert reason in answer.reason
    status = bench.ask(START)[2]
    assert (status.azimuth_mode, status.solver, status.status) == ("fixed", "active_set", "optimal")


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"solver": "magic"}, "solver: expected one of active_set, daqp, "),
        ({"initial_azimuth": "north"}, "initial_azimuth: expected one of vessel, feedback, found 'north'"),
        ({"azimuth_enabled": [True]}, "azimuth_enabled: expected 4 elements"),
    ],
)
def test_bad_parameters_at_start_up_are_refused(start: Any, parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        start(**parameters)


def test_a_demand_that_is_not_finite_is_answered_by_the_last_good_one(start: Any) -> None:
    bench, expected = start(), core("fixed")
    bench.ask(START)
    expected.step(TAU, 0.2)
    command, achieved, status = bench.ask(START + STEP, (math.nan, 0.0, math.inf))
    result = expected.step(TAU, 0.2)
    assert status.status == "demand_not_finite"
    np.testing.assert_array_equal(command.thrust, result.thrust)
    assert achieved.wrench.force.x == result.tau_achieved[0]
    health = bench.bench.diagnostics()
    assert health["level"] == 1
    assert "expected finite numbers, found [nan, 0.0, inf]" in health["message"]
    assert health["steps_demand_not_finite"] == "1"
    assert bench.ask(START + 2 * STEP)[2].status == "optimal"
    assert bench.bench.diagnostics()["level"] == 0


def test_stamps_that_jump_back_and_other_frames_are_refused(start: Any) -> None:
    bench = start()
    bench.ask(START + STEP)
    bench.send(START)
    assert "tau_desired: expected a time stamp after 7.200 s, found 7.000 s" in bench.refused(1)
    bench.send(START + STEP)  # repeats
    bench.refused(2)
    bench.send(START + 2 * STEP, frame="map_ned")
    assert "tau_desired: expected frame_id 'base_link_frd', found 'map_ned'" in bench.refused(3)
    assert len(bench.commands) == 1
    bench.ask(START + 2 * STEP)
    assert to_nanoseconds(bench.commands[-1].header.stamp) == START + 2 * STEP
    assert len(bench.commands) == 2


def test_all_thrusters_lost_is_an_error_with_a_command(start: Any) -> None:
    bench = start(thruster_enabled=[False] * 4)
    command, achieved, status = bench.ask(START)
    assert status.status == "no_thruster"
    assert list(command.thrust) == [0.0] * 4
    assert achieved.wrench.force.x == 0.0
    np.testing.assert_array_equal(status.slack, TAU)
    assert bench.bench.diagnostics()["level"] == 2


def test_initial_azimuth_from_feedback(start: Any) -> None:
    bench = start(initial_azimuth="feedback", azimuth_mode="rotating")
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")
    bench.send(START)
    bench.refused(1)
    assert bench.bench.diagnostics()["message"] == "no thruster_feedback yet: demands are refused"
    assert bench.commands == []

    azimuth, shaft_speed = [math.pi / 2, 0.3, -2.0, 3.0], [0.0, 5.0, 8.0, 0.0]
    message = ThrusterFeedback(name=NAMES[::-1], azimuth=azimuth[::-1], shaft_speed=[math.nan] * 4)
    feedback.publish(message)
    assert "thruster_feedback: shaft_speed: expected finite numbers" in bench.refused(2)
    message.shaft_speed = shaft_speed[::-1]
    message.name = [*NAMES[:3], "rudder"]
    feedback.publish(message)
    assert "thruster_feedback: expected the thrusters" in bench.refused(3)
    message.name = NAMES[::-1]  # any order
    feedback.publish(message)
    bench.bench.wait_until(lambda: not bench.bench.node._waiting, "feedback taken")

    thrust = VESSEL.propellers.thrust(np.array(shaft_speed))
    expected = Allocator(VESSEL, AllocatorSettings(azimuth_mode="rotating"), thrust, azimuth)
    command, _, _ = bench.ask(START)
    result = expected.step(TAU, 0.2)
    np.testing.assert_array_equal(command.azimuth, result.azimuth)
    np.testing.assert_array_equal(command.thrust, result.thrust)


def test_activated_again_it_starts_without_thrust_where_the_thrusters_point(start: Any) -> None:
    bench = start(azimuth_mode="rotating")
    for k in range(10):
        command, _, _ = bench.ask(START + k * STEP)
    node = bench.bench.node
    node.trigger_deactivate()
    node.trigger_activate()
    expected = Allocator(VESSEL, AllocatorSettings(azimuth_mode="rotating"), azimuth=command.azimuth)
    again, _, _ = bench.ask(START)  # a new time line
    result = expected.step(TAU, 0.2)
    np.testing.assert_array_equal(again.thrust, result.thrust)
    np.testing.assert_allclose(again.azimuth, result.azimuth, atol=1e-15)
