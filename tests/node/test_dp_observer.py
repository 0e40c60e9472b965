"""The observer's node over real DDS: poses in, odometry out, and what it says when they fail."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from dp_msgs.msg import ObserverState
from geometry_msgs.msg import PoseWithCovarianceStamped, WrenchStamped
from nav_msgs.msg import Odometry

from dp_node import DpNode, from_nanoseconds, to_nanoseconds
from dp_node.stamps import BELIEVED
from dp_observer import Observer, ObserverInputs, ObserverSettings
from dp_observer.node import ObserverNode
from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME, MAP_FRAME, heading_to_quaternion, quaternion_to_heading
from marine_model.guards import FloatArray
from support.node_bench import NodeBench, node_bench

pytestmark = pytest.mark.usefixtures("ros_domain_id")

VESSEL = load_vessel("cybership3")
SAMPLE = 200_000_000  # ns
START = 7_000_000_000
NO_FORCE = np.zeros(3)


class ObserverBench:
    """Publishes poses and forces, hears odometry and state."""

    def __init__(self, bench: NodeBench) -> None:
        self.bench = bench
        self.pose = bench.publisher(PoseWithCovarianceStamped, "pose")
        self.force = bench.publisher(WrenchStamped, "tau_achieved")
        self.odometry: list[Odometry] = bench.hear(Odometry, "odometry")
        self.state: list[ObserverState] = bench.hear(ObserverState, "observer_state")

    @property
    def node(self) -> DpNode[Any]:
        return self.bench.node

    def send(
        self, stamp: int, position: FloatArray | list[float] | None, frame: str = MAP_FRAME, covariance: float = 0.0
    ) -> None:
        message = PoseWithCovarianceStamped()
        message.header.stamp, message.header.frame_id = from_nanoseconds(stamp), frame
        if position is None:
            covariance = -1.0
        else:
            pose = message.pose.pose
            pose.position.x, pose.position.y = float(position[0]), float(position[1])
            q = pose.orientation
            q.x, q.y, q.z, q.w = heading_to_quaternion(float(position[2]))
        message.pose.covariance[0] = covariance
        self.pose.publish(message)

    def answer(self, stamp: int, position: FloatArray | list[float] | None) -> tuple[Odometry, ObserverState]:
        """Send a pose and return what comes of it."""
        count = len(self.odometry)
        self.send(stamp, position)
        self.bench.wait_for("odometry", count + 1)
        self.bench.wait_for("observer_state", count + 1)
        assert len(self.odometry) == len(self.state) == count + 1
        return self.odometry[-1], self.state[-1]

    def push(self, stamp: int, tau: list[float], frame: str = BODY_FRAME) -> None:
        message = WrenchStamped()
        message.header.stamp, message.header.frame_id = from_nanoseconds(stamp), frame
        message.wrench.force.x, message.wrench.force.y, message.wrench.torque.z = tau
        self.force.publish(message)

    def refused(self, count: int) -> str:
        """Wait until ``count`` inputs have been refused in all, and the diagnostics say so; return the last reason."""
        self.bench.wait_until(
            lambda: self.node._refused == count, lambda: f"{count} refused, have {self.node._refused}"
        )
        assert self.bench.diagnostics()["refused_inputs"] == str(count)
        return str(self.node._last_refusal)


@pytest.fixture
def synchronous() -> Iterator[ObserverBench]:
    """A node without watchdog: nothing happens unless a message comes."""
    with node_bench(ObserverNode, synchronous=True) as bench:
        yield ObserverBench(bench)


@pytest.fixture
def watched() -> Iterator[ObserverBench]:
    with node_bench(ObserverNode) as bench:
        yield ObserverBench(bench)


def position_of(message: Odometry) -> list[float]:
    p, q = message.pose.pose.position, message.pose.pose.orientation
    return [p.x, p.y, quaternion_to_heading(q.x, q.y, q.z, q.w)]


def velocity_of(message: Odometry) -> list[float]:
    return [message.twist.twist.linear.x, message.twist.twist.linear.y, message.twist.twist.angular.z]


def test_odometry_is_the_cores_answer(synchronous: ObserverBench) -> None:
    core = Observer(VESSEL, ObserverSettings())
    tau = NO_FORCE
    for k in range(25):
        stamp = START + k * SAMPLE
        fix = np.array([0.1 * math.sin(k), 0.05 * math.cos(k), 0.3 + 0.01 * k])
        odometry, state = synchronous.answer(stamp, fix)
        expected = core.step(ObserverInputs(fix, tau), 0.2)
        assert to_nanoseconds(odometry.header.stamp) == to_nanoseconds(state.header.stamp) == stamp
        assert (odometry.header.frame_id, odometry.child_frame_id) == (MAP_FRAME, BODY_FRAME)
        # The heading passes through a quaternion, which rounds it; everything else is the same number.
        assert position_of(odometry) == pytest.approx(expected.position.tolist(), abs=1e-13)
        assert velocity_of(odometry) == pytest.approx(expected.velocity.tolist(), abs=1e-13)
        assert odometry.pose.covariance[0] == 0.0
        assert (state.valid, state.status) == (True, str(expected.status))
        assert state.bias.tolist() == pytest.approx(expected.bias.tolist(), abs=1e-12)
        assert state.innovation.tolist() == pytest.approx(expected.innovation.tolist(), abs=1e-13)
        assert state.wave_frequency_position.tolist() == pytest.approx(
            expected.wave_frequency_position.tolist(), abs=1e-13
        )
        tau = np.array([2.0, -1.0, 0.3]) * math.sin(0.5 * k)
        synchronous.push(stamp, tau.tolist())
    assert synchronous.bench.diagnostics()["message"] == "nominal"


def test_synchronous_waits_for_the_answer_to_the_sample_before(synchronous: ObserverBench) -> None:
    synchronous.answer(START, [0.0, 0.0, 0.0])
    synchronous.send(START + SAMPLE, [0.0, 0.0, 0.0])
    bench = synchronous.bench
    bench.wait_until(lambda: bench.diagnostics()["poses_held"] == "1")
    assert len(synchronous.odometry) == 1
    synchronous.push(START, [1.0, 0.0, 0.0])
    bench.wait_for("odometry", 2)
    assert to_nanoseconds(synchronous.odometry[1].header.stamp) == START + SAMPLE
    assert velocity_of(synchronous.odometry[1])[0] > 0.0  # the force was used
    assert bench.diagnostics()["poses_held"] == "0"


def test_a_pose_that_is_not_finite_is_refused_counted_and_dead_reckoned(synchronous: ObserverBench) -> None:
    core = Observer(VESSEL, ObserverSettings())
    for k in range(3):
        fix = [0.01 * k, 0.0, 0.1]
        synchronous.answer(START + k * SAMPLE, fix)
        synchronous.push(START + k * SAMPLE, [0.0, 0.0, 0.0])
        core.step(ObserverInputs(np.array(fix), NO_FORCE), 0.2)
    odometry, state = synchronous.answer(START + 3 * SAMPLE, [math.nan, 0.0, 0.1])
    expected = core.step(ObserverInputs(None, NO_FORCE), 0.2)
    assert state.status == "dead_reckoning"
    assert position_of(odometry) == pytest.approx(expected.position.tolist(), abs=1e-13)
    assert "pose: position: expected finite numbers, found [nan, 0.0" in synchronous.refused(1)
    assert synchronous.bench.diagnostics()["poses_without_fix"] == "1"
    synchronous.push(START + 3 * SAMPLE, [0.0, 0.0, 0.0])
    _, state = synchronous.answer(START + 4 * SAMPLE, [0.04, 0.0, 0.1])
    assert state.status == "nominal"


def test_a_heading_that_is_no_orientation_is_refused(watched: ObserverBench) -> None:
    message = PoseWithCovarianceStamped()
    message.header.stamp, message.header.frame_id = from_nanoseconds(START), MAP_FRAME
    message.pose.pose.orientation.w = 0.0
    watched.pose.publish(message)
    assert "pose: orientation: expected a unit quaternion, found (0.0, 0.0, 0.0, 0.0)" in watched.refused(1)


def test_a_stamp_that_jumps_back_is_refused(synchronous: ObserverBench) -> None:
    synchronous.bench.diagnostics()
    synchronous.answer(START, [0.0, 0.0, 0.0])
    synchronous.push(START, [0.0, 0.0, 0.0])
    synchronous.answer(START + SAMPLE, [0.0, 0.0, 0.0])
    synchronous.push(START + SAMPLE, [0.0, 0.0, 0.0])
    synchronous.send(START, [5.0, 5.0, 0.0])
    reason = "pose: expected a time stamp after 7.200 s, found 7.000 s"
    assert synchronous.refused(1) == reason
    # In words on /diagnostics, once: in the message just asked for or, if that came first, in the one of every second.
    said = [status.message for message in synchronous.bench.heard["/diagnostics"] for status in message.status]
    assert said.count(f"refused: {reason}") == 1
    synchronous.push(START, [9.0, 9.0, 9.0])
    assert "tau_achieved: expected a time stamp after 7.200 s, found 7.000 s" in synchronous.refused(2)
    odometry, state = synchronous.answer(START + 2 * SAMPLE, [0.0, 0.0, 0.0])
    assert state.status == "nominal"
    assert position_of(odometry) == [0.0, 0.0, 0.0]


def test_wrong_frames_and_bad_forces_are_refused(synchronous: ObserverBench) -> None:
    synchronous.answer(START, [0.0, 0.0, 0.0])
    synchronous.send(START + SAMPLE, [9.0, 0.0, 0.0], frame="map")
    assert "pose: expected frame_id 'map_ned', found 'map'" in synchronous.refused(1)
    synchronous.push(START, [1.0, 0.0, 0.0], frame="base_link")
    assert "tau_achieved: expected frame_id 'base_link_frd', found 'base_link'" in synchronous.refused(2)
    synchronous.push(START, [math.inf, 0.0, 0.0])
    assert "tau: expected finite numbers, found [inf, 0.0, 0.0]" in synchronous.refused(3)
    synchronous.push(START, [1e13, 0.0, 0.0])
    assert "tau: expected numbers within 1e+12" in synchronous.refused(4)
    synchronous.push(START, [0.0, 0.0, 0.0])
    odometry, _ = synchronous.answer(START + SAMPLE, [0.0, 0.0, 0.0])
    assert position_of(odometry) == [0.0, 0.0, 0.0]
    assert velocity_of(odometry) == [0.0, 0.0, 0.0]


def test_samples_without_fix_become_invalid_after_the_limit() -> None:
    with node_bench(ObserverNode, synchronous=True, dead_reckoning_limit=1.0) as made:
        bench = ObserverBench(made)
        stamp = START
        bench.answer(stamp, [1.0, 2.0, 0.0])
        for k in range(1, 8):
            bench.push(stamp, [0.0, 0.0, 0.0])
            stamp += SAMPLE
            odometry, state = bench.answer(stamp, None)
            valid = k <= 5
            assert state.valid is valid
            assert state.status == ("dead_reckoning" if valid else "invalid")
            assert odometry.pose.covariance[0] == (0.0 if valid else -1.0)
            assert state.time_since_measurement == pytest.approx(0.2 * k)
        found = made.diagnostics()
        assert found["level"] == 2
        text = found["alarm.OBSERVER-ESTIMATE-INVALID"]
        assert text == "estimate invalid: no usable position fix for too long"
        assert found["message"].startswith(text)
        bench.push(stamp, [0.0, 0.0, 0.0])
        odometry, state = bench.answer(stamp + SAMPLE, [50.0, 2.0, 0.0])
        assert (state.valid, state.status) == (True, "reinitialised")
        assert position_of(odometry) == [50.0, 2.0, 0.0]
        assert odometry.pose.covariance[0] == 0.0


def test_watchdog_goes_on_when_no_pose_comes(watched: ObserverBench) -> None:
    """In real time: the node's own clock decides when, the poses' time base what the stamps are."""
    watched.answer(START, [1.0, 0.0, 0.0])
    watched.bench.wait_for("odometry", 4)
    stamps = [to_nanoseconds(message.header.stamp) for message in watched.odometry[:4]]
    assert stamps == [START + k * SAMPLE for k in range(4)]
    assert [state.status for state in watched.state[1:4]] == ["dead_reckoning"] * 3
    # A pose of before what was published still counts, but time does not run back downstream.
    count = len(watched.odometry)
    watched.send(START + SAMPLE, [1.0, 0.0, 0.0])
    watched.bench.wait_until(lambda: watched.bench.diagnostics()["late_poses"] == "1")
    assert all(state.status == "dead_reckoning" for state in watched.state[count:])
    # One that is newer than anything published is answered as usual.
    newer = START + 1000 * SAMPLE
    for k in range(BELIEVED):  # one alone that is so far ahead is not believed
        watched.send(newer + k * SAMPLE, [1.0, 0.0, 0.0])
    watched.bench.wait_until(lambda: to_nanoseconds(watched.odometry[-1].header.stamp) >= newer)
    stamps = [to_nanoseconds(message.header.stamp) for message in watched.odometry]
    assert stamps == sorted(set(stamps))
    assert watched.bench.diagnostics()["estimates_without_pose"] != "0"


def test_watchdog_waits_for_the_first_pose(watched: ObserverBench) -> None:
    node = watched.node
    assert isinstance(node, ObserverNode)
    for _ in range(5):
        node._watch()
    found = watched.bench.diagnostics()
    assert (found["level"], found["estimates_without_pose"]) == (1, "0")
    assert {key for key in found if key.startswith("alarm.")} == {"alarm.OBSERVER-NO-FIX-YET", "alarm.OBSERVER-NO-POSE"}


def test_a_force_too_old_to_be_true_is_not_used(synchronous: ObserverBench) -> None:
    synchronous.answer(START, [0.0, 0.0, 0.0])
    synchronous.push(START, [10.0, 0.0, 0.0])
    late = START + round(VESSEL.drivers.command_timeout * 1e9) + SAMPLE
    odometry, _ = synchronous.answer(late, [0.0, 0.0, 0.0])
    assert velocity_of(odometry) == [0.0, 0.0, 0.0]


def test_outliers_are_counted_and_limits_change_live(synchronous: ObserverBench) -> None:
    synchronous.answer(START, [0.0, 0.0, 0.0])
    synchronous.push(START, [0.0, 0.0, 0.0])
    _, state = synchronous.answer(START + SAMPLE, [1.0, 0.0, 0.0])
    assert state.status == "outlier_refused"
    assert state.innovation.tolist() == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert synchronous.bench.diagnostics()["outliers"] == "1"
    result = synchronous.bench.set_parameters(innovation_limit=1.0, heading_innovation_limit=1.0)
    assert result.successful
    synchronous.push(START + SAMPLE, [0.0, 0.0, 0.0])
    _, state = synchronous.answer(START + 2 * SAMPLE, [1.0, 0.0, 0.0])
    assert state.status == "nominal"


def test_bad_parameters_are_refused_with_the_reason_and_nothing_changes(synchronous: ObserverBench) -> None:
    bench = synchronous.bench
    result = bench.set_parameters(innovation_limit=2.0, dead_reckoning_limit=-1.0)
    assert not result.successful
    assert "dead_reckoning_limit" in result.reason
    assert bench.node.settings == ObserverSettings()
    assert bench.node.get_parameter("innovation_limit").value == ObserverSettings().innovation_limit
    for values in ({"reacceptance_count": 2.5}, {"synchronous": False}, {"wave_frequency": 3.0}):
        result = bench.set_parameters(**values)
        assert not result.successful
        assert result.reason


def test_a_bad_parameter_at_start_is_refused_with_the_reason() -> None:
    with pytest.raises(InputError, match="innovation_limit"), node_bench(ObserverNode, innovation_limit=-1.0):
        pass


def test_an_activation_starts_anew(synchronous: ObserverBench) -> None:
    synchronous.answer(START, [3.0, 0.0, 0.0])
    synchronous.node.trigger_deactivate()
    synchronous.node.trigger_activate()
    # An earlier stamp and another place are welcome, and no answer is waited for.
    odometry, state = synchronous.answer(SAMPLE, [-3.0, 0.0, 0.0])
    assert state.status == "initialised"
    assert position_of(odometry) == [-3.0, 0.0, 0.0]
