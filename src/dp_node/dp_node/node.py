"""Base class of the nodes: life cycle, vessel, parameters, guarded callbacks, diagnostics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterDescriptor, ParameterType, SetParametersResult
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from dp_node.alarms import raised
from dp_node.common_health import NodeCounts, health_of
from dp_node.exclusive import Peer
from dp_node.exclusive_inputs import ExclusiveInputs
from dp_node.health import Health, to_status
from dp_node.parameters import SettingsParameters
from dp_node.quality import Promise, offered, requested
from dp_node.quality_events import QualityEvents
from dp_node.services import guard_services
from dp_node.stamps import SourceRestartError
from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.settings import Settings

S = TypeVar("S", bound=Settings)

_DIAGNOSTICS_PERIOD = 1.0  # s


class DpNode(LifecycleNode, Generic[S]):
    """A managed node around one pure core.

    A subclass says what its settings are (:meth:`default_settings`), builds core, publishers and subscriptions in
    :meth:`build`, hands changed settings on in :meth:`apply`, and tells its state in :meth:`health`. Publishers come
    from :meth:`publish_on`, subscriptions from :meth:`listen`: their callbacks run only while the node is active, and
    an InputError raised by one is reported and counted, never fatal.

    Parameters
    ----------
    name
        Node name.

    Raises
    ------
    DpError
        If the vessel cannot be loaded, or a parameter given at start-up is refused.
    """

    def __init__(self, name: str, **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        guard_services(self)
        self.vessel: Vessel = load_vessel(self.structural("vessel", "cybership3", "Name or path of the vessel file"))
        self.autostart: bool = self.structural("autostart", True, "Configure and activate without being told to")
        self._promise = Promise(
            self.structural(
                "input_lease",
                0.0,
                "Wall time without a sign of life after which a node of the ring counts as gone, 2 or more; 0: never",
            ),
            self.structural(
                "input_deadline",
                0.0,
                "Wall time in which messages within the ring have to follow each other, for all its nodes; 0: any",
            ),
        )
        self._quality_events = QualityEvents()
        self._exclusive = ExclusiveInputs(
            self.structural(
                "exclusive_inputs",
                True,
                "Where an input has one publisher by design, messages of a second one are refused, not only reported",
            )
        )
        self._began_anew = ""  # why the node began anew since the last diagnostics
        self.ignored = 0  # messages that came while the node was not active
        self._refused = 0
        self._last_refusal = ""
        self._refusals_reported = 0
        self._active = False
        self._failure: Exception | None = None
        self._parameters_bound = SettingsParameters(self, self.default_settings(self.vessel), self.check, self._apply)
        quality = offered("/diagnostics", self._promise)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", quality)
        self.create_timer(_DIAGNOSTICS_PERIOD, self.publish_diagnostics)

    # What a subclass provides ---------------------------------------------------------------------------------------

    def default_settings(self, vessel: Vessel) -> S:
        """Return the settings that hold when no parameter overrides them."""
        raise NotImplementedError

    def check(self, settings: S) -> None:
        """Raise InputError if ``settings`` do not fit the vessel."""

    def build(self) -> None:
        """Make the core, publishers and subscriptions (transition configure)."""
        raise NotImplementedError

    def apply(self, settings: S) -> None:
        """Hand changed settings to the core; only called between build and clean-up."""
        raise NotImplementedError

    def started(self) -> None:
        """Act on activation: forget what belongs to an earlier activation."""

    def stopped(self) -> None:
        """Act on deactivation, while publishers still publish."""

    def health(self) -> Health:
        """Return the state of the core; what the base class knows is added."""
        return Health()

    # What a subclass uses -------------------------------------------------------------------------------------------

    @property
    def settings(self) -> S:
        """The settings in force."""
        return self._parameters_bound.current

    @property
    def active(self) -> bool:
        """True between activation and deactivation."""
        return self._active

    @property
    def acts(self) -> bool:
        """Whether messages are acted on: while the node is active."""
        return self._active

    def structural(self, name: str, default: Any, description: str) -> Any:
        """Declare a read-only parameter and return its value."""
        kinds = {
            bool: ParameterType.PARAMETER_BOOL,
            float: ParameterType.PARAMETER_DOUBLE,
            str: ParameterType.PARAMETER_STRING,
        }
        descriptor = ParameterDescriptor(name=name, type=kinds[type(default)], description=description, read_only=True)
        return self.declare_parameter(name, default, descriptor).value

    def publish_on(self, kind: Any, topic: str, *, when_inactive: bool = False) -> Publisher:
        """Return a publisher that is silent while the node is not active, unless ``when_inactive`` is true."""
        made: Publisher

        def misfits() -> int:
            return int(self.count_subscribers(topic) - made.get_subscription_count())

        events = self._quality_events.publisher(topic, misfits)
        make = self.create_publisher if when_inactive else self.create_lifecycle_publisher
        made = make(kind, topic, offered(topic, self._promise), event_callbacks=events)
        return made

    @property
    def in_lockstep(self) -> bool:
        """Whether this node asks for what was sent before it was known, operator inputs apart."""
        return False

    def listen(self, kind: Any, topic: str, callback: Callable[[Any], None], *, exclusive: bool = False) -> None:
        """Subscribe ``callback``, guarded: it runs while active, and its InputError is reported and counted.

        Where it finds that the source of the topic began anew (SourceRestartError), the node begins anew as at
        activation, and the message is the first. An ``exclusive`` topic has one publisher by design; see
        :class:`ExclusiveInput`.
        """
        made: Subscription

        def misfits() -> int:
            return int(self.count_publishers(topic) - made.get_publisher_count())

        def guarded(message: Any) -> None:
            if not self.acts:
                self.ignored += 1
                return
            try:
                callback(message)
            except SourceRestartError as error:
                self._begin_anew(str(error))
                guarded(message)  # a sequence that was reset does not find so again
            except InputError as error:
                self.refuse(str(error))

        def from_one(message: Any, info: Any) -> None:
            if passes(info["publication_sequence_number"], info["received_timestamp"]):
                guarded(message)

        made = self.create_subscription(
            kind,
            topic,
            from_one if exclusive else guarded,
            requested(topic, self.in_lockstep, self._promise),
            event_callbacks=self._quality_events.subscription(topic, misfits),
        )
        if exclusive:
            patience = round(self.vessel.drivers.command_timeout * 1e9)
            passes = self._exclusive.add(
                topic, made.get_publisher_count, lambda: self._peers(made.topic_name), patience
            )

    def _peers(self, topic: str) -> list[Peer]:
        return [
            Peer(tuple(info.endpoint_gid), f"{info.node_namespace.rstrip('/')}/{info.node_name}".lstrip("/"))
            for info in self.get_publishers_info_by_topic(topic)
        ]

    def _begin_anew(self, reason: str) -> None:
        """Forget what was made of a source that has no past any more."""
        self._began_anew = reason
        self.get_logger().warning(f"{reason}; this node begins anew as well")
        self.started()
        if not self._active:
            self.stopped()  # one that acts while it is inactive stays so

    def refuse(self, reason: str) -> None:
        """Count and report an input that was refused."""
        self._refused += 1
        self._last_refusal = reason
        self.get_logger().warning(f"refused: {reason}", throttle_duration_sec=1.0)

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set all parameters or none; one that nobody declared is refused by its name."""
        unknown = sorted({one.name for one in parameter_list if not self.has_parameter(one.name)})
        if unknown:
            return SetParametersResult(successful=False, reason=f"no parameter {', '.join(map(repr, unknown))}")
        return super().set_parameters_atomically(parameter_list)

    # Life cycle -----------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Configure and activate, if ``autostart`` says so.

        Raises
        ------
        Exception
            What a transition failed with.
        """
        if not self.autostart:
            return
        for transition in (self.trigger_configure, self.trigger_activate):
            if transition() is not TransitionCallbackReturn.SUCCESS:
                raise self._failure or InputError(f"{self.get_name()}: {transition.__name__} was refused")

    def _attempt(self, action: Callable[[], None]) -> bool:
        """Run a part of a transition; rclpy would swallow what it raises, so keep and report it."""
        try:
            action()
        except Exception as error:
            self._failure = error
            self.get_logger().error(f"{type(error).__name__}: {error}")
            return False
        return True

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Build the core and its topics."""
        self._before = (
            set(self.publishers),
            set(self.subscriptions),
            set(self.timers),
            set(self.services),
        )
        if not self._attempt(self.build):
            self._give_back()
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to act on messages."""
        result = super().on_activate(state)
        if not self._attempt(self.started):
            super().on_deactivate(state)
            return TransitionCallbackReturn.FAILURE
        self._active = True
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop acting on messages."""
        self._active = False
        self.stopped()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give up what build made."""
        result = super().on_cleanup(state)
        self._give_back()
        return result

    def _give_back(self) -> None:
        """Destroy what build made."""
        self._quality_events.forget()
        publishers, subscriptions, timers, services = self._before
        for publisher in set(self.publishers) - publishers:
            self.destroy_lifecycle_publisher(publisher)
        for subscription in set(self.subscriptions) - subscriptions:
            self.destroy_subscription(subscription)
        for timer in set(self.timers) - timers:
            self.destroy_timer(timer)
        for service in set(self.services) - services:
            self.destroy_service(service)
        self._exclusive.clear()

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop acting on messages for good."""
        if self._active:
            self._active = False
            self.stopped()
        return super().on_shutdown(state)

    # Diagnostics ----------------------------------------------------------------------------------------------------

    def _apply(self, settings: S) -> None:
        if self._built:
            self.apply(settings)

    @property
    def _built(self) -> bool:
        return self._state_machine.current_state[1] in ("inactive", "active", "activating")

    def publish_diagnostics(self) -> None:
        """Publish the health of this node on /diagnostics."""
        refused, self._refusals_reported = self._refused - self._refusals_reported, self._refused
        topics = [*self._quality_events.report(), *self._exclusive.report()]
        if self._began_anew:
            topics.append(raised("NODE-SOURCE-RESTARTED", self._began_anew))
            self._began_anew = ""
        counts = NodeCounts(
            state=self._state_machine.current_state[1],
            refused=self._refused,
            fresh_refused=refused,
            last_refusal=self._last_refusal,
            ignored=self.ignored,
            refused_of_others=self._exclusive.refused,
            topics=tuple(topics),
        )
        health = health_of(counts, self.health() if self._built else Health())
        message = DiagnosticArray(status=[to_status(self.get_fully_qualified_name().lstrip("/"), health)])
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)
