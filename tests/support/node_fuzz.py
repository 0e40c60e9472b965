"""One real node under arbitrary messages, parameters and transitions, handed to its callbacks one after the other.

A rule of the state machine is one case. What must hold after each: nothing was raised, nothing that is not finite was
published, and a message that is not finite where the node reads it was refused or told of.
"""

from __future__ import annotations

import copy
import math
import typing
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule, run_state_machine_as_test
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter

from dp_node import DpNode, from_nanoseconds
from dp_node.parameters import limits, parameter_field
from marine_model.frames import BODY_FRAME, MAP_FRAME
from marine_model.settings import parameters_of
from support.node_bench import NodeBench

STEPS = 25  # cases in a row on one activation
SAMPLE = 200_000_000  # ns

ODD = st.sampled_from([math.nan, math.inf, -math.inf, 5e-324, 2.3e-308, 1e308, -1e308, 1e200, 1e20, -0.0, 0.0])
FLOATS = st.one_of(ODD, st.floats(-100.0, 100.0), st.floats())
TEXTS = st.one_of(
    st.sampled_from([BODY_FRAME, MAP_FRAME, "", "bow_tunnel", "base_link"]),
    st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=6),
)


@dataclass(frozen=True)
class Input:
    """A topic that a node hears.

    Attributes
    ----------
    good
        Returns a message that the node takes, by its stamp in ns.
    reads
        Fields that have to be finite, with dots.
    unread
        Tells of a message in which they need not be.
    """

    topic: str
    good: Callable[[int], Any]
    reads: tuple[str, ...] = ()
    unread: Callable[[Any], bool] = lambda message: False


@dataclass(frozen=True)
class Target:
    """A node and how it is fuzzed.

    Attributes
    ----------
    may_be_nan
        Fields of its messages that are not a number, or infinite, where the page says so, by the message's type.
    tells
        Returns whether the node has told of a message that was not finite, other than by refusing it.
    timers
        Names of what the node's timers call.
    """

    inputs: tuple[Input, ...]
    may_be_nan: dict[str, frozenset[str]] = field(default_factory=dict)
    tells: Callable[[Any], bool] = lambda node: False
    timers: tuple[str, ...] = ()


def leaves(message: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Every field of a message that is no message, with dots."""
    for name in message.get_fields_and_field_types():
        value = getattr(message, name)
        if hasattr(value, "get_fields_and_field_types"):
            yield from leaves(value, f"{prefix}{name}.")
        elif isinstance(value, list | tuple) and value and hasattr(value[0], "get_fields_and_field_types"):
            for i, one in enumerate(value):
                yield from leaves(one, f"{prefix}{name}.{i}.")
        else:
            yield prefix + name, value


def put(message: Any, path: str, value: Any) -> None:
    """Set a field of a message, with dots."""
    *groups, last = path.split(".")
    for group in groups:
        message = message[int(group)] if group.isdigit() else getattr(message, group)
    setattr(message, last, value)


def is_finite(value: Any) -> bool:
    """Whether every number in a field is finite."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, array | np.ndarray | list | tuple) and len(value) and isinstance(value[0], float):
        return bool(np.isfinite(np.asarray(value)).all())
    return True


def replacement(path: str, value: Any) -> st.SearchStrategy[Any]:
    """What may stand in a field instead."""
    if path.endswith("nanosec"):
        return st.integers(0, 2**32 - 1)
    if path.endswith(".sec"):
        return st.one_of(st.integers(-(2**31), 2**31 - 1), st.integers(0, 200))
    if isinstance(value, bool):
        return st.booleans()
    if isinstance(value, int):
        return st.integers(0, 100)
    if isinstance(value, float):
        return FLOATS
    if isinstance(value, str):
        return TEXTS
    if isinstance(value, np.ndarray):
        return st.lists(FLOATS, min_size=len(value), max_size=len(value)).map(np.array)
    if isinstance(value, array) and value.typecode == "h":
        return st.lists(st.integers(-(2**15), 2**15 - 1), max_size=8).map(lambda numbers: array("h", numbers))
    if isinstance(value, array):
        n = len(value)
        numbers = st.one_of(st.lists(FLOATS, min_size=n, max_size=n), st.lists(FLOATS, max_size=8))
        return numbers.map(lambda numbers: array("d", numbers))
    if isinstance(value, list) and all(isinstance(one, str) for one in value):
        return st.one_of(st.permutations(value), st.lists(TEXTS, max_size=6))
    return st.just(value)


def plausible(node: DpNode[Any], name: str) -> st.SearchStrategy[Any]:
    """A value that a parameter may well take."""
    model, value = type(node.settings), parameters_of(node.settings)[name]
    declared = parameter_field(model, name)
    if typing.get_origin(declared.annotation) is typing.Literal:
        return st.sampled_from(typing.get_args(declared.annotation))
    low, high = limits(declared)
    least = -10.0 if low is None else float(low)
    most = 1e6 if high is None else float(high)
    number = st.one_of(
        st.floats(least, min(most, least + 10.0)), st.floats(least, most), st.sampled_from([least, most])
    )
    if isinstance(value, bool):
        return st.booleans()
    if isinstance(value, int):
        return st.integers(int(least), int(min(most, least + 50)))
    if isinstance(value, float):
        return number
    if isinstance(value, tuple):
        one = st.booleans() if value and isinstance(value[0], bool) else number
        return st.lists(one, min_size=len(value), max_size=len(value))
    return TEXTS


ANYTHING = st.one_of(
    FLOATS,
    st.integers(-(2**63), 2**63 - 1),
    st.booleans(),
    TEXTS,
    st.lists(FLOATS, max_size=6),
    st.lists(st.booleans(), max_size=6),
    st.lists(TEXTS, max_size=3),
)


def fuzz(bench: NodeBench, target: Target, cases: int) -> int:
    """Fuzz the node of ``bench`` with about ``cases`` cases; return how many there were."""
    node = bench.node
    done = [0]
    published: list[str] = []

    def watch() -> None:
        """Look at whatever the node publishes from now on."""
        for publisher in node.publishers:
            if hasattr(publisher, "is_activated") and not hasattr(publisher, "_looked_at"):
                publisher._looked_at = True
                publisher.publish = checking(publisher)

    def checking(publisher: Any) -> Callable[[Any], None]:
        send, kind = publisher.publish, publisher.msg_type.__name__
        allowed = target.may_be_nan.get(kind, frozenset())

        def publish(message: Any) -> None:
            bad = [(path, value) for path, value in leaves(message) if path not in allowed and not is_finite(value)]
            if bad:
                published.append(f"{publisher.topic_name}: {bad}")
            send(message)

        return publish

    def transition(identity: int) -> bool:
        (service,) = [s for s in node.services if s.srv_name.endswith("/change_state")]
        request = ChangeState.Request(transition=Transition(id=identity))
        return bool(service.callback(request, ChangeState.Response()).success)

    defaults = [Parameter(name, value=_plain(value)) for name, value in parameters_of(node.settings).items()]
    changeable = [one for one in defaults if not node.describe_parameter(one.name).read_only]

    class Machine(RuleBasedStateMachine):
        @initialize()
        def begin(self) -> None:
            self.stamp = 1_000 * SAMPLE
            self.number = 0
            published.clear()
            for identity in (
                Transition.TRANSITION_DEACTIVATE,
                Transition.TRANSITION_CLEANUP,
                Transition.TRANSITION_CONFIGURE,
            ):
                transition(identity)
            result = node.set_parameters_atomically(changeable)
            assert result.successful, result.reason
            assert transition(Transition.TRANSITION_ACTIVATE)
            watch()

        def hand(self, one: Input, message: Any) -> None:
            heard = [s for s in node.subscriptions if s.topic_name.endswith(f"/{one.topic}")]
            if not heard:
                return
            watch()
            before = node._refused + node.ignored
            self.number += 1
            info = {"publication_sequence_number": self.number, "received_timestamp": self.number * SAMPLE}
            if heard[0]._callback_type is type(heard[0]).CallbackType.WithMessageInfo:
                heard[0].callback(message, info)
            else:
                heard[0].callback(message)
            fields = dict(leaves(message))
            wrong = [path for path in one.reads if not is_finite(fields[path])]
            if wrong and not one.unread(message):
                assert node._refused + node.ignored > before or target.tells(node), (
                    f"{one.topic}: {wrong} passed quietly"
                )
            self.judge()

        def judge(self) -> None:
            done[0] += 1
            assert not published, published[:3]

        @rule(count=st.integers(1, 8))
        def sail(self, count: int) -> None:
            """A stretch of what the node is used to."""
            for _ in range(count):
                self.stamp += SAMPLE
                for one in target.inputs:
                    self.hand(one, one.good(self.stamp))

        @rule(data=st.data())
        def hand_anything(self, data: st.DataObject) -> None:
            one = data.draw(st.sampled_from(target.inputs))
            self.stamp += SAMPLE
            message = one.good(self.stamp)
            paths = dict(leaves(message))
            for path in data.draw(st.lists(st.sampled_from(sorted(paths)), min_size=1, max_size=3)):
                put(message, path, data.draw(replacement(path, paths[path])))
            self.hand(one, message)

        @rule(data=st.data())
        def spoil_what_is_read(self, data: st.DataObject) -> None:
            one = data.draw(st.sampled_from([one for one in target.inputs if one.reads]))
            self.stamp += SAMPLE
            message = one.good(self.stamp)
            paths = dict(leaves(message))
            path = data.draw(st.sampled_from(one.reads))
            put(message, path, data.draw(replacement(path, paths[path])))
            self.hand(one, message)

        @rule(jump=st.sampled_from([-(10**12), -3 * SAMPLE, -SAMPLE, 0, 3 * SAMPLE, 10**12, 10**15]))
        def jump_in_time(self, jump: int) -> None:
            self.stamp = min(max(0, self.stamp + jump), 2**31 * 10**9 - 10**13)
            for _ in range(4):
                self.stamp += SAMPLE
                for one in target.inputs:
                    self.hand(one, one.good(self.stamp))

        @rule(data=st.data())
        def change_parameters(self, data: st.DataObject) -> None:
            own = sorted(parameters_of(node.settings))
            values: dict[str, Any] = {}
            for name in data.draw(st.lists(st.sampled_from([*own, "vessel", "no.such"]), min_size=1, max_size=3)):
                likely = name in own and data.draw(st.booleans())
                values[name] = data.draw(plausible(node, name) if likely else ANYTHING)
            (service,) = [s for s in node.services if s.srv_name.endswith("/set_parameters_atomically")]
            request = SetParametersAtomically.Request(
                parameters=[Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
            )
            response = service.callback(request, SetParametersAtomically.Response())
            assert response.result.successful or response.result.reason
            for name, value in parameters_of(node.settings).items():
                shown = node.get_parameter(name).value
                assert (tuple(shown) if isinstance(value, tuple) else shown) == value, f"{name}: {shown}, {value}"
            self.judge()

        @rule(identity=st.sampled_from([*range(10), 61, 255]))
        def ask_for_a_transition(self, identity: int) -> None:
            if identity in (1, 2, 5, 6, 7, 61):  # clean-up and shutdown: the nodes' own tests
                identity = Transition.TRANSITION_DEACTIVATE if node.active else Transition.TRANSITION_ACTIVATE
            transition(identity)
            watch()
            self.judge()

        @rule()
        def let_timers_run(self) -> None:
            for name in target.timers:
                getattr(node, name)()
            node.publish_diagnostics()
            self.judge()

    run_state_machine_as_test(
        Machine,
        settings=settings(
            max_examples=max(1, cases // STEPS),
            stateful_step_count=STEPS,
            deadline=None,
            suppress_health_check=list(HealthCheck),
        ),
    )
    return done[0]


def stamped(message: Any, stamp: int) -> Any:
    """A copy of a message with another stamp, ns."""
    message = copy.deepcopy(message)
    message.header.stamp = from_nanoseconds(stamp)
    return message


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
