"""One run of the graph: start its processes, play a scenario or wait for Ctrl-C, stop everything in order."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dp_bringup.graph_lock import graph_lock
from dp_bringup.graph_nodes import NODES, START_SECONDS, is_there, present, unheard, wait_until_active
from dp_bringup.interrupts import Interrupts
from dp_bringup.operator_node import Operator, operator
from dp_bringup.parameter_file import read_parameter_file
from dp_bringup.processes import Child, Children
from dp_bringup.supervisor import SUPERVISOR, Rules, Supervisor, plan_units
from dp_bringup.workspace import executable, share
from dp_tools.conductor import Conductor
from dp_tools.recorder import RECORDER_EARS
from dp_tools.recorder.compression import DEFAULT_COMPRESSION
from dp_tools.recording_watch import RecordingWatch
from dp_tools.run_files import Pace, start_parameters, write_start_parameters
from dp_tools.run_folder import RunFolder
from dp_tools.scenario import Scenario
from marine_model.errors import DpError


class GraphRunningError(DpError):
    """A graph runs already where this one was to start."""


class GivenUpError(DpError):
    """A process died again and again; the message names it."""


class UncleanStopError(DpError):
    """The run went through, but a process did not end cleanly; the message says which."""


@dataclass(frozen=True)
class Supervision:
    """That processes which die are started again, and who is told.

    Parameters
    ----------
    tell
        Told what happens, one line each.
    rules
        Patience.
    """

    tell: Callable[[str], None]
    rules: Rules


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
    compression
        Of the recording: zstd, lz4 or none.
    supervision
        None stops the run with the reason if a process dies. A run in lockstep always does: with a process that was
        started in the middle of it, it is not repeatable.
    """

    folder: RunFolder
    vessel: str
    scenario: Scenario | None
    pace: Pace
    record: bool
    composed: bool
    namespace: str = ""
    overwrite: bool = False
    compression: str = DEFAULT_COMPRESSION
    supervision: Supervision | None = None

    def sail(
        self,
        say: Callable[[str], None],
        progress: Callable[[float], None],
        arrived: Callable[[Sequence[Child]], None] = lambda running: None,
        warn: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Run to the end of the scenario, or until interrupted.

        ``say`` is told what begins, ``progress`` the simulated time (s) now and then, and ``arrived`` the processes
        of the graph when the scenario has been played and before any of them is stopped. ``warn`` is told at once that
        the recording has come to its end before the run, which goes on without it.

        Raises
        ------
        GraphRunningError
            If the graph runs already.
        UncleanStopError
            If the run went through, but the recorder or the end of a process was not as it should be.
        DpError
            If a process of the graph dies or refuses to start, or a node does not answer; everything is stopped first.
        KeyboardInterrupt
            On SIGINT, SIGTERM or SIGHUP; everything is stopped first.
        """
        domain = os.environ.get("ROS_DOMAIN_ID", "0")
        with graph_lock(domain, self.namespace) as free:
            if not free:
                raise GraphRunningError(
                    f"ROS domain {domain}, namespace /{self.namespace.strip('/')}: expected no graph, found one that "
                    "another dp up runs; stop it, or choose another --namespace or ROS_DOMAIN_ID"
                )
            self._sail(say, progress, arrived, warn)

    def _sail(
        self,
        say: Callable[[str], None],
        progress: Callable[[float], None],
        arrived: Callable[[Sequence[Child]], None],
        warn: Callable[[str], None],
    ) -> None:
        children = Children(self.folder.logs)
        recorders: list[Child] = []
        recording = RecordingWatch(self.folder.bag, warn)

        def watch() -> None:
            children.check(leave_out=recorders)
            recording.look()

        problems: list[str] = []
        interrupted: KeyboardInterrupt | None = None
        is_up = False
        with Interrupts() as interrupts:
            try:
                with operator(self.namespace) as one:
                    one.settled(lambda: present(one), quiet=0.5)
                    self._refuse_company(one, ours=0)
                    write_start_parameters(self.folder, self._start_parameters())
                    one.watch = children.check
                    if self.record:
                        say("starting recorder")
                        with interrupts.held_back():
                            recorders.append(self._start_recorder(children, recording.hear))
                        one.wait_until(lambda: is_there(one, RECORDER_EARS), START_SECONDS, "the recorder")
                        # From here on the graph does without it, if it must.
                        recording.recorder = recorders[0]
                        one.watch = watch
                    say("starting nodes")
                    supervisor = None
                    if self.supervision is None or self.pace.lockstep:
                        with interrupts.held_back():
                            self._start_nodes(children)
                        wait_until_active(one)
                    else:
                        supervisor = self._supervise(one, children, self.supervision, interrupts, recording)
                    is_up = True
                    # A graph that announces itself late has been heard of by now.
                    self._refuse_company(one, ours=1)
                    # Made first: the recorder shall hear its topics as well.
                    conductor = None if self.scenario is None else Conductor(one, self.scenario, supervisor)
                    if self.record:
                        one.wait_until(
                            lambda: recording.over or not unheard(one, RECORDER_EARS),
                            START_SECONDS,
                            "the recorder to listen",
                        )
                    if conductor is None:
                        say("running; Ctrl-C stops")
                        one.wait_until(lambda: False, None, "Ctrl-C")
                    else:
                        say("sailing")
                        conductor.play(progress)
                    arrived(children.running)
            except KeyboardInterrupt as error:
                interrupted = error
            finally:
                # However often somebody asks for it: nothing is left running.
                with interrupts.ignored():
                    if children.all:
                        say("stopping")
                    # The recorder goes last, so that it has what the nodes said on their way out.
                    nodes = [child for child in children.all if child not in recorders]
                    found = children.stop(nodes)
                    # A node that was still starting has no clean way to stop yet.
                    problems += found if is_up or interrupted is None else []
                    problems += recording.problems()
                    problems += children.stop()
        if problems:
            raise UncleanStopError("\n".join(problems)) from interrupted
        if interrupted is not None:
            raise interrupted

    def _refuse_company(self, one: Operator, ours: int) -> None:
        """Raise GraphRunningError if more than ``ours`` nodes have one name: two graphs would mix their messages."""
        found = sorted(name for name, count in Counter(present(one)).items() if count > ours)
        if found:
            domain = os.environ.get("ROS_DOMAIN_ID", "0")
            raise GraphRunningError(
                f"ROS domain {domain}, namespace {one.node.get_namespace()}: expected no graph, found "
                f"{', '.join(found)} running; stop it, or choose another --namespace or ROS_DOMAIN_ID"
            )

    def _start_parameters(self) -> dict[str, dict[str, Any]]:
        # Without a scenario it is the graph that the launch file starts.
        base = read_parameter_file(share("dp_bringup") / "config" / "defaults.yaml") if self.scenario is None else {}
        own = start_parameters(self.vessel, self.scenario, self.pace, hold=self.scenario is not None)
        return {node: base.get(node, {}) | values for node, values in own.items()}

    def _supervise(
        self,
        one: Operator,
        children: Children,
        supervision: Supervision,
        interrupts: Interrupts,
        recording: RecordingWatch,
    ) -> Supervisor:
        """Bring the nodes up; whenever somebody waits from now on, they are looked after."""
        node = one.make_node(SUPERVISOR)
        supervisor = Supervisor(
            node,
            plan_units(self.composed),
            children,
            self.folder.logs,
            self._start_parameters(),
            self._names(),
            supervision.rules,
            supervision.tell,
            interrupts.held_back,
        )

        def watch() -> None:
            supervisor.look()
            recorders = [] if recording.recorder is None else [recording.recorder]
            children.check(leave_out=[*supervisor.supervised, *recorders])
            recording.look()
            if self.scenario is not None and supervisor.given_up:
                raise GivenUpError(f"{', '.join(supervisor.given_up)}: given up; a scenario cannot be sailed without")

        one.watch = watch
        one.wait_until(lambda: supervisor.all_up, START_SECONDS * len(NODES), "the nodes to come up")
        return supervisor

    def _names(self) -> list[str | Path]:
        return ["-r", f"__ns:=/{self.namespace.strip('/')}"] if self.namespace else []

    def _start_nodes(self, children: Children) -> None:
        arguments = ["--ros-args", "--params-file", self.folder.parameters, *self._names()]
        if self.composed:
            children.start("composed", [executable("dp_bringup", "composed"), *arguments])
            return
        for package in NODES:
            children.start(package, [executable(package, "node"), *arguments])

    def _start_recorder(self, children: Children, heard: Callable[[str], None]) -> Child:
        parameters = {
            "output": str(self.folder.bag),
            "vessel": self.vessel,
            "overwrite": str(self.overwrite).lower(),
            "compression": self.compression,
        }
        if self.scenario is not None:
            parameters["scenario"] = str(self.folder.scenario_file(self.scenario))
        arguments: list[str | Path] = [executable("dp_tools", "recorder"), "--ros-args", *self._names()]
        for name, value in parameters.items():
            arguments += ["-p", f"{name}:={value}"]
        return children.start("recorder", arguments, heard)
