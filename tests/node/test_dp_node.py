"""The base class of all nodes, through a node that echoes a wrench."""

from collections.abc import Callable, Iterator
from typing import Any, Literal

import pytest
from geometry_msgs.msg import WrenchStamped
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically

from dp_node import DpNode, Health
from marine_model.errors import InputError, UnknownNameError
from marine_model.guards import finite_number
from marine_model.settings import Settings, setting
from support.node_bench import NodeBench, node_bench

pytestmark = pytest.mark.usefixtures("ros_domain_id")


class Waves(Settings):
    amplitude: float = setting(0.1, "Wave amplitude", unit="m", ge=0.0, le=1.0)


class EchoSettings(Settings):
    mode: Literal["plain", "double"] = setting("plain", "What to send back")
    gain: float = setting(1.0, "Gain", ge=0.0)
    enabled: tuple[bool, ...] = setting((True, True), "Two flags")
    waves: Waves = setting(Waves(), "Waves")
    seed: int = setting(0, "Seed", ge=0, read_only=True)


class EchoNode(DpNode[EchoSettings]):
    def __init__(self, **kwargs: Any) -> None:
        super().__init__("echo", **kwargs)

    def default_settings(self, vessel: object) -> EchoSettings:
        return EchoSettings()

    def check(self, settings: EchoSettings) -> None:
        if settings.mode == "double" and settings.gain == 0.0:
            raise InputError("gain: expected a gain above 0 in mode double, found 0")

    def build(self) -> None:
        self.applied: list[EchoSettings] = []
        self.echo = self.publish_on(WrenchStamped, "pong")
        self.listen(WrenchStamped, "ping", self.on_ping)

    def apply(self, settings: EchoSettings) -> None:
        self.applied.append(settings)

    def on_ping(self, message: WrenchStamped) -> None:
        finite_number("ping.force.x", message.wrench.force.x)
        message.wrench.force.x *= self.settings.gain
        self.echo.publish(message)

    def health(self) -> Health:
        return Health(values={"gain": self.settings.gain})


@pytest.fixture
def bench(ros_domain_id: int) -> Iterator[NodeBench]:
    with node_bench(EchoNode) as one:
        yield one


def ping(force: float) -> WrenchStamped:
    message = WrenchStamped()
    message.wrench.force.x = force
    return message


def change_state(bench: NodeBench, transition: int) -> bool:
    client = bench.probe.create_client(ChangeState, "echo/change_state")
    bench.wait_until(client.service_is_ready)
    future = client.call_async(ChangeState.Request(transition=Transition(id=transition)))
    bench.wait_until(future.done)
    return bool(future.result().success)


def state(bench: NodeBench) -> int:
    client = bench.probe.create_client(GetState, "echo/get_state")
    bench.wait_until(client.service_is_ready)
    future = client.call_async(GetState.Request())
    bench.wait_until(future.done)
    return int(future.result().current_state.id)


def test_a_node_launched_alone_becomes_active_and_answers(bench: NodeBench) -> None:
    assert state(bench) == State.PRIMARY_STATE_ACTIVE
    bench.hear(WrenchStamped, "pong")
    bench.publisher(WrenchStamped, "ping").publish(ping(2.0))
    assert bench.wait_for("pong")[0].wrench.force.x == 2.0


@pytest.mark.parametrize(
    "transition", [Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_CLEANUP, 99]
)
def test_a_transition_that_its_state_does_not_have_is_refused_and_the_node_lives(
    bench: NodeBench, transition: int
) -> None:
    assert not change_state(bench, transition)
    assert state(bench) == State.PRIMARY_STATE_ACTIVE
    assert change_state(bench, Transition.TRANSITION_DEACTIVATE)


def test_a_refused_input_is_counted_and_the_next_one_answered(bench: NodeBench) -> None:
    bench.hear(WrenchStamped, "pong")
    publisher = bench.publisher(WrenchStamped, "ping")
    publisher.publish(ping(float("nan")))
    publisher.publish(ping(3.0))
    assert bench.wait_for("pong")[0].wrench.force.x == 3.0
    said = bench.diagnostics()
    assert said["refused_inputs"] == "1"
    assert said["level"] == 1
    assert "ping.force.x: expected a finite number, found nan" in said["message"]
    assert bench.diagnostics()["level"] == 0, "a refusal is a warning once, not for ever"


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"gain": -1.0}, "out of range"),
        ({"gain": 2}, "Wrong parameter type"),
        ({"gain": float("nan")}, "out of range"),
        ({"mode": "triple"}, "mode: Input should be 'plain' or 'double', found 'triple'"),
        ({"mode": "double", "gain": 0.0}, "gain: expected a gain above 0 in mode double, found 0"),
        ({"gain": 5.0, "waves__amplitude": 2.0}, "out of range"),
        ({"seed": 3}, "read-only"),
        ({"vessel": "cybership3_ch7"}, "read-only"),
    ],
)
def test_a_refused_change_gives_the_reason_and_keeps_every_old_value(
    bench: NodeBench, values: dict[str, Any], reason: str
) -> None:
    before = bench.node.settings
    result = bench.set_parameters(**values)
    assert not result.successful
    assert reason in result.reason
    assert bench.node.settings == before
    assert bench.node.applied == []


def test_related_parameters_change_together(bench: NodeBench) -> None:
    assert bench.set_parameters(mode="double", gain=4.0, waves__amplitude=0.2, enabled=[True, False]).successful
    expected = EchoSettings(mode="double", gain=4.0, waves=Waves(amplitude=0.2), enabled=(True, False))
    assert bench.node.settings == expected
    assert bench.node.applied == [expected]


def test_descriptors_carry_text_unit_choices_and_range(bench: NodeBench) -> None:
    amplitude = bench.node.describe_parameter("waves.amplitude")
    assert amplitude.description == "Wave amplitude [m]"
    assert (amplitude.floating_point_range[0].from_value, amplitude.floating_point_range[0].to_value) == (0.0, 1.0)
    assert "one of: plain, double" in bench.node.describe_parameter("mode").description
    assert bench.node.describe_parameter("seed").read_only


def test_an_inactive_node_is_silent_and_comes_back(bench: NodeBench) -> None:
    messages = bench.hear(WrenchStamped, "pong")
    publisher = bench.publisher(WrenchStamped, "ping")
    assert change_state(bench, Transition.TRANSITION_DEACTIVATE)
    publisher.publish(ping(1.0))
    bench.wait_until(lambda: bench.node.ignored == 1, "the message to be ignored")
    assert change_state(bench, Transition.TRANSITION_ACTIVATE)
    publisher.publish(ping(2.0))
    bench.wait_for("pong")
    assert [m.wrench.force.x for m in messages] == [2.0]


def test_clean_up_gives_topics_back_and_configure_makes_them_again(bench: NodeBench) -> None:
    assert change_state(bench, Transition.TRANSITION_DEACTIVATE)
    assert change_state(bench, Transition.TRANSITION_CLEANUP)
    bench.wait_until(lambda: bench.probe.count_publishers("pong") == 0, "pong to go")
    assert change_state(bench, Transition.TRANSITION_CONFIGURE)
    assert change_state(bench, Transition.TRANSITION_ACTIVATE)
    bench.hear(WrenchStamped, "pong")
    bench.publisher(WrenchStamped, "ping").publish(ping(2.0))
    assert bench.wait_for("pong")[0].wrench.force.x == 2.0


def test_without_autostart_a_node_waits_to_be_told() -> None:
    with node_bench(EchoNode, autostart=False) as bench:
        assert state(bench) == State.PRIMARY_STATE_UNCONFIGURED
        assert bench.set_parameters(gain=2.0).successful
        assert change_state(bench, Transition.TRANSITION_CONFIGURE)
        assert change_state(bench, Transition.TRANSITION_ACTIVATE)
        assert bench.node.settings.gain == 2.0


@pytest.mark.parametrize(
    ("parameters", "error", "text"),
    [
        ({"gain": -1.0}, InputError, "parameter gain: .*out of range"),
        ({"gain": 1}, InputError, "parameter gain: .*'INTEGER', expecting type 'DOUBLE'"),
        ({"mode": "double", "gain": 0.0}, InputError, "gain: expected a gain above 0"),
        ({"vessel": "titanic"}, UnknownNameError, "expected a path or one of cybership3, .*found 'titanic'"),
    ],
)
def test_what_is_refused_live_is_refused_at_start(
    parameters: dict[str, Any], error: type[Exception], text: str
) -> None:
    make: Callable[..., DpNode[Any]] = EchoNode
    with pytest.raises(error, match=text), node_bench(make, **parameters):
        pass


class FaultyNode(EchoNode):
    def build(self) -> None:
        super().build()
        raise InputError("sensor: expected a serial line, found none")


def test_a_node_that_cannot_configure_says_why_and_keeps_nothing() -> None:
    with (
        pytest.raises(InputError, match="sensor: expected a serial line, found none"),
        node_bench(FaultyNode),
    ):
        pass
    with node_bench(FaultyNode, autostart=False) as bench:
        assert not change_state(bench, Transition.TRANSITION_CONFIGURE)
        assert state(bench) == State.PRIMARY_STATE_UNCONFIGURED
        assert bench.probe.count_publishers("pong") == 0


@pytest.mark.parametrize("kind", [SetParameters, SetParametersAtomically])
def test_a_parameter_of_a_type_that_does_not_exist_is_refused_and_the_node_lives(bench: NodeBench, kind: Any) -> None:
    wrong = ParameterMessage(name="gain", value=ParameterValue(type=99))
    service = "set_parameters" if kind is SetParameters else "set_parameters_atomically"
    response = bench.call(kind, service, kind.Request(parameters=[wrong]))
    result = response.results[0] if kind is SetParameters else response.result
    assert not result.successful
    assert "parameter gain: expected a type from 0 to 9 of rcl_interfaces/ParameterType, found 99" in result.reason
    assert bench.set_parameters(gain=2.0).successful


def test_a_transition_that_does_not_exist_is_refused_and_the_node_lives(bench: NodeBench) -> None:
    assert not change_state(bench, 255)
    assert not change_state(bench, Transition.TRANSITION_CONFIGURE), "already configured"
    assert state(bench) == State.PRIMARY_STATE_ACTIVE


def test_a_parameter_cannot_be_undeclared(bench: NodeBench) -> None:
    unset = ParameterMessage(name="gain", value=ParameterValue(type=ParameterType.PARAMETER_NOT_SET))
    request = SetParametersAtomically.Request(parameters=[unset])
    assert not bench.call(SetParametersAtomically, "set_parameters_atomically", request).result.successful
    assert bench.node.get_parameter("gain").value == 1.0


def test_an_unknown_parameter_is_refused_by_its_name(bench: NodeBench) -> None:
    result = bench.set_parameters(gain=2.0, gian=3.0)
    assert (result.successful, result.reason) == (False, "no parameter 'gian'")
    assert bench.node.settings.gain == 1.0
