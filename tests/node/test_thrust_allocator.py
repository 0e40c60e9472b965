"""The allocator's node over real DDS: what it answers, refuses, and says of itself."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dp_msgs.msg import AllocationStatus, ThrusterCommand, ThrusterFeedback, Ventilation
from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.msg import ParameterType
from rclpy.lifecycle import TransitionCallbackReturn

from dp_node import from_nanoseconds, to_nanoseconds
from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angles
from marine_model.settings import parameters_of, with_parameters
from marine_model.thruster_configuration import generalized_force
from support.node_bench import NodeBench, node_bench
from thrust_allocator import AllocationResult, Allocator, AllocatorSettings
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
    for dt in (0.1, 0.25, 1.0):
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
        ({"azimuth_mode": "rotating", "cost": "cubic"}, "cost: Input should be 'quadratic' or 'power_3_2'"),
        (
            {"azimuth_mode": "rotating", "power__limit": "bus", "power__bus_limit": [4.0]},
            "power.bus_limit: expected 2 elements, one a bus of the vessel file, found 1",
        ),
        ({"azimuth_mode": "rotating", "power__bus_limit": [-1.0, 4.0]}, "power.bus_limit.0"),
        ({"azimuth_mode": "rotating", "power__available": -1.0}, "out of range"),
        (
            {"azimuth_mode": "rotating", "auto__hysteresis": 1.5},
            "auto.hysteresis: expected less than auto.force_limit, or the thrusters are never held again, "
            "found 1.5 and 1.5",
        ),
        ({"azimuth_mode": "rotating", "singularity__method": "luck"}, "singularity.method: Input should be 'none'"),
        ({"azimuth_mode": "rotating", "singularity__gain_limit": -0.5}, "singularity.gain_limit"),
        ({"azimuth_mode": "rotating", "azimuth_rate_scale": [1.0, 1.0, 2.0, 1.0]}, "azimuth_rate_scale.2"),
        ({"azimuth_mode": "rotating", "sectors__dwell_time": math.nan}, "out of range"),
        ({"azimuth_mode": "rotating", "feather_time": math.inf}, "out of range"),
    ],
)
def test_bad_parameters_are_refused_whole(start: Any, values: dict[str, Any], reason: str) -> None:
    bench = start()
    before = bench.bench.node.settings
    answer = bench.bench.set_parameters(**values)
    assert not answer.successful
    assert reason in answer.reason
    assert bench.bench.node.settings == before
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


def test_activated_again_it_goes_on_from_its_last_command(start: Any) -> None:
    bench = start(azimuth_mode="rotating")
    for k in range(10):
        command, _, _ = bench.ask(START + k * STEP)
    node = bench.bench.node
    for transition in (node.trigger_deactivate, node.trigger_cleanup, node.trigger_configure, node.trigger_activate):
        assert transition() is TransitionCallbackReturn.SUCCESS
    settings = AllocatorSettings(azimuth_mode="rotating")
    expected = Allocator(VESSEL, settings, thrust=command.thrust, azimuth=command.azimuth)
    again, _, _ = bench.ask(START)  # a new time line
    result = expected.step(TAU, 0.2)
    np.testing.assert_array_equal(again.thrust, result.thrust)
    np.testing.assert_allclose(again.azimuth, result.azimuth, atol=1e-15)


def assert_within_limits(before: Any, after: Any) -> None:
    """No thruster is asked for a step beyond its rates."""
    dt = (to_nanoseconds(after.header.stamp) - to_nanoseconds(before.header.stamp)) * 1e-9
    # What is left is rounding in sums and angles.
    assert (np.abs(np.subtract(after.thrust, before.thrust)) <= VESSEL.thrust_rate * dt + 1e-9).all()
    turn = np.abs(wrap_angles(np.subtract(after.azimuth, before.azimuth)))
    assert (turn <= VESSEL.azimuth_rate * dt + 1e-9).all()


def test_deactivated_it_ramps_thrust_to_zero_says_what_is_left_and_comes_back_within_limits(start: Any) -> None:
    bench = start(azimuth_mode="rotating")
    node, stamp = bench.bench.node, START
    hard = (18.0, 2.0, 1.0)  # N, N, N m: takes some samples to give up
    for _ in range(40):
        before, _, _ = bench.ask(stamp := stamp + STEP, hard)
    steady = before
    assert np.abs(steady.thrust).max() > 1.0
    node.trigger_deactivate()
    # The slowest thruster gives its all up in a second.
    for k in range(8):
        command, achieved, status = bench.ask(stamp := stamp + STEP, hard)
        assert_within_limits(before, command)
        np.testing.assert_array_equal(command.azimuth, steady.azimuth)
        wrench = achieved.wrench
        np.testing.assert_allclose(
            (wrench.force.x, wrench.force.y, wrench.torque.z),
            generalized_force(VESSEL.lever_x, VESSEL.lever_y, np.array(command.thrust), np.array(command.azimuth)),
            atol=1e-9,
        )
        assert status.status == "deactivated"
        before = command
        if k == 1:  # in the middle of the ramp: there and back
            assert np.abs(command.thrust).max() > 0.1
            node.trigger_activate()
            before, _, status = bench.ask(stamp := stamp + STEP, hard)
            assert_within_limits(command, before)
            assert status.status == "optimal"
            steady = before
            node.trigger_deactivate()
    np.testing.assert_array_equal(before.thrust, np.zeros(4))
    health = bench.bench.diagnostics()
    assert health["alarm.NODE-NOT-ACTIVE"].endswith("inactive")
    assert health["ignored_inputs"] == "0"
    # Parameters that change meanwhile hold from the activation on.
    assert bench.bench.set_parameters(thruster_enabled=[True, True, False, True]).successful
    _, _, status = bench.ask(stamp := stamp + STEP, hard)
    assert status.status == "deactivated"
    before = bench.commands[-1]
    node.trigger_activate()
    for _ in range(20):
        command, _, _ = bench.ask(stamp := stamp + STEP, hard)
        assert_within_limits(before, command)
        before = command
    assert command.thrust[2] == 0.0
    assert np.abs(command.thrust).max() > 1.0


def test_an_allocator_that_was_never_active_says_nothing() -> None:
    with node_bench(AllocatorNode, autostart=False) as bare:
        bare.node.trigger_configure()
        bench = Bench(bare)
        bench.send(START)
        bare.wait_until(lambda: bare.node.ignored == 1, "the demand to be ignored")
        assert bench.commands == []


def test_thrust_that_the_drivers_have_ramped_to_zero_comes_back_from_there(start: Any) -> None:
    """As when the controller was away for a while."""
    bench = start(azimuth_mode="fixed")
    stamp = START
    for _ in range(40):
        before, _, _ = bench.ask(stamp := stamp + STEP)
    timeout = VESSEL.drivers.command_timeout
    stamp += round((timeout + 60.0) * 1e9)
    for _ in range(2):
        bench.send(stamp := stamp + STEP, (0.0, 0.0, 0.0))  # a jump is believed at the third stamp
    command, _, _ = bench.ask(stamp + STEP, (0.0, 0.0, 0.0))
    assert np.abs(before.thrust).max() > 1.0
    np.testing.assert_allclose(command.thrust, np.zeros(4), atol=1e-9)


# One group of parameters after the other: changes at demand 2, and at demand 4 where there are two.
CHANGES: dict[str, tuple[dict[str, Any], ...]] = {
    "failures": ({"thruster_enabled": [True, True, False, True], "azimuth_enabled": [True, False, True, True]},),
    "weakness": ({"thrust_limit_scale": [1.0, 0.3, 0.3, 0.3]},),
    "slow": ({"azimuth_rate_scale": [1.0, 0.5, 0.5, 0.0]},),
    "feathering": (
        {"thruster_enabled": [True, True, False, True], "feather_time": 2.0},
        {"thruster_enabled": [True, True, True, True]},
    ),
    "auto": ({"azimuth_mode": "auto", "auto.force_limit": 100.0, "auto.dwell_time": 0.2},),
    "cost": ({"cost": "power_3_2", "thrust_weight": "propeller"},),
    "over-demand": ({"over_demand": "proportional", "thrust_limit_scale": [0.2, 0.2, 0.2, 0.2]},),
    "sectors": ({"sectors.enabled": True, "sectors.hysteresis": 0.0, "sectors.dwell_time": 0.5},),
    "total power": ({"power.limit": "total", "power.available": 1.0, "power.measured": False},),
    "equal shares": ({"power.limit": "total", "power.available": 1.0, "power.priority": "equal"},),
    "bus power": ({"power.limit": "bus", "power.bus_limit": [0.3, 0.3], "power.measured": False},),
    "singularity": ({"singularity.method": "three_step", "singularity.gain_limit": 1.0},),
    "solver": ({"solver": "daqp"},),
    "method": ({"method": "pseudo_inverse"}, {"method": "qp"}),
}
HARD = (7.0, -3.0, 2.0)


@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES.keys())
def test_every_group_changes_live_and_acts_from_the_next_demand(
    start: Any, changes: tuple[dict[str, Any], ...]
) -> None:
    """Command and status are those of a core that is told the same between the same two steps, and of no other."""
    bench, settings = start(azimuth_mode="rotating"), AllocatorSettings.for_vessel(VESSEL, azimuth_mode="rotating")
    expected, unchanged = Allocator(VESSEL, settings), Allocator(VESSEL, settings)
    differs = False
    for k in range(8):
        if k in (2, 4) and k // 2 <= len(changes):
            change = changes[k // 2 - 1]
            assert bench.bench.set_parameters(**{name.replace(".", "__"): v for name, v in change.items()}).successful
            settings = with_parameters(settings, change)
            expected.apply(settings)
        assert bench.bench.node.settings == settings
        command, _, status = bench.ask(START + k * STEP, HARD)
        result, other = expected.step(HARD, 0.2), unchanged.step(HARD, 0.2)
        np.testing.assert_array_equal(command.thrust, result.thrust)
        np.testing.assert_array_equal(command.azimuth, result.azimuth)
        assert_tells(status, result)
        same = np.array_equal(result.thrust, other.thrust) and np.array_equal(result.azimuth, other.azimuth)
        assert same or k >= 2
        differs = differs or not same or status.solver != other.solver
    assert differs


def assert_tells(status: Any, result: AllocationResult) -> None:
    """Every field of the message is what the result says."""
    gains, margin, power, sectors, avoidance = (
        result.gains,
        result.margin,
        result.power,
        result.sectors,
        result.avoidance,
    )
    expected: dict[str, Any] = {
        "status": result.status.value,
        "azimuth_mode": result.azimuth_mode,
        "performance_measure": result.mean_force,
        "solver": result.solver,
        "cost": result.cost,
        "slack": result.slack,
        "demanded_power": result.demanded_power,
        "commanded_power": result.commanded_power,
        "power_stage": "" if power is None else power.stage.name.lower(),
        "bus_power": [] if power is None else power.bus,
        "bus_limited": [] if power is None else power.bus_limited,
        "rotating": result.rotating,
        "thrust_saturated": result.thrust_saturated,
        "azimuth_saturated": result.azimuth_saturated,
        "sub_problem": 0 if sectors is None else sectors.sub_problem,
        "crossing": [] if sectors is None else sectors.crossing,
        "margin": margin.fixed,
        "margin_turned": margin.turning,
        "minimum_gain": gains.global_gain,
        "minimum_gain_local": gains.local_gain,
        "minimum_gain_horizon": gains.horizon_gain,
        "minimum_gain_both_ways": result.gain_both_ways.gain,
        "weakest_direction": gains.direction,
        "weakest_azimuth": gains.projection_angle,
        "weakest_length": gains.projection_length,
        "singularity_method": "none" if avoidance is None else avoidance.method,
        "gain_limit": math.nan if avoidance is None else avoidance.threshold,
        "minimum_gain_free": math.nan if avoidance is None else avoidance.minimum_gain_free,
        "cost_free": math.nan if avoidance is None else avoidance.cost_free,
        "waiting": False if avoidance is None else avoidance.waiting,
        "locked": False if avoidance is None else avoidance.locked,
        "released": False if avoidance is None else avoidance.released,
        "gain_crossing": False if avoidance is None else avoidance.crossing,
        "antispin": result.antispin,
        "torque_loss": result.torque_loss,
        "method": result.method,
        "detail": result.detail,
        "feasible_load": result.feasible_load,
        "tau_feasible": [] if result.method_report is None else result.tau_feasible,
        "tau_qp": [] if result.method_report is None else result.tau_qp,
    }
    assert {"header", *expected} == set(status.get_fields_and_field_types())
    for name, value in expected.items():
        np.testing.assert_array_equal(getattr(status, name), value, err_msg=name)


def test_sectors_are_told_window_and_way(start: Any) -> None:
    """From straight to starboard, where a thruster may point, to another window through the forbidden sector ahead."""
    bench = start(azimuth_mode="rotating", sectors__enabled=True)
    settings = with_parameters(
        AllocatorSettings.for_vessel(VESSEL), {"azimuth_mode": "rotating", "sectors.enabled": True}
    )
    expected, crossed, numbers = Allocator(VESSEL, settings), False, set()
    for k in range(30):
        tau = (8.0, -4.0, 2.0) if k < 15 else (-8.0, 4.0, -2.0)
        status = bench.ask(START + k * STEP, tau)[2]
        assert_tells(status, expected.step(tau, 0.2))
        crossed = crossed or any(status.crossing)
        numbers.add(status.sub_problem)
    assert crossed
    assert len(numbers) >= 2
    assert min(numbers) >= 1
    health = bench.bench.diagnostics()
    assert health["sub_problem"] == str(status.sub_problem)


def test_all_gains_are_told_when_asked_for(start: Any) -> None:
    bench = start(azimuth_mode="rotating", singularity__method="three_step", singularity__monitor="all")
    changes = {"azimuth_mode": "rotating", "singularity.method": "three_step", "singularity.monitor": "all"}
    expected = Allocator(VESSEL, with_parameters(AllocatorSettings.for_vessel(VESSEL), changes))
    for k in range(12):
        status = bench.ask(START + k * STEP, (6.0, 0.0, 0.0))[2]
        assert_tells(status, expected.step((6.0, 0.0, 0.0), 0.2))
    # The vessel's limit, and reason to wait: surge alone turns all thrusters ahead, where sway is weak.
    gains = VESSEL.allocator.singularity
    assert gains is not None
    assert status.gain_limit == gains.gain_limit
    assert status.waiting
    assert status.minimum_gain_free < status.gain_limit < status.minimum_gain_both_ways
    for gain in (status.minimum_gain, status.minimum_gain_local, status.minimum_gain_horizon):
        assert math.isfinite(gain)


def power_feedback(stamp: int, power: list[float], names: list[str] = NAMES) -> ThrusterFeedback:
    message = ThrusterFeedback(name=names, power=power)
    message.header.stamp = from_nanoseconds(stamp)
    return message


POWER = {"power.limit": "total", "power.available": 2.0}
TICK = round(VESSEL.simulation.time_step * 1e9)


def test_measured_power_corrects_the_prediction(start: Any) -> None:
    """The newest one before the demand, in any order of names; that of a lost thruster does not count."""
    lost = [True, True, True, False]
    bench = start(azimuth_mode="rotating", power__limit="total", power__available=2.0, thruster_enabled=lost)
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")
    changes = {"azimuth_mode": "rotating", "thruster_enabled": lost, **POWER}
    expected = Allocator(VESSEL, with_parameters(AllocatorSettings.for_vessel(VESSEL), changes))
    bench.ask(START, HARD)
    expected.step(HARD, 0.2)
    feedback.publish(power_feedback(START + STEP - 2 * TICK, [9.0, 9.0, 9.0, 9.0]))
    feedback.publish(power_feedback(START + STEP - TICK, [50.0, 1.6, 0.7, 0.1], NAMES[::-1]))
    feedback.publish(power_feedback(START + STEP, [9.0, 9.0, 9.0, 9.0]))  # not before the demand
    bench.bench.wait_until(lambda: len(bench.bench.node._power) == 3, "three feedbacks")
    status = bench.ask(START + STEP, HARD)[2]
    expected.measure_power(0.1 + 0.7 + 1.6)
    result = expected.step(HARD, 0.2)
    assert result.power is not None
    assert result.power.correction != 1.0
    assert_tells(status, result)
    assert status.power_stage != "within"
    assert status.commanded_power <= 2.0 * (1.0 + 1e-12)  # rounding of a sum
    health = bench.bench.diagnostics()
    assert float(health["power_correction"]) == pytest.approx(result.power.correction, rel=1e-5)
    assert health["level"] == 1
    assert f"W available ({status.power_stage})" in health["message"]


def direction_feedback(stamp: int, azimuth: list[float]) -> ThrusterFeedback:
    message = ThrusterFeedback(name=NAMES, azimuth=azimuth, power=[0.0] * len(NAMES))
    message.header.stamp = from_nanoseconds(stamp)
    return message


def test_a_lost_azimuth_drive_is_allocated_where_the_feedback_sees_it(start: Any) -> None:
    """Heard of while the node runs; in lockstep a demand waits for the feedback of the time step before it."""
    bench = start(azimuth_mode="rotating", synchronous=True)
    settings = AllocatorSettings.for_vessel(VESSEL, azimuth_mode="rotating")
    expected = Allocator(VESSEL, settings)
    assert_tells(bench.ask(START, HARD)[2], expected.step(HARD, 0.2))
    stuck = [True, True, False, True]
    assert bench.bench.set_parameters(azimuth_enabled=stuck).successful
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")  # waits until the node listens
    expected.apply(with_parameters(settings, {"azimuth_enabled": stuck}))
    bench.send(START + STEP, HARD)
    bench.bench.wait_until(lambda: bench.bench.node._room.holds, "the demand to be held")
    assert bench.bench.diagnostics()["message"].startswith(
        "tau_desired waits for an input: the directions of thruster_feedback"
    )
    feedback.publish(direction_feedback(START + STEP - TICK, [0.0, 0.0, 2.5, 0.0]))
    bench.bench.wait_until(lambda: len(bench.statuses) == 2, "an answer")
    expected.measure_azimuth([0.0, 0.0, 2.5, 0.0])
    result = expected.step(HARD, 0.2)
    assert_tells(bench.statuses[-1], result)
    np.testing.assert_array_equal(bench.commands[-1].azimuth, result.azimuth)
    blind = Allocator(VESSEL, settings)
    blind.step(HARD, 0.2)
    blind.apply(with_parameters(settings, {"azimuth_enabled": stuck}))
    assert blind.step(HARD, 0.2).azimuth[2] != result.azimuth[2]


def test_lockstep_waits_for_the_power_before_a_demand_and_for_no_other(start: Any) -> None:
    bench = start(azimuth_mode="rotating", synchronous=True, power__limit="total", power__available=2.0)
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")
    expected = Allocator(
        VESSEL, with_parameters(AllocatorSettings.for_vessel(VESSEL), {"azimuth_mode": "rotating", **POWER})
    )
    assert_tells(bench.ask(START, HARD)[2], expected.step(HARD, 0.2))  # nothing has been measured before the first
    bench.send(START + STEP, HARD)
    bench.bench.wait_until(lambda: bench.bench.node._room.holds, "the demand to be held")
    health = bench.bench.diagnostics()
    assert health["level"] == 1
    assert health["message"].startswith("tau_desired waits for an input: the power of thruster_feedback; ")
    assert any(key.startswith("alarm.ALLOCATOR-POWER-") for key in health)
    feedback.publish(power_feedback(START + STEP - 2 * TICK, [0.1, 1.0, 0.5, 0.5]))
    bench.bench.wait_until(lambda: len(bench.bench.node._power) == 1, "the feedback before the one that counts")
    assert len(bench.commands) == 1
    feedback.publish(power_feedback(START + STEP - TICK, [0.1, 1.2, 0.6, 0.7]))
    bench.bench.wait_until(lambda: len(bench.statuses) == 2, "an answer")
    expected.measure_power(0.1 + 1.2 + 0.6 + 0.7)
    assert_tells(bench.statuses[-1], expected.step(HARD, 0.2))
    # Here already: no wait.
    feedback.publish(power_feedback(START + 2 * STEP - TICK, [0.1, 1.2, 0.6, 0.7]))
    bench.bench.wait_until(lambda: len(bench.bench.node._power) == 3, "the next feedback")
    expected.measure_power(0.1 + 1.2 + 0.6 + 0.7)
    assert_tells(bench.ask(START + 2 * STEP, HARD)[2], expected.step(HARD, 0.2))


def test_lockstep_waits_for_power_from_the_demand_after_it_was_asked_for(start: Any) -> None:
    """Switched on while running: answers do not depend on how long the node takes to be heard of."""
    bench = start(azimuth_mode="rotating", synchronous=True)
    settings = AllocatorSettings.for_vessel(VESSEL, azimuth_mode="rotating")
    expected = Allocator(VESSEL, settings)
    assert_tells(bench.ask(START, HARD)[2], expected.step(HARD, 0.2))  # without a limit nobody listens
    assert bench.bench.node.count_subscribers("thruster_feedback") == 0
    assert bench.bench.set_parameters(power__limit="total", power__available=2.0).successful
    expected.apply(with_parameters(settings, POWER))
    bench.send(START + STEP, HARD)
    bench.bench.wait_until(lambda: bench.bench.node._room.holds, "the demand to be held")
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")
    feedback.publish(power_feedback(START + STEP - TICK, [0.1, 1.2, 0.6, 0.7]))
    bench.bench.wait_until(lambda: len(bench.statuses) == 2, "an answer")
    expected.measure_power(0.1 + 1.2 + 0.6 + 0.7)
    assert_tells(bench.statuses[-1], expected.step(HARD, 0.2))


def test_a_demand_that_waits_is_answered_once_power_does_not_matter(start: Any) -> None:
    bench = start(synchronous=True, power__limit="total", power__available=2.0)
    bench.ask(START)
    bench.send(START + STEP)
    bench.bench.wait_until(lambda: bench.bench.node._room.holds, "the demand to be held")
    assert bench.bench.set_parameters(power__measured=False).successful
    bench.bench.wait_until(lambda: len(bench.statuses) == 2, "an answer")
    assert to_nanoseconds(bench.statuses[-1].header.stamp) == START + STEP
    bench.ask(START + 2 * STEP)


@pytest.mark.parametrize(
    ("names", "power", "reason"),
    [
        (NAMES, [1.0, math.nan, 1.0, 1.0], "thruster_feedback: power: expected finite numbers"),
        (NAMES, [1.0, 1.0], "thruster_feedback: power: expected shape (4,), found (2,)"),
        ([*NAMES[:3], "rudder"], [1.0] * 4, "thruster_feedback: expected the thrusters"),
        (NAMES[:2], [1.0] * 4, "thruster_feedback: expected the thrusters"),
        ([*NAMES, NAMES[0]], [1.0] * 4, "thruster_feedback: expected the thrusters"),
    ],
)
def test_bad_feedback_is_refused_and_the_ring_goes_on(
    start: Any, names: list[str], power: list[float], reason: str
) -> None:
    """Without a measurement the demand is answered from the prediction."""
    bench = start(azimuth_mode="rotating", synchronous=True, power__limit="total", power__available=2.0)
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")
    expected = Allocator(
        VESSEL, with_parameters(AllocatorSettings.for_vessel(VESSEL), {"azimuth_mode": "rotating", **POWER})
    )
    bench.ask(START, HARD)
    expected.step(HARD, 0.2)
    bench.send(START + STEP, HARD)
    feedback.publish(power_feedback(START + STEP - TICK, power, names))
    assert reason in bench.refused(1)
    bench.bench.wait_until(lambda: len(bench.statuses) == 2, "an answer all the same")
    assert_tells(bench.statuses[-1], expected.step(HARD, 0.2))
    feedback.publish(power_feedback(START + 2 * STEP - TICK, [0.1, 1.2, 0.6, 0.7]))
    status = bench.ask(START + 2 * STEP, HARD)[2]
    expected.measure_power(0.1 + 1.2 + 0.6 + 0.7)
    assert_tells(status, expected.step(HARD, 0.2))


def test_power_that_has_stopped_is_forgotten(start: Any) -> None:
    """One measurement holds for five samples, however often demands come."""
    bench = start(azimuth_mode="rotating", power__limit="total", power__available=2.0)
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")
    expected = Allocator(
        VESSEL, with_parameters(AllocatorSettings.for_vessel(VESSEL), {"azimuth_mode": "rotating", **POWER})
    )
    bench.ask(START, HARD)
    expected.step(HARD, 0.2)
    feedback.publish(power_feedback(START + STEP - TICK, [0.1, 1.2, 0.6, 0.7]))
    bench.bench.wait_until(lambda: len(bench.bench.node._power) == 1, "the feedback")
    expected.measure_power(0.1 + 1.2 + 0.6 + 0.7)
    corrections = []
    for k in range(1, 9):
        status = bench.ask(START + k * STEP, HARD)[2]
        result = expected.step(HARD, 0.2)
        assert_tells(status, result)
        assert result.power is not None
        corrections.append(result.power.correction)
    assert corrections[0] != 1.0
    assert corrections[-1] == 1.0


ANTISPIN = {"antispin.enabled": True}


def ventilation(stamp: int, beta_q2: list[float], names: list[str] = NAMES) -> Ventilation:
    flags = [loss < 1.0 for loss in beta_q2]
    message = Ventilation(name=names, ventilating=flags, beta_q=beta_q2, beta_q2=beta_q2)
    message.header.stamp = from_nanoseconds(stamp)
    return message


def antispin_core() -> tuple[AllocatorSettings, Allocator]:
    settings = AllocatorSettings.for_vessel(VESSEL, azimuth_mode="rotating")
    return settings, Allocator(VESSEL, with_parameters(settings, ANTISPIN))


def test_ventilation_raises_the_cost_and_is_told(start: Any) -> None:
    """The newest one before the demand, in any order of names, for as long as it is not too old."""
    bench, (_, expected) = start(azimuth_mode="rotating", antispin__enabled=True), antispin_core()
    drivers = bench.bench.publisher(Ventilation, "ventilation")
    assert_tells(bench.ask(START, HARD)[2], expected.step(HARD, 0.2))
    health = bench.bench.diagnostics()
    assert health["level"] == 1
    assert "alarm.ALLOCATOR-VENTILATION-STALE" in health
    drivers.publish(ventilation(START + STEP - 2 * TICK, [1.0, 1.0, 0.9, 0.9]))
    drivers.publish(ventilation(START + STEP - TICK, [0.7, 0.4, 1.0, 1.0], NAMES[::-1]))
    drivers.publish(ventilation(START + STEP, [0.2] * 4))  # not before the demand
    bench.bench.wait_until(lambda: len(bench.bench.node._ventilation) == 3, "three messages")
    command, _, status = bench.ask(START + STEP, HARD)
    expected.measure_ventilation([1.0, 1.0, 0.4, 0.7], TICK * 1e-9)
    result = expected.step(HARD, 0.2)
    assert_tells(status, result)
    np.testing.assert_array_equal(command.thrust, result.thrust)
    assert status.antispin
    assert list(status.torque_loss) == [1.0, 1.0, 0.4, 0.7]
    health = bench.bench.diagnostics()
    assert (health["level"], health["spared"]) == (0, "azimuth_port 0.40 azimuth_starboard 0.70")
    # The one that came too early counts for the next demand; then silence, until it is 1 s old.
    expected.measure_ventilation([0.2] * 4, STEP * 1e-9)
    for k in range(2, 10):
        status = bench.ask(START + k * STEP, HARD)[2]
        assert_tells(status, expected.step(HARD, 0.2))
        assert (status.torque_loss[0] > 0.2) == (k > 6)
    assert "alarm.ALLOCATOR-VENTILATION-STALE" in bench.bench.diagnostics()


def test_lockstep_waits_for_power_and_ventilation_before_a_demand(start: Any) -> None:
    """Switched on while running, too: answers do not depend on which message was faster."""
    bench = start(azimuth_mode="rotating", synchronous=True, power__limit="total", power__available=2.0)
    settings = with_parameters(AllocatorSettings.for_vessel(VESSEL, azimuth_mode="rotating"), POWER)
    expected = Allocator(VESSEL, settings)
    assert_tells(bench.ask(START, HARD)[2], expected.step(HARD, 0.2))
    assert bench.bench.node.count_subscribers("ventilation") == 0
    assert bench.bench.set_parameters(antispin__enabled=True).successful
    expected.apply(with_parameters(settings, ANTISPIN))
    bench.send(START + STEP, HARD)
    bench.bench.wait_until(lambda: bench.bench.node._room.holds, "the demand to be held")
    waits = "tau_desired waits for an input: the power of thruster_feedback and ventilation, which nobody publishes"
    assert bench.bench.diagnostics()["message"].startswith(waits)
    drivers = bench.bench.publisher(Ventilation, "ventilation")
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")
    feedback.publish(power_feedback(START + STEP - TICK, [0.1, 1.2, 0.6, 0.7]))
    bench.bench.wait_until(lambda: len(bench.bench.node._power) == 1, "the feedback")
    assert bench.bench.diagnostics()["message"] == "tau_desired waits for an input: ventilation"
    drivers.publish(ventilation(START + STEP - 2 * TICK, [1.0, 1.0, 0.3, 0.3]))
    bench.bench.wait_until(lambda: len(bench.bench.node._ventilation) == 1, "the one before the one that counts")
    assert len(bench.commands) == 1
    drivers.publish(ventilation(START + STEP - TICK, [1.0, 1.0, 0.5, 1.0]))
    bench.bench.wait_until(lambda: len(bench.statuses) == 2, "an answer")
    expected.measure_power(0.1 + 1.2 + 0.6 + 0.7)
    expected.measure_ventilation([1.0, 1.0, 0.5, 1.0], TICK * 1e-9)
    assert_tells(bench.statuses[-1], expected.step(HARD, 0.2))
    # Switched off while a demand waits: power alone is waited for, and losses are forgotten at their rate.
    bench.send(START + 2 * STEP, HARD)
    bench.bench.wait_until(lambda: bench.bench.node._room.holds, "the next demand to be held")
    feedback.publish(power_feedback(START + 2 * STEP - TICK, [0.1, 1.2, 0.6, 0.7]))
    bench.bench.wait_until(lambda: len(bench.bench.node._power) == 2, "the next feedback")
    assert len(bench.statuses) == 2
    assert bench.bench.set_parameters(antispin__enabled=False).successful
    bench.bench.wait_until(lambda: len(bench.statuses) == 3, "an answer")
    expected.apply(settings)
    expected.measure_power(0.1 + 1.2 + 0.6 + 0.7)
    assert_tells(bench.statuses[-1], expected.step(HARD, 0.2))
    assert VESSEL.drivers.ventilation is not None
    assert bench.statuses[-1].torque_loss[2] == pytest.approx(0.5 + 0.2 * VESSEL.drivers.ventilation.relax_rate)


def test_lockstep_goes_on_when_power_and_ventilation_are_switched_on_again(start: Any) -> None:
    """What a demand waits for has come before the switch, while nobody needed it."""
    bench = start(azimuth_mode="rotating", synchronous=True, antispin__enabled=True, power__limit="total")
    drivers = bench.bench.publisher(Ventilation, "ventilation")
    feedback = bench.bench.publisher(ThrusterFeedback, "thruster_feedback")
    on = {"antispin__enabled": True, "power__limit": "total", "power__available": 2.0}
    off = {"antispin__enabled": False, "power__limit": "none"}
    settings, expected = antispin_core()
    both = with_parameters(settings, POWER | ANTISPIN)
    assert bench.bench.set_parameters(**on).successful
    expected.apply(both)
    assert_tells(bench.ask(START, HARD)[2], expected.step(HARD, 0.2))
    assert bench.bench.set_parameters(**off).successful
    expected.apply(with_parameters(both, {"antispin.enabled": False, "power.limit": "none"}))
    assert_tells(bench.ask(START + STEP, HARD)[2], expected.step(HARD, 0.2))
    # Nobody needs them now, so that a bad one is no reason to complain.
    drivers.publish(ventilation(START + 2 * STEP - 2 * TICK, [1.0, math.nan, 1.0, 1.0]))
    drivers.publish(ventilation(START + 2 * STEP - TICK, [1.0, 1.0, 0.5, 1.0]))
    feedback.publish(power_feedback(START + 2 * STEP - TICK, [0.1, 1.2, 0.6, 0.7]))
    bench.bench.wait_until(
        lambda: len(bench.bench.node._ventilation) == 2 and len(bench.bench.node._power) == 1, "both are kept"
    )
    assert bench.bench.diagnostics()["refused_inputs"] == "0"
    assert bench.bench.set_parameters(**on).successful
    expected.apply(both)
    expected.measure_power(0.1 + 1.2 + 0.6 + 0.7)
    expected.measure_ventilation([1.0, 1.0, 0.5, 1.0], TICK * 1e-9)
    assert_tells(bench.ask(START + 2 * STEP, HARD)[2], expected.step(HARD, 0.2))


@pytest.mark.parametrize(
    ("names", "beta_q2", "reason"),
    [
        (NAMES, [1.0, math.nan, 1.0, 1.0], "ventilation: beta_q2: expected finite numbers"),
        (NAMES, [1.0, 1.0], "ventilation: beta_q2: expected shape (4,), found (2,)"),
        (NAMES, [1.0, -0.2, 1.0, 1.0], "ventilation: beta_q2: expected factors from 0 to 1"),
        (NAMES, [1.0, 1.2, 1.0, 1.0], "ventilation: beta_q2: expected factors from 0 to 1"),
        ([*NAMES[:3], "rudder"], [1.0] * 4, "ventilation: expected the thrusters"),
        (NAMES[:2], [1.0] * 4, "ventilation: expected the thrusters"),
    ],
)
def test_bad_ventilation_is_refused_and_the_ring_goes_on(
    start: Any, names: list[str], beta_q2: list[float], reason: str
) -> None:
    bench = start(azimuth_mode="rotating", synchronous=True, antispin__enabled=True)
    _, expected = antispin_core()
    drivers = bench.bench.publisher(Ventilation, "ventilation")
    bench.ask(START, HARD)
    expected.step(HARD, 0.2)
    drivers.publish(ventilation(START + STEP - TICK, [1.0, 1.0, 0.5, 1.0]))
    bench.ask(START + STEP, HARD)
    expected.measure_ventilation([1.0, 1.0, 0.5, 1.0], TICK * 1e-9)
    expected.step(HARD, 0.2)
    bench.send(START + 2 * STEP, HARD)
    drivers.publish(ventilation(START + 2 * STEP - TICK, beta_q2, names))
    assert reason in bench.refused(1)
    bench.bench.wait_until(lambda: len(bench.statuses) == 3, "an answer all the same")
    assert_tells(bench.statuses[-1], expected.step(HARD, 0.2))


def test_every_parameter_describes_itself_with_unit_and_range(start: Any) -> None:
    bench = start()
    values = parameters_of(bench.bench.node.settings)
    double, array = ParameterType.PARAMETER_DOUBLE, ParameterType.PARAMETER_DOUBLE_ARRAY
    for name, told in zip(values, bench.bench.describe_parameters(list(values)), strict=True):
        model: Any = AllocatorSettings
        *groups, leaf = name.split(".")
        for group in groups:
            model = model.model_fields[group].annotation
        field = model.model_fields[leaf]
        assert told.name == name
        assert not told.read_only
        assert told.description.startswith(field.description)
        assert len(field.description) > 15, name
        unit = field.json_schema_extra["unit"]
        assert (f"[{unit}]" in told.description) == (unit not in ("", "1")), name
        if told.type == double:
            (range_,) = told.floating_point_range
            low = next(m.ge for m in field.metadata if hasattr(m, "ge"))
            high = next((m.le for m in field.metadata if hasattr(m, "le")), sys.float_info.max)
            assert (range_.from_value, range_.to_value) == (low, high), name
        elif told.type == ParameterType.PARAMETER_STRING and name != "solver":
            assert "one of: " in told.description, name
        else:
            assert (
                told.type in (array, ParameterType.PARAMETER_BOOL_ARRAY, ParameterType.PARAMETER_BOOL)
                or name == "solver"
            )


def test_parameters_set_one_by_one_are_judged_each_for_itself(start: Any) -> None:
    bench = start()
    good, bad = bench.bench.set_one_by_one(azimuth_mode="rotating", auto__hysteresis=5.0)
    assert good.successful
    assert not bad.successful
    assert "auto.hysteresis: expected less than auto.force_limit" in bad.reason
    assert bench.ask(START)[2].azimuth_mode == "rotating"


def test_sectors_are_refused_on_a_vessel_without(start: Any, tmp_path: Path) -> None:
    names = [name for name, turns in zip(NAMES, VESSEL.can_rotate, strict=True) if turns]
    rows = "".join(f"  - {{name: {name}, azimuth: {{sectors: []}}}}\n" for name in names)
    path = tmp_path / "open.yaml"
    path.write_text(f"extends: cybership3\nname: open\nthrusters:\n{rows}", encoding="utf-8")
    bench = start(vessel=str(path))
    answer = bench.bench.set_parameters(azimuth_mode="rotating", sectors__enabled=True)
    assert not answer.successful
    assert answer.reason == "sectors.enabled: expected a vessel with sectors, found none in 'open'"
    assert bench.ask(START)[2].azimuth_mode == "fixed"


def test_the_limit_of_gain_may_be_replaced(start: Any) -> None:
    """The vessel's stands at first; the status says which is in force."""
    bench = start(azimuth_mode="rotating", singularity__method="three_step", singularity__gain_limit=0.7)
    assert bench.ask(START)[2].gain_limit == 0.7
    assert bench.bench.set_parameters(singularity__gain_limit=0.3).successful
    assert bench.ask(START + STEP)[2].gain_limit == 0.3
    answer = bench.bench.set_parameters(singularity__gain_limit=11.0)
    assert not answer.successful
    assert bench.ask(START + 2 * STEP)[2].gain_limit == 0.3


def test_demands_out_of_reach_are_a_warning_with_the_share_that_is(start: Any) -> None:
    bench = start(azimuth_mode="rotating")
    status = bench.ask(START, (60.0, 0.0, 0.0))[2]
    assert status.margin_turned < 1.0
    health = bench.bench.diagnostics()
    assert health["level"] == 1
    assert health["message"] == f"demand out of reach: {status.margin_turned:.3g} of it is attainable"
