"""The graph by the wall clock, one process a node, each of them at hand: to be stopped, cut off and starved."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import psutil

from dp_bringup.parameter_file import to_parameter_file
from dp_bringup.processes import Child, Children
from dp_bringup.workspace import executable
from dp_tools.run_files import Pace, start_parameters
from support import graph_watch
from support.graph_watch import Watch
from support.waiting import wait_until

NODES = ("vessel_sim", "dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers")
# Bounds a failure only: interpreters of seven processes start on a machine that is busy with other things.
START = 90.0


class GraphRig:
    """Five nodes, a watch, and more if asked for. As a context it leaves no process behind.

    Parameters
    ----------
    folder
        For logs, parameters and what the watch hears.
    rate
        Simulated seconds a wall second.
    parameters
        By node, beside the usual.
    prefix
        By process: words before its command, e.g. to run it in a network namespace. ``watch`` for the watch.
    remap
        By node: rules ``from:=to``.
    disturber
        Parameters of a disturber; None for none.
    """

    def __init__(
        self,
        folder: Path,
        rate: float,
        parameters: Mapping[str, Mapping[str, Any]] | None = None,
        prefix: Mapping[str, Sequence[str]] | None = None,
        remap: Mapping[str, Sequence[str]] | None = None,
        disturber: bool = False,
    ) -> None:
        self._prefix = prefix or {}
        values = start_parameters("cybership3", None, Pace(False, rate), hold=False)
        for node, own in (parameters or {}).items():
            values[node] |= own
        path = folder / "parameters.yaml"
        path.write_text(to_parameter_file(values), encoding="utf-8")
        self._children = Children(folder / "logs")
        self._processes: dict[str, Child] = {}
        self.watch = Watch(folder / "heard.jsonl")
        try:
            self._start("watch", [sys.executable, graph_watch.__file__, str(folder / "heard.jsonl")])
            if disturber:
                self._start("disturber", [sys.executable, "-m", "dp_tools.disturber.node", "--ros-args"])
            for name in NODES:
                rules = [word for rule in (remap or {}).get(name, ()) for word in ("-r", rule)]
                self._start(name, [str(executable(name, "node")), "--ros-args", "--params-file", str(path), *rules])
        except BaseException:
            self.close()
            raise

    def _start(self, name: str, command: Sequence[str]) -> None:
        self._processes[name] = self._children.start(name, [*self._prefix.get(name, ()), *command])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Continue what is stopped, and stop everything."""
        for child in self._children.running:
            child.request_stop(signal.SIGCONT)
        self._children.stop()

    def process(self, name: str) -> psutil.Process:
        return psutil.Process(self._processes[name].pid)

    def freeze(self, name: str) -> None:
        """Stop a process (SIGSTOP), and wait until it is stopped."""
        self._processes[name].request_stop(signal.SIGSTOP)
        self.wait_until(lambda: self.process(name).status() == psutil.STATUS_STOPPED, f"{name} to be stopped")

    def thaw(self, name: str) -> None:
        self._processes[name].request_stop(signal.SIGCONT)

    def wait_until(self, condition: Callable[[], object], what: str, timeout: float = START) -> None:
        """Wait until a condition on what was heard holds; fails at once if a process has died."""

        def done() -> bool:
            self._children.check()
            self.watch.read()
            return bool(condition())

        wait_until(done, timeout=timeout, message=lambda: f"{what}; active alarms: {self.watch.active}")

    @property
    def time(self) -> float:
        """Simulated time of the newest feedback heard, s."""
        return self.watch.read().last.get("thruster_feedback", 0.0)

    def sail(self, seconds: float) -> None:
        """Wait until so much simulated time has passed."""
        until = self.time + seconds
        self.wait_until(lambda: self.time >= until, f"simulated time {until:.1f} s")

    def wait_until_calm(self, what: str = "all nodes to be without an alarm") -> float:
        """Wait until every node reports, anew and without an alarm; return how long it took (wall s)."""
        now = time.monotonic()
        self.wait_until(lambda: self.watch.calm_since(now, set(NODES)), what)
        return time.monotonic() - now
