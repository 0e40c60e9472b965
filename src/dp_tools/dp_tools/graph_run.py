"""One run of the graph: start its processes, play a scenario or wait for Ctrl-C, stop everything in order."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from dp_tools.conductor import Conductor
from dp_tools.operator_node import Operator, operator
from dp_tools.processes import Child, Children
from dp_tools.run_files import Pace, RunFolder, start_parameters, write_start_parameters
from dp_tools.scenario import Scenario
from dp_tools.workspace import RING_PACKAGES, SIMULATOR_PACKAGE, executable
from marine_model.errors import DpError

_RECORDER = "recorder"
_RECORDER_SECONDS = 20.0


class GraphRunningError(DpError):
    """A graph runs already where this one was to start."""


class UncleanStopError(DpError):
    """The run went through, but a process did not end cleanly; the message says which."""


@dataclass(frozen=True)
class GraphRun:
    """What to run and how.

    Parameters
    ----------
    folder
        Where logs, parameters and the recording go.
    vessel
        Name or path.
    scenario
        What to play; None runs until interrupted.
    pace
        Real time, scaled time or lockstep.
    record
        True to record every topic.
    composed
        True for one process instead of one a node.
    namespace
        Namespace of the whole graph, empty for none.
    overwrite
        True to replace a recording that is there.
    """

    folder: RunFolder
    vessel: str
    scenario: Scenario | None
    pace: Pace
    record: bool
    composed: bool
    namespace: str = ""
    overwrite: bool = False

    def sail(
        self,
        say: Callable[[str], None],
        progress: Callable[[float], None],
        arrived: Callable[[Sequence[Child]], None] = lambda running: None,
    ) -> None:
        """Run to the end of the scenario, or until KeyboardInterrupt.

        ``say`` is told what begins, ``progress`` the simulated time (s) now and then, and ``arrived`` the processes
        of the graph when the scenario has been played and before any of them is stopped.

        Raises
        ------
        DpError
            If a process dies or refuses to start, or a node does not answer; everything is stopped first.
        """
        write_start_parameters(
            self.folder,
            start_parameters(self.vessel, self.scenario, self.pace, hold=self.scenario is not None),
        )
        children = Children(self.folder.logs)
        recorders: list[Child] = []
        problems: list[str] = []
        try:
            with operator(self.namespace) as one:
                self._refuse_company(one)
                one.watch = children.check
                if self.record:
                    recorders.append(self._start_recorder(children))
                    one.wait_until(
                        lambda: _RECORDER in one.node.get_node_names(),
                        _RECORDER_SECONDS,
                        "the recorder",
                    )
                say("starting nodes")
                self._start_nodes(children)
                self._conduct(one, say, progress)
                arrived(children.running)
        finally:
            # The recorder goes last, so that it has what the nodes said on their way out.
            nodes = [child for child in children.all if child not in recorders]
            problems += children.stop(nodes)
            problems += children.stop()
        if problems:
            raise UncleanStopError("\n".join(problems))

    def _refuse_company(self, one: Operator) -> None:
        """Raise GraphRunningError if nodes of our names are there already: two graphs would mix their messages."""
        namespace = one.node.get_namespace()
        ours = (*RING_PACKAGES, SIMULATOR_PACKAGE)

        def present() -> list[str]:
            found = one.node.get_node_names_and_namespaces()
            return sorted(name for name, place in found if place == namespace and name in ours)

        found = one.settled(present, quiet=0.5)
        if found:
            domain = os.environ.get("ROS_DOMAIN_ID", "0")
            raise GraphRunningError(
                f"ROS domain {domain}, namespace {namespace}: expected no graph, found {', '.join(found)} running; "
                "stop it, or choose another --namespace or ROS_DOMAIN_ID"
            )

    def _conduct(self, one: Operator, say: Callable[[str], None], progress: Callable[[float], None]) -> None:
        nodes = (*RING_PACKAGES, SIMULATOR_PACKAGE)
        if self.scenario is None:
            say("running; Ctrl-C stops")
            one.wait_until(lambda: False, None, "Ctrl-C")
            return
        conductor = Conductor(one, self.scenario, nodes)
        conductor.wait_for_graph()
        say("sailing")
        conductor.play(progress)

    def _arguments(self) -> list[str | Path]:
        arguments: list[str | Path] = ["--ros-args", "--params-file", self.folder.parameters]
        if self.namespace:
            arguments += ["-r", f"__ns:=/{self.namespace.strip('/')}"]
        return arguments

    def _start_nodes(self, children: Children) -> None:
        packages = (*RING_PACKAGES, SIMULATOR_PACKAGE)
        if self.composed:
            children.start("composed", [executable("dp_tools", "composed"), *self._arguments()])
            return
        for package in packages:
            children.start(package, [executable(package, "node"), *self._arguments()])

    def _start_recorder(self, children: Children) -> Child:
        parameters = {"output": str(self.folder.bag), "vessel": self.vessel, "overwrite": str(self.overwrite).lower()}
        if self.scenario is not None:
            parameters["scenario"] = str(self.scenario.path)
        arguments: list[str | Path] = [executable("dp_tools", _RECORDER), "--ros-args"]
        for name, value in parameters.items():
            arguments += ["-p", f"{name}:={value}"]
        return children.start(_RECORDER, arguments)
