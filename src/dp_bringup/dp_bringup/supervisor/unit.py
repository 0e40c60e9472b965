"""One process under supervision: what is started, with which nodes in it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from dp_bringup.graph_nodes import NODES
from dp_bringup.processes import Child, Children
from dp_bringup.supervisor.bring_up import BringUp
from dp_bringup.supervisor.life_cycle import Aim
from dp_bringup.supervisor.policy import Policy
from dp_bringup.supervisor.rules import Rules
from dp_bringup.workspace import SIMULATOR_PACKAGE, executable

COMPOSED = "composed"


@dataclass(frozen=True)
class UnitPlan:
    """A process to supervise.

    Parameters
    ----------
    name
        Of the process.
    nodes
        Names of its nodes, in the order in which they are activated.
    executable
        What is run.
    """

    name: str
    nodes: tuple[str, ...]
    executable: Path


def plan_units(composed: bool, simulate: bool = True) -> list[UnitPlan]:
    """Return the processes of the graph, in the order of activation; all nodes in one if ``composed``.

    Raises
    ------
    WorkspaceError
        If an executable is not there.
    """
    nodes = tuple(node for node in NODES if simulate or node != SIMULATOR_PACKAGE)
    if composed:
        return [UnitPlan(COMPOSED, nodes, executable("dp_bringup", COMPOSED))]
    return [UnitPlan(node, (node,), executable(node, "node")) for node in nodes]


class Unit:
    """The process of one plan, and what is known of it."""

    def __init__(self, plan: UnitPlan, rules: Rules) -> None:
        self.plan = plan
        self.policy = Policy(rules)
        self.child: Child | None = None
        self.bring_up: BringUp | None = None
        self.aims = dict.fromkeys(plan.nodes, Aim.ACTIVE)
        self.told_silent = False

    def start(
        self, children: Children, arguments: list[str | Path], shield: Callable[[], AbstractContextManager[None]]
    ) -> None:
        """Start the process; nothing interrupts between its start and its entry in the list of who is to be stopped."""
        words: list[str | Path] = [self.plan.executable]
        if self.plan.name == COMPOSED:
            words += self.plan.nodes
        with shield():
            self.child = children.start(self.plan.name, [*words, *arguments], again=self.policy.restarts > 0)

    def forget(self, children: Children) -> None:
        """Give up what belongs to a process that has ended."""
        if self.bring_up is not None:
            self.bring_up.close()
            self.bring_up = None
        if self.child is not None:
            children.stop([self.child])
            self.child = None
