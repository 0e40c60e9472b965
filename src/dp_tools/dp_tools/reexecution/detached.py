"""A node's own class without middleware: messages are handed to its callbacks, and what it publishes is caught.

All that a node has of the middleware comes from methods of rclpy's node: subscriptions, publishers, timers, services,
clock, and who else is there. A subclass of the node's class gives other answers, so that every line of the node runs
as on the graph: parameters, life cycle, guarded callbacks, conversion of messages.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from rclpy.context import Context
from rclpy.lifecycle.managed_entity import SimpleManagedEntity
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.time import Time

from dp_bringup.composed import node_factory
from dp_node import DpNode
from dp_node.quality import TOPICS
from dp_tools.reexecution.canonical import canonical
from dp_tools.reexecution.recording import Recorded

_DISCOVERY = "ROS_AUTOMATIC_DISCOVERY_RANGE"


@dataclass(frozen=True, slots=True)
class Caught:
    """One message that the node published.

    Parameters
    ----------
    topic
        As the node names it.
    data
        CDR.
    form
        What is compared, see :func:`canonical`.
    time
        At which the node was made to act, ns.
    cause
        By what: a topic, or a word for what is not a message.
    """

    topic: str
    data: bytes
    form: bytes
    time: int
    cause: str


@dataclass
class Ear:
    """One subscription of the node."""

    topic: str
    kind: Any
    callback: Callable[..., None]
    quality: QoSProfile

    @property
    def topic_name(self) -> str:
        """Full name, as of a node in no namespace."""
        return f"/{self.topic}"

    def __post_init__(self) -> None:
        try:
            inspect.signature(self.callback).bind(None, None)
        except TypeError:
            self._with_information = False
        else:
            self._with_information = True

    def hear(self, message: Recorded) -> None:
        """Hand a message to the callback, with what the middleware would say of it where it asks for that."""
        found = deserialize_message(message.data, self.kind)
        if not self._with_information:
            self.callback(found)
            return
        about = {
            "source_timestamp": message.published,
            "received_timestamp": message.logged,
            "publication_sequence_number": message.number,
            "reception_sequence_number": message.number,
        }
        self.callback(found, about)

    @property
    def wants_history(self) -> bool:
        """Whether it is to have what was published before it was there."""
        return bool(self.quality.durability == DurabilityPolicy.TRANSIENT_LOCAL)

    def get_publisher_count(self) -> int:
        """Say that somebody publishes."""
        return 1


@dataclass
class Timer:
    """One timer of the node; nobody calls it but who re-executes."""

    callback: Callable[[], None]
    timer_period_ns: int

    def reset(self) -> None:
        """Do nothing: time is not its own."""

    def cancel(self) -> None:
        """Do nothing: time is not its own."""


class Mouth(SimpleManagedEntity):
    """One publisher of the node: what it publishes is caught, of a managed one while the node is active."""

    def __init__(self, wires: Wires, kind: Any, topic: str, compared: bool, managed: bool) -> None:
        super().__init__()
        self._wires, self.kind, self._topic = wires, kind, topic
        self._compared, self._managed = compared, managed

    @property
    def topic_name(self) -> str:
        """Full name, as of a node in no namespace."""
        return f"/{self._topic}"

    def publish(self, message: Any) -> None:
        """Catch a message as it is now: a node may use it again."""
        if self._compared and (self.is_activated or not self._managed):
            data, form = serialize_message(message), canonical(message)
            self._wires.caught.append(Caught(self._topic, data, form, self._wires.time, self._wires.cause))

    def get_subscription_count(self) -> int:
        """Say that somebody listens."""
        return 1

    def wait_for_all_acked(self, timeout: Any) -> bool:
        """Say that all is heard."""
        return True


class Log:
    """What the node logs: kept, the last of every level."""

    def __init__(self) -> None:
        self.last: dict[str, str] = {}

    def __getattr__(self, level: str) -> Callable[..., None]:
        if level not in ("debug", "info", "warning", "error", "fatal"):
            raise AttributeError(level)

        def note(text: str, **options: Any) -> None:
            self.last[level] = text

        return note


@dataclass
class Wires:
    """The ends of everything that a detached node has made.

    Attributes
    ----------
    time
        What the node's clock says, ns.
    cause
        What the node is being made to act by.
    ears, timers, services
        In the order in which they were made.
    mouths
        Publishers by topic.
    caught
        What was published.
    scaffolding
        Number of timers that every node has; those after them are the node's own.
    made_at_start
        Names of the attributes that the node has made for its work: core, stamps, what waits.
    """

    time: int = 0
    cause: str = ""
    ears: list[Ear] = field(default_factory=list)
    timers: list[Timer] = field(default_factory=list)
    services: dict[str, Any] = field(default_factory=dict)
    mouths: dict[str, Mouth] = field(default_factory=dict)
    caught: list[Caught] = field(default_factory=list)
    log: Log = field(default_factory=Log)
    scaffolding: int = 0
    made_at_start: frozenset[str] = frozenset()


class Detached(DpNode[Any]):
    """Overrides what a node's class has from the middleware; ``wires`` is set by the subclass made for one node."""

    wires: Wires

    def create_subscription(self, kind: Any, topic: str, callback: Any, quality: Any, **options: Any) -> Any:
        """Keep the callback."""
        self.wires.ears.append(Ear(topic, kind, callback, quality))
        return self.wires.ears[-1]

    def create_publisher(self, kind: Any, topic: str, quality: Any, **options: Any) -> Any:
        """Make a publisher that speaks whether the node is active or not."""
        # Topics of all nodes are not compared: diagnostics, parameter events.
        compared = topic in TOPICS and not topic.startswith("/")
        mouth = Mouth(self.wires, kind, topic, compared, managed=False)
        if compared:
            self.wires.mouths[topic] = mouth
        return mouth

    def create_lifecycle_publisher(self, kind: Any, topic: str, quality: Any, **options: Any) -> Any:
        """Make a publisher whose messages are caught while the node is active."""
        mouth = Mouth(self.wires, kind, topic, compared=True, managed=True)
        self.wires.mouths[topic] = mouth
        self.add_managed_entity(mouth)
        return mouth

    def create_timer(self, period: float, callback: Any, *arguments: Any, **options: Any) -> Any:
        """Keep the callback."""
        self.wires.timers.append(Timer(callback, round(period * 1e9)))
        return self.wires.timers[-1]

    def create_service(self, kind: Any, name: str, callback: Any, **options: Any) -> Any:
        """Keep the service; its ``send_response`` is what the node may put something in the place of."""
        self.wires.services[name] = SimpleNamespace(callback=callback, send_response=_send)
        return self.wires.services[name]

    @property
    def subscriptions(self) -> Iterator[Any]:
        """Those that were made here."""
        yield from self.wires.ears

    def destroy_lifecycle_publisher(self, publisher: Any) -> bool:
        """Forget a publisher."""
        self._managed_entities.discard(publisher)
        return True

    def destroy_subscription(self, subscription: Any) -> bool:
        """Forget a subscription."""
        self.wires.ears.remove(subscription)
        return True

    def count_publishers(self, topic_name: str) -> int:
        """Say that somebody publishes."""
        return 1

    def count_subscribers(self, topic_name: str) -> int:
        """Say that somebody listens."""
        return 1

    def get_publishers_info_by_topic(self, topic_name: str, no_mangle: bool = False) -> list[Any]:
        """Tell nothing of those who publish."""
        return []

    def get_clock(self) -> Any:
        """Return a clock that says the time of what is being fed."""
        return SimpleNamespace(now=lambda: Time(nanoseconds=self.wires.time))

    def get_logger(self) -> Any:
        """Return a log that only keeps what was said last."""
        return self.wires.log


def _send(response: Any, reply: Callable[[Any], None]) -> None:
    """Hand a response to whoever called, who stands in the place of the request's header."""
    reply(response)


@contextmanager
def detached_node(package: str, vessel: Path, values: dict[str, Any], time: int) -> Iterator[tuple[DpNode[Any], Wires]]:
    """Start the node of ``package`` without middleware; it is active.

    Parameters
    ----------
    package
        Found by name, as its executable is.
    vessel
        Vessel file.
    values
        Start parameters beside that.
    time
        Of its clock, ns.

    Raises
    ------
    DpError
        If the node refuses to start.
    """
    wires = Wires(time=time)
    own_class: Any = node_factory(package)
    made: Any = type(f"Detached{own_class.__name__}", (Detached, own_class), {"wires": wires})
    own = {**values, "vessel": str(vessel), "autostart": True, "use_sim_time": False}
    own["start_type_description_service"] = False
    context = Context()
    with _nobody_else():
        # Not ours to set up: another node of this process may log.
        context.init(args=[], initialize_logging=False)
    node: DpNode[Any] | None = None
    try:
        node = made(
            context=context,
            parameter_overrides=[Parameter(name, value=value) for name, value in own.items()],
            use_global_arguments=False,
            start_parameter_services=False,
            enable_communication_interface=False,
            enable_rosout=False,
        )
        wires.scaffolding = len(wires.timers)
        before = dict(vars(node))
        node.start()
        wires.made_at_start = frozenset(
            name for name, value in vars(node).items() if name not in before or before[name] is not value
        )
        yield node, wires
    finally:
        if node is not None:
            node.destroy_node()
        context.try_shutdown()


@contextmanager
def _nobody_else() -> Iterator[None]:
    """Let a context begin that neither looks for others nor is seen by them."""
    before = os.environ.get(_DISCOVERY)
    os.environ[_DISCOVERY] = "OFF"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_DISCOVERY]
        else:
            os.environ[_DISCOVERY] = before
