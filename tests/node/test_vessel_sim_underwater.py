"""The simulator node with an underwater vehicle over real DDS: depth and attitude in its messages, what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from dp_msgs.msg import ActuatorSetpoint, ThrusterFeedback
from geometry_msgs.msg import PoseWithCovarianceStamped, WrenchStamped
from nav_msgs.msg import Odometry

from dp_node import from_nanoseconds, to_nanoseconds
from marine_model import load_vessel
from marine_model.frames import quaternion_to_attitude
from support.node_bench import node_bench
from vessel_sim import CurrentSettings, InitialState, SimulatorInputs, SimulatorSettings, UnderwaterSimulator
from vessel_sim.node import VesselSimNode

VESSEL = load_vessel("ukwial")
N = len(VESSEL.thrusters)
TORQUE = [2.0, -0.5, -1.5, 1.0, 2.0, -1.5]
SAMPLES, EVERY = 4, round(VESSEL.measurement.sample_time / VESSEL.simulation.time_step)
SETTINGS = {"current__speed": 0.2, "current__direction": 1.0, "initial__depth": 8.0, "initial__heading": 0.4, "seed": 5}


def attitude(pose: PoseWithCovarianceStamped | Odometry) -> list[float]:
    """All six numbers of a pose message."""
    place, q = pose.pose.pose.position, pose.pose.pose.orientation
    return [place.x, place.y, place.z, *quaternion_to_attitude(q.x, q.y, q.z, q.w)]


def test_lockstep_is_the_core_step_by_step_in_six_degrees_of_freedom(ros_domain_id: int) -> None:
    with node_bench(VesselSimNode, vessel="ukwial", lockstep=True, rate=0.0, **SETTINGS) as bench:
        poses = bench.hear(PoseWithCovarianceStamped, "pose")
        truths = bench.hear(Odometry, "truth")
        environment = bench.hear(WrenchStamped, "environment_force")
        feedback = bench.hear(ThrusterFeedback, "thruster_feedback")
        setpoints = bench.publisher(ActuatorSetpoint, "actuator_setpoint")
        answered = 0

        def answer() -> bool:
            """Answer as drivers would, each pose and each feedback once."""
            nonlocal answered
            newest = poses[-1].header.stamp if poses else None
            while answered < len(poses) + len(feedback) and newest is not None:
                answered += 1
                stamp = feedback[-1].header.stamp if feedback else newest
                message = ActuatorSetpoint(
                    name=list(VESSEL.thruster_names), torque=TORQUE, azimuth_rate=[0.0] * N, command_stamp=newest
                )
                message.header.stamp = from_nanoseconds(max(to_nanoseconds(stamp), to_nanoseconds(newest)))
                setpoints.publish(message)
            return len(truths) >= SAMPLES and len(poses) >= SAMPLES and len(environment) >= SAMPLES

        bench.wait_until(answer, lambda: f"{SAMPLES} poses, have {len(poses)}; {bench.node.health()}")

    core = UnderwaterSimulator(
        VESSEL,
        SimulatorSettings.for_vessel(
            VESSEL,
            current=CurrentSettings(speed=0.2, direction=1.0),
            initial=InitialState(depth=8.0, heading=0.4),
            seed=5,
        ),
    )
    inputs = SimulatorInputs(np.array(TORQUE), np.zeros(N))
    for k in range(SAMPLES):
        measured, truth = core.measure(), core.truth()
        assert measured is not None
        # Through half angles and back: rounding.
        assert attitude(poses[k]) == pytest.approx(measured.tolist(), abs=1e-14)
        assert truth.vertical_position is not None
        assert truth.vertical_velocity is not None
        assert truth.current_force6 is not None
        north, east, heading = truth.position
        assert attitude(truths[k]) == pytest.approx([north, east, *truth.vertical_position, heading], abs=1e-14)
        twist = truths[k].twist.twist
        assert [twist.linear.z, twist.angular.x, twist.angular.y] == truth.vertical_velocity.tolist()
        assert [twist.linear.x, twist.linear.y] == pytest.approx(truth.velocity[:2].tolist(), abs=1e-15)
        wrench = environment[k].wrench
        pushed = [wrench.force.x, wrench.force.y, wrench.force.z, wrench.torque.x, wrench.torque.y, wrench.torque.z]
        assert pushed == truth.current_force6.tolist()
        for _ in range(EVERY):
            core.step(inputs, VESSEL.simulation.time_step)
    assert np.abs(attitude(truths[-1])[3:5]).max() > 1e-4  # it has left the horizontal plane
    data, covariance = VESSEL.measurement, poses[0].pose.covariance
    assert [covariance[i] for i in (0, 7, 14, 21, 28, 35)] == [
        sigma**2
        for sigma in (
            *(data.position_noise,) * 2,
            data.depth_noise,
            *(data.attitude_noise,) * 2,
            data.heading_noise,
        )
    ]


def test_waves_are_refused_below_the_surface(ros_domain_id: int) -> None:
    with node_bench(VesselSimNode, vessel="ukwial", lockstep=True) as bench:
        result = bench.set_parameters(waves__amplitude=0.1)
        assert not result.successful
        assert "waves.amplitude: expected 0, because nothing is known of what waves do to 'ukwial'" in result.reason
        # One length below the surface unless told otherwise.
        assert bench.node.settings.initial.depth == VESSEL.hull.length
