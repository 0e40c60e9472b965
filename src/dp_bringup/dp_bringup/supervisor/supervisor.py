"""The supervisor: processes of a graph, their life cycle, their last parameters; a ROS node that tells of them."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from std_srvs.srv import Trigger

from dp_bringup.parameter_file import to_parameter_file
from dp_bringup.processes import Child, Children, explain_exit
from dp_bringup.supervisor.bring_up import BringUp, NodeBringUp
from dp_bringup.supervisor.last_parameters import LastParameters
from dp_bringup.supervisor.life_cycle import Aim
from dp_bringup.supervisor.operator_memory import OperatorMemory
from dp_bringup.supervisor.policy import Action, Phase
from dp_bringup.supervisor.rules import Rules
from dp_bringup.supervisor.supervision_health import supervision_health
from dp_bringup.supervisor.unit import Unit, UnitPlan
from dp_bringup.workspace import SIMULATOR_PACKAGE
from dp_node import RING, RING_PUBLISHER
from dp_node.health import to_status
from marine_model.errors import DpError

SUPERVISOR = "supervisor"  # name of its node
_ALLOCATOR, _CONTROLLER = "thrust_allocator", "dp_controller"
_DIAGNOSTICS_PERIOD = 1.0  # s


class CannotStartError(DpError):
    """A process never came up; the message says which and why."""


class Supervisor:
    """Brings up and keeps up the processes of ``plans``; :meth:`look` does what is due and never waits.

    Parameters
    ----------
    node
        ROS node named ``supervisor``, in the namespace of the graph; somebody else spins it.
    plans
        Processes, in the order in which their nodes are activated.
    children
        Where processes are started; whoever made it stops them in the end.
    folder
        Parameter files of the processes are written here.
    start_parameters
        By node and name.
    names
        Further words of the command line of every process, e.g. its namespace.
    rules
        Patience.
    tell
        Told what happens, one line each.
    shield
        Context in which nothing may interrupt.
    """

    def __init__(
        self,
        node: Node,
        plans: Sequence[UnitPlan],
        children: Children,
        folder: Path,
        start_parameters: Mapping[str, Mapping[str, Any]],
        names: Sequence[str | Path] = (),
        rules: Rules | None = None,
        tell: Callable[[str], None] = lambda text: None,
        shield: Callable[[], AbstractContextManager[None]] = nullcontext,
    ) -> None:
        self._node = node
        self._children = children
        self._folder = folder
        self._names = list(names)
        self._rules = rules or Rules()
        self._tell = tell
        self._shield = shield
        self._parameters = LastParameters(start_parameters)
        self._units = {plan.name: Unit(plan, self._rules) for plan in plans}
        self._unit_of = {name: unit for unit in self._units.values() for name in unit.plan.nodes}
        self._namespace = node.get_namespace().strip("/")
        self._memory = OperatorMemory(node, tell)
        # Simulated time, and the steady time at which the simulator said so; how fast it goes on.
        self._simulated: tuple[float, float, float] | None = None
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", RING_PUBLISHER)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, RING)
        node.create_subscription(ParameterEvent, "/parameter_events", self._on_parameters, RING)
        node.create_timer(_DIAGNOSTICS_PERIOD, self._publish)
        for name in self._unit_of:
            node.create_service(Trigger, f"~/restart_{name}", self._restart_service(name))

    # What happens ---------------------------------------------------------------------------------------------------

    def look(self) -> None:
        """Do what is due: notice who has died, start, configure, activate, kill.

        Raises
        ------
        CannotStartError
            If a process ended, or refused, before it was up for the first time.
        """
        now = time.monotonic()
        turn = True
        for unit in self._units.values():
            self._notice_death(unit, now)
            self._do(unit, unit.policy.look(now), now)
            self._lead(unit, turn, now)
            self._tell_of_silence(unit, now)
            turn = turn and unit.policy.was_up
        self._memory.look(now)

    @property
    def all_up(self) -> bool:
        """Whether every process is up."""
        return all(unit.policy.phase is Phase.UP for unit in self._units.values())

    @property
    def given_up(self) -> list[str]:
        """Names of processes that are not restarted any more."""
        return [name for name, unit in self._units.items() if unit.policy.phase is Phase.GIVEN_UP]

    @property
    def supervised(self) -> Collection[Child]:
        """Processes whose end is no concern of anybody else."""
        return [unit.child for unit in self._units.values() if unit.child is not None]

    def restarts(self, node: str) -> int:
        """Return how often the process of ``node`` was started again."""
        return self._unit_of[node].policy.restarts

    def _notice_death(self, unit: Unit, now: float) -> None:
        child = unit.child
        if child is None or child.exit_code is None:
            return
        name, policy = unit.plan.name, unit.policy
        how, words = explain_exit(child.exit_code), child.last_words()
        unit.forget(self._children)
        policy.died(how, now)
        if policy.phase is Phase.GIVEN_UP and not policy.was_up:
            why = f" ({policy.reason})" if policy.reason == how else f": {policy.reason} ({how})"
            raise CannotStartError(f"{name} ended by itself{why}, {words}")
        if policy.phase is Phase.GIVEN_UP:
            self._tell(
                f"{name} died ({policy.reason}), {policy.deaths} times within {self._rules.window:g} s: given up; "
                f"see {child.log_file}, then: dp restart {unit.plan.nodes[0]}"
            )
        elif policy.phase is Phase.BACK_OFF:
            self._tell(f"{name} died ({policy.reason}); starting it again in {policy.delay:g} s")

    def _do(self, unit: Unit, action: Action | None, now: float) -> None:
        if action is Action.START:
            self._start(unit, now)
        elif action is not None and unit.child is not None:
            if action is Action.KILL:
                self._tell(f"{unit.plan.name}: {unit.policy.reason}; killing it")
            unit.child.request_stop(signal.SIGKILL if action is Action.KILL else signal.SIGINT)

    def _start(self, unit: Unit, now: float) -> None:
        again = unit.policy.restarts > 0
        values = {name: self._parameters.of(name) for name in unit.plan.nodes}
        if again and _ALLOCATOR in values:
            # The thrusters are where they are, and turning them back to where a vessel begins would be a step.
            values[_ALLOCATOR]["initial_azimuth"] = "feedback"
        file = self._folder / f"{unit.plan.name}.yaml"
        file.write_text(to_parameter_file(values), encoding="utf-8")
        words = ["--ros-args", "--params-file", file, "-p", "autostart:=false", *self._names]
        unit.start(self._children, words, self._shield)
        unit.bring_up = BringUp(
            [
                NodeBringUp(self._node, name, unit.aims[name], self._time_to_begin_at if again else dict)
                if name == SIMULATOR_PACKAGE
                else NodeBringUp(self._node, name, unit.aims[name], dict)
                for name in unit.plan.nodes
            ]
        )
        for name in unit.plan.nodes:
            self._parameters.expect_snapshot(name)

    def _lead(self, unit: Unit, turn: bool, now: float) -> None:
        bring_up = unit.bring_up
        if bring_up is None or unit.policy.phase is not Phase.STARTING:
            return
        bring_up.look(now, turn)
        if not turn and bring_up.ready:
            unit.policy.waits(now)
        if bring_up.failure:
            self._do(unit, unit.policy.failed(bring_up.failure, now), now)
        elif bring_up.there:
            for one in bring_up.nodes:
                self._parameters.snapshot(one.name, one.values or {})
            bring_up.close()
            unit.bring_up = None
            unit.policy.up(now)
            if unit.policy.restarts:
                self._tell(f"{unit.plan.name} is up again (process {unit.child.pid if unit.child else '-'})")
                if _CONTROLLER in unit.plan.nodes:
                    self._memory.give_again(now)

    def _tell_of_silence(self, unit: Unit, now: float) -> None:
        silent = unit.policy.silent(now)
        if silent and not unit.told_silent:
            left = self._rules.hang_timeout - self._rules.silent_after
            self._tell(f"{unit.plan.name} is silent; it is killed unless it is heard of within {left:g} s")
        elif unit.told_silent and not silent and unit.policy.phase is Phase.UP:
            self._tell(f"{unit.plan.name} is heard of again")
        unit.told_silent = silent

    def _time_to_begin_at(self) -> Mapping[str, Any]:
        """Return the simulated time that it would be by now: time has gone on for everybody else."""
        if self._simulated is None:
            return {}
        simulated, since, rate = self._simulated
        return {"start_time": simulated + rate * (time.monotonic() - since)}

    # What is heard --------------------------------------------------------------------------------------------------

    def _own_name(self, full_name: str) -> str | None:
        """Return the name of a node of this graph; None for any other."""
        namespace, _, name = full_name.strip("/").rpartition("/")
        return name if namespace == self._namespace and name in self._unit_of else None

    def _on_diagnostics(self, message: Any) -> None:
        now = time.monotonic()
        for status in message.status:
            name = self._own_name(status.name)
            if name is None:
                continue
            unit = self._unit_of[name]
            unit.policy.heard(now)
            if unit.policy.phase is not Phase.UP:
                continue  # on its way up, or with its last breath
            values = {item.key: item.value for item in status.values}
            if values.get("state") in set(Aim):
                unit.aims[name] = Aim(values["state"])
            if name == SIMULATOR_PACKAGE and "simulated_time" in values:
                rate = 0.0 if values.get("phase") == "held" else float(values.get("rate", 1.0))
                self._simulated = float(values["simulated_time"]), now, rate

    def _on_parameters(self, message: Any) -> None:
        name = self._own_name(message.node)
        if name is None or self._unit_of[name].policy.phase not in (Phase.STARTING, Phase.UP):
            return
        # What a node declares at its start is no change; one that had no value before counts as new.
        changed = list(message.changed_parameters)
        if self._unit_of[name].policy.phase is Phase.UP:
            changed += message.new_parameters
        self._parameters.changed(name, {item.name: _plain(parameter_value_to_python(item.value)) for item in changed})

    def _restart_service(self, name: str) -> Callable[[Any, Any], Any]:
        def restart(request: Any, response: Any) -> Any:
            unit, now = self._unit_of[name], time.monotonic()
            self._tell(f"{unit.plan.name}: restart asked for")
            self._do(unit, unit.policy.asked(now), now)
            response.success, response.message = True, f"{unit.plan.name} is being restarted"
            return response

        return restart

    def _publish(self) -> None:
        health = supervision_health({name: unit.policy for name, unit in self._units.items()}, time.monotonic())
        status = to_status(self._node.get_fully_qualified_name().lstrip("/"), health)
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)


def _plain(value: Any) -> Any:
    return list(value) if hasattr(value, "tolist") or isinstance(value, tuple) else value
