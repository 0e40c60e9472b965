"""The simulator node over real DDS, answered by drivers that the test plays."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
import yaml
from dp_msgs.msg import ActuatorSetpoint, ThrusterFeedback, Ventilation
from dp_msgs.srv import Advance
from geometry_msgs.msg import PoseWithCovarianceStamped, Vector3Stamped, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock

from dp_node import RING, RING_PUBLISHER, Level, RingExecutor, from_nanoseconds, to_nanoseconds
from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.frames import quaternion_to_heading
from support.thruster_rig import controllable_pitch_vessel
from support.waiting import wait_until
from vessel_sim import CurrentSettings, Simulator, SimulatorInputs, SimulatorSettings, WaveSettings, WindSettings
from vessel_sim.node import Phase, VesselSimNode

VESSEL = load_vessel("cybership3")
STEP = 20_000_000  # ns, simulation.time_step
CONTROL = 10  # steps between poses
NAMES = list(VESSEL.thruster_names)
REFERENCE = (5.0, -8.0, 6.0, 4.0)  # Hz, what the drivers of this test hold
GAIN = (1e-5, 1e-3, 4e-3, 4e-3)


class Drivers(Node):
    """Answers as observer, controller, allocator and drivers would, on two topics."""

    def __init__(self) -> None:
        super().__init__("test_drivers")
        self.answering = True
        self.command_stamp = 0
        self.poses: list[PoseWithCovarianceStamped] = []
        self.feedback: list[ThrusterFeedback] = []
        self.truth: list[Odometry] = []
        self.environment: list[WrenchStamped] = []
        self.wind: list[Vector3Stamped] = []
        self.clock: list[int] = []
        self.publisher_ = self.create_publisher(ActuatorSetpoint, "actuator_setpoint", RING_PUBLISHER)
        self.create_subscription(PoseWithCovarianceStamped, "pose", self._on_pose, RING)
        self.create_subscription(ThrusterFeedback, "thruster_feedback", self._on_feedback, RING)
        self.create_subscription(Odometry, "truth", self.truth.append, RING)
        self.create_subscription(WrenchStamped, "environment_force", self.environment.append, RING)
        self.create_subscription(Vector3Stamped, "wind", self.wind.append, RING)
        self.create_subscription(Clock, "/clock", lambda m: self.clock.append(to_nanoseconds(m.clock)), RING)

    def _on_pose(self, message: PoseWithCovarianceStamped) -> None:
        self.poses.append(message)
        if self.answering:
            self.command_stamp = to_nanoseconds(message.header.stamp)
            self.answer(self.command_stamp)

    def _on_feedback(self, message: ThrusterFeedback) -> None:
        self.feedback.append(message)
        if self.answering:
            self.answer(to_nanoseconds(message.header.stamp))

    def torque(self) -> list[float]:
        measured = self.feedback[-1].shaft_speed if self.feedback else [0.0] * 4
        return [g * (r - n) for g, r, n in zip(GAIN, REFERENCE, measured, strict=True)]

    def answer(self, stamp: int, **changed: Any) -> None:
        message = ActuatorSetpoint(name=NAMES, torque=self.torque(), azimuth_rate=[0.0, 0.1, -0.1, 0.05])
        message.header.stamp = from_nanoseconds(stamp)
        message.command_stamp = from_nanoseconds(self.command_stamp)
        for field, value in changed.items():
            setattr(message, field, value)
        self.publisher_.publish(message)


class Graph:
    """A simulator and the drivers of the test on one executor."""

    def __init__(self, **parameters: Any) -> None:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self.executor = RingExecutor()
        self.sim = VesselSimNode(parameter_overrides=[Parameter(k, value=v) for k, v in parameters.items()])
        self.drivers = Drivers()
        for node in (self.sim, self.drivers):
            self.executor.add_node(node)
        self.client = self.drivers.create_client(Advance, "vessel_sim/advance")
        self.sim.start()

    def wait(self, condition: Callable[[], object], message: str) -> None:
        wait_until(
            condition,
            message=lambda: f"{message}; {self.sim.health()}",
            spin=lambda seconds: self.executor.spin_once(timeout_sec=seconds),
        )

    def ask(self, until: float) -> Any:
        self.wait(self.client.service_is_ready, "the service is there")
        return self.client.call_async(Advance.Request(until=until))

    def advance(self, until: float) -> Any:
        future = self.ask(until)
        self.wait(future.done, f"the simulator reached {until}")
        return future.result()

    def now(self) -> float:
        return float(self.sim.health().values["simulated_time"])

    def phase(self) -> Phase:
        return Phase(self.sim.health().values["phase"])

    def close(self) -> None:
        self.executor.shutdown()
        self.drivers.destroy_node()
        self.sim.destroy_node()
        rclpy.try_shutdown()


@pytest.fixture
def graph(ros_domain_id: int) -> Iterator[Callable[..., Graph]]:
    made: list[Graph] = []

    def make(**parameters: Any) -> Graph:
        if made:
            made.pop().close()
        made.append(Graph(**parameters))
        return made[-1]

    yield make
    for one in made:
        one.close()
    rclpy.try_shutdown()


LOCKSTEP = {"lockstep": True, "rate": 0.0, "hold": True}
SEA = {"waves.amplitude": 0.03, "waves.period": 1.1, "waves.direction": 2.5, "seed": 4}
AIR = {"wind.speed": 2.0, "wind.gusts": True, "wind.direction": 2.0, "current.speed": 0.1, "current.variation": 0.02}


def stamps(messages: list[Any]) -> list[int]:
    return [to_nanoseconds(m.header.stamp) for m in messages]


def content(drivers: Drivers) -> list[tuple[Any, ...]]:
    """All numbers that the simulator published, to be compared bit by bit."""

    def pose(p: Any) -> tuple[float, ...]:
        return p.position.x, p.position.y, p.orientation.z, p.orientation.w

    rows: list[tuple[Any, ...]] = [(*pose(m.pose.pose), m.pose.covariance[0]) for m in drivers.poses]
    rows += [
        (
            *m.shaft_speed,
            *m.torque,
            *m.power,
            *m.azimuth,
            *m.azimuth_rate,
            *m.pitch_ratio,
            to_nanoseconds(m.header.stamp),
        )
        for m in drivers.feedback
    ]
    rows += [
        (*pose(m.pose.pose), m.twist.twist.linear.x, m.twist.twist.linear.y, m.twist.twist.angular.z)
        for m in drivers.truth
    ]
    rows += [(m.wrench.force.x, m.wrench.force.y, m.wrench.torque.z) for m in drivers.environment]
    rows += [(m.vector.x, m.vector.y) for m in drivers.wind]
    return rows


# Lockstep ------------------------------------------------------------------------------------------------------------


def test_lockstep_publishes_every_stamp_once_and_is_bit_identical(graph: Callable[..., Graph]) -> None:
    runs = []
    for _ in range(2):
        one = graph(**LOCKSTEP, **SEA, **AIR)
        answer = one.advance(2.0)
        assert (answer.success, answer.message, answer.reached) == (True, "", 2.0)
        drivers = one.drivers
        clock = drivers.clock
        one.wait(lambda: len(clock) == 100, "the last clock arrived")  # noqa: B023 - called in this turn only
        assert stamps(drivers.poses) == list(range(0, 100 * STEP, CONTROL * STEP))
        assert stamps(drivers.truth) == stamps(drivers.environment) == stamps(drivers.poses) == stamps(drivers.wind)
        assert drivers.wind[0].header.frame_id == "base_link_frd"
        assert stamps(drivers.feedback) == list(range(0, 100 * STEP, STEP))
        assert drivers.clock == list(range(STEP, 101 * STEP, STEP))
        assert drivers.poses[0].header.frame_id == "map_ned"
        assert drivers.feedback[0].name == NAMES
        runs.append(content(drivers))
    assert runs[0] == runs[1]


def test_lockstep_is_the_core_step_by_step(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP, **SEA, **AIR)
    one.advance(2.0)
    settings = SimulatorSettings(
        waves=WaveSettings(amplitude=0.03, period=1.1, direction=2.5),
        wind=WindSettings(speed=2.0, gusts=True, direction=2.0),
        current=CurrentSettings(speed=0.1, variation=0.02),
        seed=4,
    )
    core = Simulator(VESSEL, settings)
    for k in range(100):
        if k % CONTROL == 0:
            measured, sent = core.measure(), one.drivers.poses[k // CONTROL].pose
            assert measured is not None
            q = sent.pose.orientation
            assert [sent.pose.position.x, sent.pose.position.y] == measured[:2].tolist()
            # Through half angles and back: rounding.
            assert quaternion_to_heading(q.x, q.y, q.z, q.w) == pytest.approx(float(measured[2]), abs=1e-15)
            assert sent.covariance[0] == VESSEL.measurement.position_noise**2
            truth = core.truth()
            total = truth.position + truth.wave_position
            position = one.drivers.truth[k // CONTROL].pose.pose.position
            assert [position.x, position.y] == total[:2].tolist()
            force = one.drivers.environment[k // CONTROL].wrench.force
            assert [force.x, force.y] == (truth.wave_force + truth.current_force + truth.wind_force)[:2].tolist()
            vector, wind = one.drivers.wind[k // CONTROL].vector, core.measure_wind()
            assert wind is not None
            assert [vector.x, vector.y] == wind.tolist()
        feedback = core.output
        assert one.drivers.feedback[k].shaft_speed.tolist() == feedback.shaft_speed.tolist()
        assert one.drivers.feedback[k].power.tolist() == feedback.power.tolist()
        torque = [g * (r - n) for g, r, n in zip(GAIN, REFERENCE, feedback.shaft_speed.tolist(), strict=True)]
        core.step(SimulatorInputs(np.array(torque), np.array([0.0, 0.1, -0.1, 0.05])), 0.02)
    assert one.sim._simulator.output.position.tolist() == core.output.position.tolist()


def test_truth_twist_is_the_rate_of_the_true_pose(graph: Callable[..., Graph]) -> None:
    # A slow sea, so that differences over control samples say something about the rate, and no thrust.
    sea = {"waves.amplitude": 0.05, "waves.period": 6.0, "waves.direction": 0.9, "waves.ramp": 0.0}
    one = graph(**LOCKSTEP, **sea, **{"initial.heading": -0.7, "current.speed": 0.1, "current.direction": 2.0})
    one.drivers.torque = lambda: [0.0] * 4  # type: ignore[method-assign]
    one.advance(3.0)
    before, at, after = one.drivers.truth[6:9]
    heading = quaternion_to_heading(0.0, 0.0, at.pose.pose.orientation.z, at.pose.pose.orientation.w)
    north = (after.pose.pose.position.x - before.pose.pose.position.x) / 0.4
    east = (after.pose.pose.position.y - before.pose.pose.position.y) / 0.4
    ahead = math.cos(heading) * north + math.sin(heading) * east
    aside = -math.sin(heading) * north + math.cos(heading) * east
    # Central differences err by (omega dt)^2 / 6 = 0.7 % of the orbital velocity, 0.052 m/s.
    assert at.twist.twist.linear.x == pytest.approx(ahead, abs=5e-4)
    assert at.twist.twist.linear.y == pytest.approx(aside, abs=5e-4)


def test_pose_waits_for_its_command_and_feedback_for_its_answer(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP, lockstep_timeout=0.1)
    one.advance(0.2)
    drivers = one.drivers
    drivers.answering = False
    done = one.ask(0.4)
    one.wait(lambda: len(drivers.poses) == 2, "the pose at 0.2 s")
    assert one.phase() is Phase.COMMAND
    assert len(drivers.feedback) == 10
    # Overdue: it says what it waits for, publishes nothing more, and goes on when the answer comes.
    one.wait(lambda: one.sim.health().level is Level.ERROR, "the wait is reported")
    text = one.sim.health().message
    assert "lockstep at 0.200 s: waiting for an actuator_setpoint that holds the command" in text
    assert "the last actuator_setpoint answers 0.180 s and holds the command for 0.000 s" in text
    assert "every topic of the ring has both ends" in text
    # An answer to something older is no answer.
    drivers.answer(9 * STEP)
    one.wait(lambda: one.sim._answered == (9 * STEP, 0), "the old answer arrived")
    assert one.phase() is Phase.COMMAND
    drivers.command_stamp = 10 * STEP
    drivers.answer(10 * STEP)
    one.wait(lambda: len(drivers.feedback) == 11, "the feedback at 0.2 s")
    assert one.phase() is Phase.SETPOINT
    drivers.answering = True
    drivers.answer(10 * STEP)
    one.wait(done.done, "the run went on")
    assert done.result().success
    assert one.sim.health().level is Level.OK


def test_a_ring_that_stands_still_is_told_of_ventilation_that_nobody_publishes(graph: Callable[..., Graph]) -> None:
    """An allocator with anti-spin waits for it. Time begins without: a display may listen too."""
    one = graph(**LOCKSTEP, lockstep_timeout=0.1)
    allocator = one.drivers.create_subscription(Ventilation, "ventilation", lambda _: None, RING)
    assert one.advance(0.2).success
    one.drivers.answering = False
    done = one.ask(0.4)
    one.wait(lambda: one.sim.health().level is Level.ERROR, "the wait is reported")
    text = one.sim.health().message
    assert "lockstep at 0.200 s: waiting for an actuator_setpoint that holds the command" in text
    assert text.endswith("; nobody publishes ventilation")
    publisher = one.drivers.create_publisher(Ventilation, "ventilation", RING_PUBLISHER)
    one.wait(lambda: one.sim.health().message.endswith("every topic of the ring has both ends"), "both ends are there")
    one.drivers.destroy_publisher(publisher)
    one.drivers.destroy_subscription(allocator)
    one.drivers.answering = True
    one.drivers.command_stamp = 10 * STEP
    one.drivers.answer(10 * STEP)
    one.wait(done.done, "the run went on")


def test_pitch_goes_from_set_point_to_feedback(graph: Callable[..., Graph], tmp_path: Path) -> None:
    vessel = controllable_pitch_vessel()
    file = tmp_path / "vessel.yaml"
    file.write_text(yaml.safe_dump(vessel.model_dump(mode="json")), encoding="utf-8")
    one = graph(**LOCKSTEP, vessel=str(file), sensor_noise=False)
    goal = [0.6, 0.7, 1.2, 1.3]
    one.drivers.answer = partial(one.drivers.answer, pitch_ratio=goal)  # type: ignore[method-assign]
    assert one.advance(3.0).success
    pitch = np.array([m.pitch_ratio for m in one.drivers.feedback])
    np.testing.assert_array_equal(pitch[0], vessel.pitch_ratio)
    servo = vessel.thrusters[0].pitch
    assert servo is not None
    # Never faster than the servo, and there within e^-5 of the way after the rate limit has let go.
    assert np.abs(np.diff(pitch, axis=0)).max() <= servo.rate * 0.02 * (1.0 + 1e-9)  # rounding
    np.testing.assert_allclose(pitch[-1], goal, atol=math.exp(-5.0))
    assert np.all(np.sign(np.diff(pitch[:10], axis=0)) == np.sign(np.array(goal) - vessel.pitch_ratio))


def test_lockstep_says_that_the_graph_is_not_there(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP, lockstep_timeout=0.1)
    one.drivers.destroy_publisher(one.drivers.publisher_)
    sink = one.drivers.create_subscription(Odometry, "odometry", lambda _: None, RING)
    one.wait(
        lambda: (
            one.sim.health().level is Level.ERROR
            and "nobody publishes odometry" in one.sim.health().message
            and "nobody publishes /actuator_setpoint" in one.sim.health().message
        ),
        "what is missing is named",
    )
    assert one.now() == 0.0
    assert not one.drivers.poses
    one.drivers.publisher_ = one.drivers.create_publisher(ActuatorSetpoint, "actuator_setpoint", RING_PUBLISHER)
    one.drivers.destroy_subscription(sink)
    assert one.advance(0.1).success


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"torque": [0.0, math.nan, 0.0, 0.0]}, "torque: expected finite"),
        ({"azimuth_rate": [math.inf, 0.0, 0.0, 0.0]}, "azimuth_rate: expected finite"),
        ({"torque": [0.0, 0.0]}, r"torque: expected shape \(4,\), found \(2,\)"),
        ({"pitch_ratio": [0.81]}, r"pitch_ratio: expected shape \(4,\), found \(1,\)"),
        ({"pitch_ratio": [0.81, 1.14, math.nan, 1.01]}, "pitch_ratio: expected finite"),
        ({"pitch_ratio": [0.81, 1.14, 0.93, 0.7]}, "'azimuth_starboard' has a fixed pitch, expected 1.01, found 0.7"),
        ({"name": ["a", "b", "c", "d"]}, "name: expected .*tunnel_bow.*found .*'a'"),
        ({"command_stamp": from_nanoseconds(60 * 10**9)}, r"expected stamps up to 0\.200 s, found 60\.000 s"),
    ],
)
def test_a_bad_setpoint_is_refused_and_the_run_goes_on(
    graph: Callable[..., Graph], changed: dict[str, Any], message: str
) -> None:
    one = graph(**LOCKSTEP)
    one.advance(0.2)
    drivers = one.drivers
    drivers.answering = False
    done = one.ask(0.4)
    one.wait(lambda: len(drivers.poses) == 2, "the pose at 0.2 s")
    drivers.command_stamp = 10 * STEP
    drivers.answer(10 * STEP, **changed)
    one.wait(lambda: one.sim._refused == 1, "the set point was refused")
    assert re.search(message, one.sim._last_refusal)
    assert one.phase() is Phase.COMMAND
    drivers.answering = True
    drivers.answer(10 * STEP)
    one.wait(done.done, "the run went on")
    assert done.result().success


def test_a_lost_pose_is_marked_and_holds_the_last_measurement(graph: Callable[..., Graph]) -> None:
    one = graph(
        **LOCKSTEP, **{"initial.north": 3.0, "initial.heading": 0.5, "pose_dropout": 1.0, "sensor_noise": False}
    )
    one.advance(0.4)
    first = one.drivers.poses[0].pose
    assert first.covariance[0] == -1.0
    assert first.pose.position.x == 3.0
    assert quaternion_to_heading(0.0, 0.0, first.pose.orientation.z, first.pose.orientation.w) == pytest.approx(0.5)
    assert one.sim.set_parameters([Parameter("pose_dropout", value=0.0)])[0].successful
    one.advance(0.6)
    kept = one.drivers.poses[2].pose
    assert kept.covariance[0] == VESSEL.measurement.position_noise**2
    assert one.sim.set_parameters([Parameter("pose_dropout", value=1.0)])[0].successful
    one.advance(0.8)
    lost = one.drivers.poses[3].pose
    assert lost.covariance[0] == -1.0
    assert lost.pose == kept.pose
    assert one.sim.health().values["poses_lost"] == 3


def test_deactivation_ends_an_advance_and_no_stamp_comes_twice(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP)
    one.advance(0.2)
    one.drivers.answering = False
    done = one.ask(1.0)
    one.wait(lambda: len(one.drivers.poses) == 2, "the pose at 0.2 s")
    assert one.sim.trigger_deactivate() is TransitionCallbackReturn.SUCCESS
    one.wait(done.done, "the advance was answered")
    assert (done.result().success, done.result().message) == (False, "vessel_sim was deactivated")
    refused = one.advance(2.0)
    assert (refused.success, refused.message) == (False, "vessel_sim is not active")
    one.drivers.answering = True
    assert one.sim.trigger_activate() is TransitionCallbackReturn.SUCCESS
    assert one.advance(0.6).success
    for messages in (one.drivers.poses, one.drivers.feedback):
        seen = stamps(messages)
        assert seen == sorted(set(seen))


def test_clean_up_and_configure_begin_a_new_run(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP)
    one.advance(0.2)
    for transition in (one.sim.trigger_deactivate, one.sim.trigger_cleanup, one.sim.trigger_configure):
        assert transition() is TransitionCallbackReturn.SUCCESS
    assert one.sim.trigger_activate() is TransitionCallbackReturn.SUCCESS
    assert one.now() == 0.0
    one.drivers.command_stamp = 0
    assert one.advance(0.2).reached == 0.2


# Holding and pace -----------------------------------------------------------------------------------------------------


def test_advance_refuses_what_it_cannot_do(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP)
    one.advance(0.2)
    for until in (0.2, 0.0, -1.0, math.nan, math.inf):
        answer = one.advance(until)
        assert not answer.success
        assert answer.message == f"until: expected a finite time after 0.200 s, found {until}"
        assert answer.reached == 0.2
    one.drivers.answering = False
    first = one.ask(0.4)
    one.wait(lambda: len(one.drivers.poses) == 2, "the first advance is under way")
    second = one.advance(0.6)
    assert not second.success
    assert "is under way" in second.message
    one.drivers.answering = True
    one.drivers.command_stamp = 10 * STEP
    one.drivers.answer(10 * STEP)
    one.wait(first.done, "the first advance ended")
    assert first.result().reached == 0.4


def test_advance_stops_at_the_first_step_not_before_the_time_asked(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP)
    assert one.advance(0.05).reached == pytest.approx(0.06, abs=1e-12)
    assert one.advance(0.3).reached == pytest.approx(0.3, abs=1e-12)
    # Held before the pose at 0.3 s... and nothing of the next sample has been published.
    assert stamps(one.drivers.feedback)[-1] == 14 * STEP


def test_advance_without_hold_is_refused(graph: Callable[..., Graph]) -> None:
    one = graph(lockstep=False, rate=1.0)
    answer = one.advance(10.0)
    assert not answer.success
    assert answer.message.startswith("hold: expected true")


def test_real_time_goes_on_without_drivers_and_never_too_fast(graph: Callable[..., Graph]) -> None:
    began = time.monotonic()
    one = graph(rate=10.0)
    one.drivers.answering = False
    one.wait(lambda: one.now() >= 2.0, "two simulated seconds went by")
    assert (time.monotonic() - began) * 10.0 >= one.now()
    assert [alarm.kind.code for alarm in one.sim.health().alarms] == ["SIMULATOR-NO-SETPOINT"]
    one.wait(lambda: one.drivers.clock and one.drivers.clock[-1] >= 2 * 10**9, "the clock was heard")
    assert all(b - a == STEP for a, b in zip(one.drivers.clock, one.drivers.clock[1:], strict=False))


def test_real_time_uses_the_newest_set_point_and_keeps_it(graph: Callable[..., Graph]) -> None:
    one = graph(rate=10.0, setpoint_timeout=0.0)
    drivers = one.drivers
    drivers.answering = False
    one.wait(lambda: drivers.feedback, "feedback")
    drivers.answer(0, torque=[0.0, 0.0, 0.05, 0.0])
    one.wait(lambda: drivers.feedback[-1].torque[2] == 0.05, "the torque is delivered")
    heard = len(drivers.feedback)
    one.wait(lambda: len(drivers.feedback) > heard + 50, "a simulated second without set points")
    assert all(m.torque[2] == 0.05 for m in drivers.feedback[heard:])
    assert drivers.feedback[-1].shaft_speed[2] > 5.0
    drivers.answer(0, torque=[0.0, math.nan, 0.0, 0.0])
    one.wait(lambda: one.sim._refused == 1, "NaN was refused")
    heard = len(drivers.feedback)
    one.wait(lambda: len(drivers.feedback) > heard + 5, "time goes on")
    assert drivers.feedback[-1].torque[2] == 0.05


def test_drives_that_get_no_set_point_let_go_until_one_comes(graph: Callable[..., Graph]) -> None:
    one = graph(rate=5.0, setpoint_timeout=0.5)
    drivers = one.drivers
    drivers.answering = False
    one.wait(lambda: drivers.feedback, "feedback")
    for times in (1, 2):
        before = len(drivers.feedback)
        drivers.answer(0, torque=[0.0, 0.0, 0.05, 0.0], azimuth_rate=[0.0, 0.0, 0.2, 0.0])
        one.wait(lambda: drivers.feedback[-1].torque[2] == 0.05, "the torque is delivered")
        one.wait(lambda: drivers.feedback[-1].torque[2] == 0.0, "the drives to let go")
        held = [message.torque[2] for message in drivers.feedback[before:]].count(0.05) * 0.02
        # Whole steps of 0.02 s: the last begins half a second after the set point came.
        assert held == pytest.approx(0.52, abs=1e-9)
        one.wait(lambda: abs(drivers.feedback[-1].azimuth_rate[2]) < 0.02, "the azimuth motor to come to rest")
        assert one.sim.health().values["drives_cut"] == times


def test_a_simulator_that_is_started_again_goes_on_in_time_at_the_next_sample(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP, **{"start_time": 123.45, "initial.north": 2.0, "sensor_noise": False})
    assert one.advance(123.9).success
    seen = stamps(one.drivers.poses)
    assert seen[:2] == [123_600_000_000, 123_800_000_000]
    assert one.drivers.poses[0].pose.pose.position.x == pytest.approx(2.0, abs=1e-12)
    assert stamps(one.drivers.feedback)[0] == 123_600_000_000


def test_real_time_that_cannot_be_kept_says_so_and_still_listens(graph: Callable[..., Graph]) -> None:
    one = graph(rate=1e5)
    one.wait(lambda: one.sim.health().level is Level.WARN, "the lag is reported")
    health = one.sim.health()
    assert "cannot keep up" in health.message
    assert "asked 100000" in health.message
    assert health.values["time_not_kept_up_with"] > 0.0  # type: ignore[operator]
    heard = len(one.drivers.feedback)
    one.wait(lambda: len(one.drivers.feedback) > heard, "messages still flow")


def test_real_time_with_hold_stops_where_it_was_told(graph: Callable[..., Graph]) -> None:
    one = graph(rate=50.0, hold=True)
    assert one.advance(1.0).reached == pytest.approx(1.0, abs=1e-12)
    assert one.phase() is Phase.HELD
    assert one.advance(1.5).reached == pytest.approx(1.5, abs=1e-12)


def test_lockstep_at_a_rate(graph: Callable[..., Graph]) -> None:
    one = graph(**{**LOCKSTEP, "rate": 5.0})
    one.advance(0.02)
    began = time.monotonic()
    assert one.advance(2.0).success
    # Real time is the lower bound; how much longer it takes is the machine's affair. One step may be on credit.
    assert time.monotonic() - began >= (2.0 - 0.02 - 0.02) / 5.0
    # Without a limit from here on.
    assert one.sim.set_parameters([Parameter("rate", value=0.0)])[0].successful
    assert one.advance(3.0).success


# Parameters -----------------------------------------------------------------------------------------------------------


def test_parameters_change_the_sea_live_and_are_refused_whole(graph: Callable[..., Graph]) -> None:
    one = graph(**LOCKSTEP)
    one.advance(0.1)
    assert one.sim.set_parameters([Parameter("waves.amplitude", value=0.03)])[0].successful
    assert one.sim._simulator.settings.waves.amplitude == 0.03
    refused = one.sim.set_parameters_atomically(
        [Parameter("current.speed", value=0.2), Parameter("waves.amplitude", value=0.2)]
    )
    assert not refused.successful
    assert "expected height over length at most 1/7" in refused.reason
    assert one.sim._simulator.settings.current.speed == 0.0
    # From the regular waves to an irregular sea in one change, of which no part alone would do.
    sea = {"waves.kind": "jonswap", "waves.significant_height": 0.06, "waves.peak_period": 0.9, "waves.spreading": 10.0}
    assert one.sim.set_parameters_atomically([Parameter(name, value=value) for name, value in sea.items()]).successful
    simulator = one.sim._simulator
    assert isinstance(simulator, Simulator)
    assert len(simulator._waves.components) == 100
    refused = one.sim.set_parameters_atomically([Parameter("waves.peak_period", value=0.7)])
    assert not refused.successful
    assert "expected height over length at the peak at most 1/15" in refused.reason
    for name, value in (
        ("seed", 3),
        ("initial.north", 1.0),
        ("waves.maker_distance", 2.0),
        ("hold", False),
        ("lockstep", False),
    ):
        assert not one.sim.set_parameters([Parameter(name, value=value)])[0].successful


def test_no_limit_without_lockstep_is_refused_at_start_up(ros_domain_id: int) -> None:
    rclpy.init()
    try:
        with pytest.raises(InputError, match=r"rate: expected above 0 unless lockstep is on, found 0\.0"):
            VesselSimNode(parameter_overrides=[Parameter("rate", value=0.0)])
    finally:
        rclpy.try_shutdown()


def test_without_wind_forces_there_is_no_topic_and_no_wind(graph: Callable[..., Graph], tmp_path: Path) -> None:
    content = VESSEL.model_dump(mode="json", exclude={"wind_forces"}) | {"name": "bare"}
    path = tmp_path / "bare.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    one = graph(**LOCKSTEP, vessel=str(path))
    one.advance(0.2)
    assert one.drivers.count_publishers("wind") == 0
    (result,) = one.sim.set_parameters([Parameter("wind.speed", value=1.0)])
    assert not result.successful
    assert "wind.speed: expected 0, because vessel 'bare' has no section wind_forces" in result.reason
