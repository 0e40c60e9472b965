"""Leads the nodes of one process through their life cycle, by their services and without ever waiting."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.task import Future

from dp_bringup.supervisor.life_cycle import Aim, Step, next_step

# An answer is lost if the node has not heard of this client's reader yet, which nobody can see: ask again.
_ASK_AGAIN = 0.25  # s
# Nor is somebody asked all the time who answers at once.
_ASK_NEXT = 0.05  # s
# A node that is busy with a transition refuses the same one afterwards, which does no harm.
_TRY_AGAIN = 2.0  # s
_TRANSITIONS = {Step.CONFIGURE: Transition.TRANSITION_CONFIGURE, Step.ACTIVATE: Transition.TRANSITION_ACTIVATE}


class Asked:
    """One service, asked again from time to time until it answers."""

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        self._node = node
        self._client = node.create_client(kind, name)
        self._futures: list[Future] = []
        self._next = self._soonest = 0.0

    def ask(self, request: Any, now: float, again: float = _ASK_AGAIN) -> Any | None:
        """Return an answer that has come, and ask if it is time to."""
        for future in self._futures:
            if future.done():
                answer = future.result()
                self.forget()
                return answer
        if now >= self._next and self._client.service_is_ready():
            self._futures.append(self._client.call_async(request))
            self._next, self._soonest = now + again, now + _ASK_NEXT
        return None

    def forget(self) -> None:
        """Give up what has been asked and not been answered."""
        for future in self._futures:
            self._client.remove_pending_request(future)
        self._futures.clear()
        self._next = self._soonest

    def close(self) -> None:
        """Give the client back."""
        self.forget()
        self._node.destroy_client(self._client)


class NodeBringUp:
    """One node: on its way to its aim, then a snapshot of its parameters.

    Parameters
    ----------
    node
        Asks.
    name
        Of the node that is asked.
    aim
        State in which it is to end up.
    before_configure
        Parameters to set before it is configured, worked out when it comes to that.
    """

    def __init__(self, node: Node, name: str, aim: Aim, before_configure: Callable[[], Mapping[str, Any]]) -> None:
        self.name = name
        self.aim = aim
        self.state = ""
        self.failure = ""
        self.values: dict[str, Any] | None = None
        self._before_configure: Callable[[], Mapping[str, Any]] | None = before_configure
        self._setting: SetParameters.Request | None = None
        self._state = Asked(node, GetState, f"{name}/get_state")
        self._change = Asked(node, ChangeState, f"{name}/change_state")
        self._set = Asked(node, SetParameters, f"{name}/set_parameters")
        self._list = Asked(node, ListParameters, f"{name}/list_parameters")
        self._get = Asked(node, GetParameters, f"{name}/get_parameters")
        self._step: Step | None = None
        self._refused: Step | None = None
        self._names: list[str] = []

    @property
    def there(self) -> bool:
        """Whether the aim is reached and the parameters are known."""
        return self.state == self.aim and self.values is not None

    def look(self, now: float, turn: bool) -> None:
        """Go on, if there is something to go on with."""
        if self.failure or self.there:
            return
        if self.state == self.aim:
            self._take_parameters(now)
            return
        if self._step is not None:
            self._change_state(self._step, now)
            return
        answer = self._state.ask(GetState.Request(), now)
        if answer is None:
            return
        self.state = answer.current_state.label
        self._step = next_step(self.state, self.aim, turn)
        if self._step is not None and self._step is self._refused:
            self.failure = f"{self.name} refused to {self._step}"

    def _change_state(self, step: Step, now: float) -> None:
        if step is Step.CONFIGURE and not self._prepared(now):
            return
        request = ChangeState.Request(transition=Transition(id=_TRANSITIONS[step]))
        answer = self._change.ask(request, now, _TRY_AGAIN)
        if answer is not None:
            # Or an earlier request of the same kind had been done already: its state says which.
            self._refused = None if answer.success else step
            self._step = None
            self._state.forget()
            return
        # The answer may be lost while the transition was made.
        answer = self._state.ask(GetState.Request(), now)
        if answer is not None and answer.current_state.label != self.state:
            self.state = answer.current_state.label
            self._step = None

    def _prepared(self, now: float) -> bool:
        """Set what is to be set before the node is configured; whether it takes it is the node's to say."""
        if self._before_configure is not None:
            values = self._before_configure()
            self._before_configure = None
            if values:
                parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
                self._setting = SetParameters.Request(parameters=parameters)
        if self._setting is not None and self._set.ask(self._setting, now) is not None:
            self._setting = None
        return self._setting is None

    def _take_parameters(self, now: float) -> None:
        if not self._names:
            answer = self._list.ask(ListParameters.Request(), now)
            if answer is not None:
                self._names = sorted(answer.result.names)
            return
        answer = self._get.ask(GetParameters.Request(names=self._names), now)
        if answer is not None:
            self.values = {
                name: _plain(parameter_value_to_python(value))
                for name, value in zip(self._names, answer.values, strict=True)
            }

    def close(self) -> None:
        """Give the clients back."""
        for asked in (self._state, self._change, self._set, self._list, self._get):
            asked.close()


class BringUp:
    """All nodes of one process, one after the other."""

    def __init__(self, nodes: list[NodeBringUp]) -> None:
        self.nodes = nodes

    def look(self, now: float, turn: bool) -> None:
        """Go on: all are configured as soon as they are there, and activated in their order."""
        for one in self.nodes:
            one.look(now, turn)
            turn = turn and one.there

    @property
    def there(self) -> bool:
        """Whether every node is where it shall be."""
        return all(one.there for one in self.nodes)

    @property
    def ready(self) -> bool:
        """Whether every node has been configured."""
        return all(one.state not in ("", Aim.UNCONFIGURED) for one in self.nodes)

    @property
    def failure(self) -> str:
        """Why a node will not come up; empty if none refuses."""
        return next((one.failure for one in self.nodes if one.failure), "")

    def close(self) -> None:
        """Give the clients back."""
        for one in self.nodes:
            one.close()


def _plain(value: Any) -> Any:
    return list(value) if hasattr(value, "tolist") or isinstance(value, tuple) else value
