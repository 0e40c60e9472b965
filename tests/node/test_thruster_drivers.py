"""The drivers' node over real DDS: what it answers, refuses, and says of itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from dp_msgs.msg import ActuatorSetpoint, ThrusterCommand, ThrusterFeedback, Ventilation
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter

from dp_node import RING, RingExecutor, from_nanoseconds, to_nanoseconds
from marine_model import Vessel, load_vessel
from support.thruster_rig import LAWS, controllable_pitch_vessel
from support.waiting import wait_until
from thruster_drivers import DriverInputs, Drivers, DriverSettings
from thruster_drivers.controllers import CONTROLLERS, needs_pitch
from thruster_drivers.node import DriversNode
from thruster_drivers.shaft_model import shaft_models
from vessel_sim import Simulator, SimulatorInputs, SimulatorSettings

VESSEL = load_vessel("cybership3")
NAMES = list(VESSEL.thruster_names)
STEP = 20_000_000  # ns
START = 5_000_000_000
THRUST = [0.3, 5.0, -6.0, 7.0]
AZIMUTH = [math.pi / 2, 1.0, 2.0, 3.0]
REST = [0.0] * 4


class Bench:
    """The node under test, and a node beside it that plays allocator and thrusters."""

    def __init__(self, overrides: Sequence[Parameter] = ()) -> None:
        self.executor = RingExecutor()
        self.node = DriversNode(parameter_overrides=list(overrides))
        self.peer = Node("bench")
        self.setpoints: list[ActuatorSetpoint] = []
        self.diagnostics: list[Any] = []
        self.commands = self.peer.create_publisher(ThrusterCommand, "thruster_command", RING)
        self.feedback = self.peer.create_publisher(ThrusterFeedback, "thruster_feedback", RING)
        self.peer.create_subscription(ActuatorSetpoint, "actuator_setpoint", self.setpoints.append, RING)
        self.peer.create_subscription(
            DiagnosticArray, "/diagnostics", lambda m: self.diagnostics.extend(m.status), RING
        )
        self.executor.add_node(self.node)
        self.executor.add_node(self.peer)
        self.node.start()
        self.until(
            lambda: (
                self.commands.get_subscription_count() == 1
                and self.feedback.get_subscription_count() == 1
                and self.peer.count_publishers("actuator_setpoint") == 1
                and self.node.count_subscribers("actuator_setpoint") == 1
            )
        )

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.peer.destroy_node()

    def until(self, condition: Callable[[], object]) -> None:
        wait_until(condition, spin=lambda s: self.executor.spin_once(timeout_sec=s))

    def command(
        self,
        stamp: int,
        thrust: Sequence[float] = THRUST,
        azimuth: Sequence[float] = AZIMUTH,
        names: Sequence[str] = NAMES,
    ) -> None:
        message = ThrusterCommand(name=list(names), thrust=list(thrust), azimuth=list(azimuth))
        message.header.stamp = from_nanoseconds(stamp)
        self.commands.publish(message)

    def measure(
        self,
        stamp: int,
        shaft_speed: Sequence[float] = REST,
        names: Sequence[str] = NAMES,
        pitch: Sequence[float] = (),
    ) -> None:
        message = ThrusterFeedback(name=list(names), shaft_speed=list(shaft_speed), pitch_ratio=list(pitch))
        message.torque = message.power = message.azimuth_rate = REST
        message.azimuth = [AZIMUTH[NAMES.index(name)] for name in names]
        message.header.stamp = from_nanoseconds(stamp)
        self.feedback.publish(message)

    def answer(self, send: Callable[[], None]) -> ActuatorSetpoint:
        """Send one message and return the one setpoint it brings."""
        before = len(self.setpoints)
        send()
        self.until(lambda: len(self.setpoints) > before)
        assert len(self.setpoints) == before + 1
        return self.setpoints[-1]

    def refused(self, send: Callable[[], None]) -> str:
        """Send one message that must be refused and counted; return the reason. No setpoint may come of it."""
        before = len(self.setpoints)
        count = self.node._refused
        send()
        self.until(lambda: self.node._refused == count + 1)
        assert self.health()[2]["refused_inputs"] == str(count + 1)
        assert len(self.setpoints) == before
        return str(self.node._last_refusal)

    def health(self) -> tuple[int, str, dict[str, str]]:
        self.diagnostics.clear()
        self.node.publish_diagnostics()
        self.until(lambda: self.diagnostics)
        status = self.diagnostics[-1]
        return int.from_bytes(status.level, "little"), status.message, {v.key: v.value for v in status.values}


def core_inputs(age: float, shaft_speed: Sequence[float] = REST, turned: float = 0.0) -> DriverInputs:
    """What the core gets of the messages that a Bench sends; ``turned``: the command's azimuth over the measured."""
    measured = np.array(AZIMUTH)
    return DriverInputs(np.array(THRUST), measured + turned, age, np.array(shaft_speed), np.zeros(4), measured)


def vessel_file(vessel: Vessel, folder: Path) -> str:
    """Write ``vessel`` where a node can load it from."""
    file = folder / "vessel.yaml"
    file.write_text(yaml.safe_dump(vessel.model_dump(mode="json")), encoding="utf-8")
    return str(file)


@pytest.fixture
def ros(ros_domain_id: int) -> Iterator[None]:
    rclpy.init()
    yield
    rclpy.shutdown()


@pytest.fixture
def bench(ros: None) -> Iterator[Bench]:
    made = Bench()
    yield made
    made.close()


def test_answers_are_the_cores_with_stamps_and_names(bench: Bench) -> None:
    core = Drivers(VESSEL)
    acknowledged = bench.answer(lambda: bench.command(START))
    assert to_nanoseconds(acknowledged.command_stamp) == START
    assert list(acknowledged.torque) == REST
    assert not acknowledged.command_stale
    speed = [1.0, 2.0, -3.0, 4.0]
    for k in range(20):
        stamp = START + k * STEP
        answer = bench.answer(partial(bench.measure, stamp, speed))
        expected = core.step(
            core_inputs(k * 0.02, speed),
            0.02,
        )
        assert to_nanoseconds(answer.header.stamp) == stamp
        assert to_nanoseconds(answer.command_stamp) == START
        assert list(answer.name) == NAMES
        assert list(answer.torque) == pytest.approx(expected.torque.tolist(), rel=1e-12)  # dt's rounding
        assert list(answer.azimuth_rate) == expected.azimuth_rate.tolist()
        assert list(answer.pitch_ratio) == VESSEL.pitch_ratio.tolist()
        assert not answer.command_stale
    # A new command is acknowledged with the last torque, without a control step.
    again = bench.answer(lambda: bench.command(START + 20 * STEP))
    assert list(again.torque) == list(answer.torque)
    assert to_nanoseconds(again.command_stamp) == START + 20 * STEP


def test_names_in_another_order_mean_the_same(bench: Bench) -> None:
    order = [2, 0, 3, 1]
    names = [NAMES[i] for i in order]
    bench.answer(lambda: bench.command(START, [THRUST[i] for i in order], [AZIMUTH[i] + 0.1 for i in order], names))
    speed = [1.0, 2.0, -3.0, 4.0]
    answer = bench.answer(lambda: bench.measure(START, [speed[i] for i in order], names))
    expected = Drivers(VESSEL).step(
        core_inputs(0.0, speed, 0.1),
        0.02,
    )
    assert list(answer.torque) == expected.torque.tolist()
    assert list(answer.azimuth_rate) == expected.azimuth_rate.tolist()


def test_no_command_then_stale_then_recovered(bench: Bench) -> None:
    first = bench.answer(lambda: bench.measure(START))
    assert first.command_stale
    assert list(first.torque) == REST
    assert to_nanoseconds(first.command_stamp) == 0
    assert bench.health()[1] == "no thruster_command yet: no thrust"

    bench.answer(lambda: bench.command(START))
    stamp = START
    for _ in range(5):
        stamp += STEP
        assert not bench.answer(partial(bench.measure, stamp)).command_stale
    assert bench.health()[:2] == (0, "nominal")

    stamp += round(VESSEL.drivers.command_timeout * 1e9)
    assert bench.answer(lambda: bench.measure(stamp)).command_stale
    level, message, values = bench.health()
    assert (level, message) == (1, "thruster_command is stale: thrust is ramped to zero, azimuth held")
    assert float(values["command_age_s"]) == pytest.approx(1.1)

    bench.answer(lambda: bench.command(stamp))
    stamp += STEP
    assert not bench.answer(lambda: bench.measure(stamp)).command_stale
    assert bench.health()[:2] == (0, "nominal")


@pytest.mark.parametrize(
    ("thrust", "azimuth", "names", "reason"),
    [
        ([math.nan, 0.0, 0.0, 0.0], AZIMUTH, NAMES, "thrust: expected finite numbers, found [nan, 0.0, 0.0, 0.0]"),
        (THRUST, [0.0, 0.0, 0.0, math.inf], NAMES, "azimuth: expected finite numbers"),
        (THRUST[:2], AZIMUTH, NAMES, "thrust: expected shape (4,), found (2,)"),
        (THRUST, AZIMUTH, [*NAMES[:3], "rudder"], "name: expected ['tunnel_bow'"),
    ],
)
def test_a_bad_command_is_refused_and_the_last_good_one_kept(
    bench: Bench, thrust: list[float], azimuth: list[float], names: list[str], reason: str
) -> None:
    core = Drivers(VESSEL)
    bench.answer(lambda: bench.command(START))
    bench.answer(lambda: bench.measure(START))
    assert reason in bench.refused(lambda: bench.command(START + STEP, thrust, azimuth, names))
    answer = bench.answer(lambda: bench.measure(START + STEP))
    for age in (0.0, 0.02):
        expected = core.step(core_inputs(age), 0.02)
    assert to_nanoseconds(answer.command_stamp) == START
    assert list(answer.torque) == pytest.approx(expected.torque.tolist(), rel=1e-12)  # dt's rounding


def test_a_command_beyond_the_limits_is_clipped_and_counted(bench: Bench) -> None:
    bench.answer(lambda: bench.command(START, [9.0, 5.0, -60.0, 7.0]))
    bench.answer(lambda: bench.measure(START))
    values = bench.health()[2]
    assert values["clipped_commands"] == "1"
    assert values["last_clipped"] == "tunnel_bow azimuth_port"


def test_stamps_that_jump_are_refused(bench: Bench) -> None:
    bench.answer(lambda: bench.command(START))
    bench.answer(lambda: bench.measure(START))
    reason = bench.refused(lambda: bench.measure(START - STEP))
    assert reason == "thruster_feedback: expected a time stamp after 5.000 s, found 4.980 s"
    reason = bench.refused(lambda: bench.command(START - 1_000_000_000))
    assert reason == "thruster_command: expected a time stamp after 5.000 s, found 4.000 s"
    reason = bench.refused(lambda: bench.command(9_000_000_000))
    assert "at most 1.0 s after the last thruster_feedback, at 5.000 s, found 9.000 s" in reason
    assert to_nanoseconds(bench.answer(lambda: bench.command(START + STEP)).command_stamp) == START + STEP
    assert to_nanoseconds(bench.answer(lambda: bench.measure(START + STEP)).header.stamp) == START + STEP


def test_feedback_of_the_wrong_length_is_refused_and_a_lost_sensor_is_not(bench: Bench) -> None:
    bench.answer(lambda: bench.command(START))
    assert "shaft_speed: expected shape (4,), found (3,)" in bench.refused(lambda: bench.measure(START, REST[:3]))
    answer = bench.answer(lambda: bench.measure(START, [0.0, math.nan, 0.0, 0.0]))
    assert np.isfinite(answer.torque).all()
    level, message, _ = bench.health()
    assert level == 2
    assert "open loop" in message


def test_timeout_is_a_live_parameter_and_a_bad_one_is_refused(bench: Bench) -> None:
    bench.answer(lambda: bench.command(START))
    assert bench.node.get_parameter("command_timeout").value == VESSEL.drivers.command_timeout
    result = bench.node.set_parameters([Parameter("command_timeout", value=-1.0)])[0]
    assert not result.successful
    result = bench.node.set_parameters([Parameter("controller", value="magic")])[0]
    assert not result.successful
    assert "controller" in result.reason
    assert not bench.answer(lambda: bench.measure(START + 5 * STEP)).command_stale
    assert bench.node.set_parameters([Parameter("command_timeout", value=0.1)])[0].successful
    assert bench.answer(lambda: bench.measure(START + 6 * STEP)).command_stale


def test_a_law_is_a_live_parameter_and_one_that_a_thruster_cannot_follow_is_refused(bench: Bench) -> None:
    bench.answer(lambda: bench.command(START))
    speed = [1.0, 2.0, -3.0, 4.0]
    before = bench.answer(lambda: bench.measure(START, speed))
    assert bench.node.set_parameters([Parameter("controller", value="torque,power,combined,shaft_speed")])[0].successful
    assert bench.health()[2]["controller"] == "torque,power,combined,shaft_speed"
    core = Drivers(VESSEL)
    core.step(core_inputs(0.0, speed), 0.02)
    core.apply(DriverSettings(controller="torque,power,combined,shaft_speed"))
    after = bench.answer(lambda: bench.measure(START + STEP, speed))
    assert list(after.torque) == pytest.approx(core.step(core_inputs(0.02, speed), 0.02).torque.tolist(), rel=1e-12)
    assert list(after.torque) != list(before.torque)
    result = bench.node.set_parameters([Parameter("controller", value="torque,torque,pitch,torque")])[0]
    assert not result.successful
    assert "azimuth_port" in result.reason
    assert "'pitch'" in result.reason
    assert bench.node.get_parameter("controller").value == "torque,power,combined,shaft_speed"


def test_pitch_goes_from_feedback_to_set_point(ros: None, tmp_path: Path) -> None:
    vessel = controllable_pitch_vessel()
    bench = Bench(
        [Parameter("vessel", value=vessel_file(vessel, tmp_path)), Parameter("controller", value="torque_pitch")]
    )
    try:
        core = Drivers(vessel, DriverSettings(controller="torque_pitch"))
        bench.answer(lambda: bench.command(START))
        order = [2, 0, 3, 1]
        pitch = [0.7, 0.9, 1.1, 1.3]
        for k in range(3):
            answer = bench.answer(
                lambda k=k: bench.measure(
                    START + k * STEP, names=[NAMES[i] for i in order], pitch=[pitch[i] for i in order]
                )
            )
            expected = core.step(replace(core_inputs(k * 0.02), pitch_ratio=np.array(pitch)), 0.02)
            # dt's rounding
            assert list(answer.pitch_ratio) == pytest.approx(expected.pitch_ratio.tolist(), rel=1e-9)
        assert np.all(np.abs(np.array(answer.pitch_ratio) - pitch) <= 3 * 0.4 * 0.02 + 1e-9)
        assert np.all(np.array(answer.pitch_ratio) < pitch)  # on the way to 0.6
        reason = bench.refused(lambda: bench.measure(START + 4 * STEP, pitch=pitch[:3]))
        assert "pitch_ratio: expected shape (4,), found (3,)" in reason
    finally:
        bench.close()


def test_deactivation_leaves_the_motors_without_torque(bench: Bench) -> None:
    bench.answer(lambda: bench.command(START))
    moving = bench.answer(lambda: bench.measure(START))
    assert any(moving.torque)
    last = bench.answer(bench.node.trigger_deactivate)
    assert list(last.torque) == REST
    assert list(last.azimuth_rate) == REST
    assert last.command_stale
    bench.node.trigger_activate()
    # An earlier stamp is welcome after a new start, and the old command is forgotten.
    answer = bench.answer(lambda: bench.measure(STEP))
    assert answer.command_stale
    assert to_nanoseconds(answer.command_stamp) == 0


def test_ventilation_follows_every_feedback_with_its_stamp(bench: Bench) -> None:
    heard: list[Ventilation] = []
    bench.peer.create_subscription(Ventilation, "ventilation", heard.append, RING)
    bench.until(lambda: bench.node.count_subscribers("ventilation") == 1)
    speed, core = [0.0, 0.0, 20.0, -20.0], Drivers(VESSEL)
    load = VESSEL.propellers.torque(np.array(speed))
    bench.answer(lambda: bench.command(START))
    for k in range(30):
        torque = load if k < 10 else 0.2 * load
        message = ThrusterFeedback(name=NAMES, shaft_speed=speed, torque=torque.tolist(), azimuth=AZIMUTH)
        message.power = message.azimuth_rate = REST
        message.header.stamp = from_nanoseconds(START + k * STEP)
        bench.answer(partial(bench.feedback.publish, message))
        inputs = replace(core_inputs(k * 0.02, speed), torque=torque)
        expected = core.step(inputs, 0.02)
        bench.until(lambda: len(heard) == k + 1)  # noqa: B023 - called before k changes
        found = heard[-1]
        assert to_nanoseconds(found.header.stamp) == START + k * STEP
        assert list(found.name) == NAMES
        assert list(found.ventilating) == expected.ventilating.tolist()
        assert list(found.beta_q) == pytest.approx(expected.beta_q.tolist(), rel=1e-9)  # dt's rounding
        assert list(found.beta_q2) == pytest.approx(expected.beta_q2.tolist(), rel=1e-9)
    assert list(heard[-1].ventilating) == [False, False, True, True]
    values = bench.health()[2]
    assert [values[f"ventilation_events.{name}"] for name in NAMES] == ["0", "0", "1", "1"]

    refused = bench.node.set_parameters([Parameter("ventilation.on", value=0.9)])[0]
    assert not refused.successful
    assert "on must be below off" in refused.reason
    assert bench.node.set_parameters([Parameter("ventilation.enabled", value=False)])[0].successful
    # Without detection: no flag and no loss, for every feedback all the same. Anti-spin allocation waits for it.
    for k in (30, 31):
        bench.answer(partial(bench.measure, START + k * STEP, speed))
        bench.until(lambda: len(heard) == k + 1)  # noqa: B023 - called before k changes
        assert to_nanoseconds(heard[-1].header.stamp) == START + k * STEP
        assert list(heard[-1].ventilating) == [False] * 4
        assert list(heard[-1].beta_q) == list(heard[-1].beta_q2) == [1.0] * 4
    assert "ventilation_events.azimuth_port" not in bench.health()[2]


def _round_trip(laws: Sequence[str]) -> list[str]:
    """Return laws in an order in which each follows each other one; it begins after the first and ends with it."""
    left = {law: [other for other in laws if other != law] for law in laws}
    path, trip = [laws[0]], []  # Hierholzer: an Eulerian circuit of the complete directed graph
    while path:
        if left[path[-1]]:
            path.append(left[path[-1]].pop())
        else:
            trip.append(path.pop())
    return trip[::-1][1:]


def test_all_laws_follow_each_other_while_thrusters_turn(ros: None, tmp_path: Path) -> None:
    """Each law of eight takes over from each other one by parameter, the simulator's thrusters behind the messages.

    At a switch the torque goes on from where it was, and every answer is the core's.
    """
    vessel = controllable_pitch_vessel()
    bench = Bench([Parameter("vessel", value=vessel_file(vessel, tmp_path))])
    simulator = Simulator(vessel, SimulatorSettings(sensor_noise=False))
    client = bench.peer.create_client(SetParameters, "thruster_drivers/set_parameters")
    core = Drivers(vessel, DriverSettings(command_timeout=60.0))
    stamp, told, pitch, expected = START, [], [], []
    thrust = np.array([0.4, 5.0, -6.0, 7.0])

    def sail(samples: int) -> None:
        nonlocal stamp
        for _ in range(samples):
            output = simulator.output
            message = ThrusterFeedback(name=NAMES)
            for field in ("shaft_speed", "torque", "power", "azimuth", "azimuth_rate", "pitch_ratio"):
                setattr(message, field, getattr(output, field).tolist())
            message.header.stamp = from_nanoseconds(stamp)
            answer = bench.answer(partial(bench.feedback.publish, message))
            told.append(np.array(answer.torque))
            pitch.append(np.array(answer.pitch_ratio))
            inputs = DriverInputs(
                thrust, np.array(AZIMUTH), 0.0, output.shaft_speed, output.torque, output.azimuth, output.pitch_ratio
            )
            expected.append(core.step(inputs, 0.02))
            np.testing.assert_allclose(told[-1], expected[-1].torque, rtol=1e-9, atol=1e-12)  # dt's rounding
            simulator.step(SimulatorInputs(told[-1], np.array(answer.azimuth_rate), pitch[-1]), 0.02)
            stamp += STEP

    try:
        bench.until(client.service_is_ready)
        assert bench.node.set_parameters([Parameter("command_timeout", value=60.0)])[0].successful
        bench.answer(lambda: bench.command(stamp, thrust.tolist()))
        sail(100)
        gains = vessel.drivers.shaft_speed
        gain = np.array([2.0 * math.pi * model.inertia * gains.bandwidth for model in shaft_models(vessel)])
        # Every ordered pair of eight laws once: a round trip over the complete graph.
        for law in _round_trip(LAWS):
            request = SetParameters.Request(parameters=[Parameter("controller", value=law).to_parameter_msg()])
            future = client.call_async(request)
            bench.until(future.done)
            assert future.result().results[0].successful, law
            core.apply(DriverSettings(controller=law, command_timeout=60.0))
            before, at = told[-1], simulator.output
            sail(1)
            # A law of shaft speed has moved its integral by one sample, and pitch control its feedforward by what the
            # blades turn in one; the others stay at what was in force until the thrust reference moves.
            moved, desired = np.zeros(4), expected[-1].shaft_speed_reference
            if law in ("shaft_speed", "pitch", "shaft_speed_pitch"):
                moved = gain * (desired - at.shaft_speed) * 0.02 / gains.integral_time
            if law == "pitch":
                for j, model in enumerate(vessel.propeller_models):
                    ratios = np.array([at.pitch_ratio[j], pitch[-1][j]])
                    _, load = model.forces(desired[j], 0.0, vessel.density, ratios)
                    moved[j] += load[1] - load[0]
            # dt's rounding, and the drivers read the load off a fine table over the pitch.
            np.testing.assert_allclose(told[-1] - before, moved, rtol=1e-5, atol=1e-9, err_msg=law)
            sail(9)
        assert all(np.all((ratio >= 0.5) & (ratio <= 1.4)) for ratio in pitch)
        assert np.ptp(pitch, axis=0).min() > 0.1  # so that pitch laws had their say
        assert bench.health()[:2] == (0, "nominal")
    finally:
        bench.close()


def test_a_law_of_pitch_is_refused_by_the_service_where_the_pitch_is_fixed(bench: Bench) -> None:
    client = bench.peer.create_client(SetParameters, "thruster_drivers/set_parameters")
    bench.until(client.service_is_ready)
    for law in filter(needs_pitch, CONTROLLERS):
        request = SetParameters.Request(parameters=[Parameter("controller", value=law).to_parameter_msg()])
        future = client.call_async(request)
        bench.until(future.done)
        (result,) = future.result().results
        assert not result.successful
        assert f"expected a law for a fixed pitch at thruster 'tunnel_bow', found '{law}'" in result.reason
    assert bench.health()[2]["controller"] == "shaft_speed"


@pytest.mark.parametrize(
    ("field", "value", "reason"),
    [
        ("torque", [0.0] * 3, "torque: expected shape (4,), found (3,)"),
        ("torque", [], "torque: expected shape (4,), found (0,)"),
        ("azimuth", [0.0] * 5, "azimuth: expected shape (4,), found (5,)"),
        ("pitch_ratio", [1.0], "pitch_ratio: expected shape (4,), found (1,)"),
        ("name", [*NAMES[:3], "rudder"], "name: expected ['tunnel_bow'"),
    ],
)
def test_feedback_with_a_wrong_array_is_refused_and_nothing_is_told_of_ventilation(
    bench: Bench, field: str, value: list[Any], reason: str
) -> None:
    heard: list[Ventilation] = []
    bench.peer.create_subscription(Ventilation, "ventilation", heard.append, RING)
    bench.until(lambda: bench.node.count_subscribers("ventilation") == 1)
    content = dict.fromkeys(("shaft_speed", "torque", "power", "azimuth", "azimuth_rate"), REST) | {"name": NAMES}
    message = ThrusterFeedback(**(content | {field: value}))
    message.header.stamp = from_nanoseconds(START)
    assert reason in bench.refused(lambda: bench.feedback.publish(message))
    bench.answer(lambda: bench.measure(START))  # the same stamp is still unused
    bench.until(lambda: heard)
    assert [to_nanoseconds(one.header.stamp) for one in heard] == [START]
