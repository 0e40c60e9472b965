"""The `dp` command as an operator uses it: in a process of its own, watched, and cleaned up after."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import psutil
import yaml

from support.domains import reserve_domain_id
from support.waiting import wait_until

_COMMAND = (sys.executable, "-c", "from dp_tools.cli import main; main()")
# Far above what any run here takes on a loaded machine: bounds a failure only.
LONGEST = 240.0


class DpProcess:
    """One `dp` process with its children. As a context it leaves none of them behind."""

    def __init__(
        self,
        *arguments: str | Path,
        cwd: Path | None = None,
        environment: Mapping[str, str] | None = None,
        before: Callable[[], None] | None = None,
        prefix: Sequence[str | Path] = (),
    ) -> None:
        # A file, so that nobody blocks on a full pipe.
        self._output = tempfile.TemporaryFile("w+")  # noqa: SIM115
        self._process = subprocess.Popen(
            [*map(str, prefix), *_COMMAND, *map(str, arguments)],
            stdout=self._output,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            cwd=cwd,
            # Wide enough that no message is broken.
            env={**os.environ, "COLUMNS": "250", **(environment or {})},
            preexec_fn=before,
        )
        self._seen: dict[int, psutil.Process] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.children()
        self._process.kill()
        self._process.wait()
        for child in self.left_behind():
            with suppress(psutil.NoSuchProcess):
                child.kill()
        self._output.close()

    @property
    def output(self) -> str:
        """Everything said so far."""
        self._output.seek(0)
        return self._output.read()

    @property
    def running(self) -> bool:
        return self._process.poll() is None

    def children(self) -> dict[str, psutil.Process]:
        """Processes that it started and that still run: by package, composed and recorder by their own names."""
        found = {}
        with suppress(psutil.NoSuchProcess):
            for child in psutil.Process(self._process.pid).children(recursive=True):
                self._seen[child.pid] = child
                with suppress(psutil.NoSuchProcess, psutil.ZombieProcess):
                    executable = next(
                        (Path(word) for word in child.cmdline() if "/lib/" in word and "python" not in word), None
                    )
                    if executable is not None:
                        name = executable.parent.name if executable.name == "node" else executable.name
                        found[name] = child
        return found

    def left_behind(self) -> list[psutil.Process]:
        """Processes that it had started when :meth:`children` was last called, and that still run."""
        return [c for c in self._seen.values() if c.is_running() and c.status() != psutil.STATUS_ZOMBIE]

    def wait_until(self, condition: Callable[[], object], message: str, timeout: float = LONGEST / 2) -> None:
        """Wait for a condition; fails with everything that was said if the command ends before."""

        def done() -> bool:
            if condition():
                return True
            assert self.running, f"ended before {message}:\n{self.output}"
            return False

        wait_until(done, timeout=timeout, message=lambda: f"{message}; it said:\n{self.output}")

    def signal(self, number: signal.Signals) -> None:
        self._process.send_signal(number)

    def wait(self, timeout: float = LONGEST) -> int:
        """Return the exit code."""
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"not within {timeout} s: the end of dp; it said:\n{self.output}") from None


def dp(*arguments: str | Path, **options: Any) -> tuple[int, str]:
    """Run a command to its end; return exit code and output."""
    with DpProcess(*arguments, **options) as process:
        code = process.wait()
        return code, process.output


@contextmanager
def own_domain() -> Iterator[dict[str, str]]:
    """A ROS domain for a fixture that outlives a test, as environment variables."""
    with reserve_domain_id() as domain_id:
        yield {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def write_scenario(folder: Path, duration: float = 20.0, **fields: Any) -> Path:
    """Write a scenario: waves, steps of the set point, azimuth modes; ``fields`` replace what they name."""
    content: dict[str, Any] = {
        "name": "trial",
        "title": "Trial",
        "description": "",
        "vessel": "cybership3",
        "duration": duration,
        "seed": 7,
        "parameters": {
            "vessel_sim": {"waves.amplitude": 0.04, "waves.period": 0.9, "waves.direction": 2.8},
            "dp_controller": {"mode": "setpoint"},
            "thrust_allocator": {"azimuth_mode": "fixed"},
        },
        "events": [
            {"at": 0.0, "setpoint": [0.0, 0.0, 0.0]},
            {"at": 4.0, "setpoint": [0.3, -0.2, 0.1]},
            {"at": 8.0, "parameters": {"thrust_allocator": {"azimuth_mode": "rotating"}}},
            # Two at one time, and the way back.
            {"at": 14.0, "parameters": {"thrust_allocator": {"azimuth_mode": "fixed"}}},
            {"at": 14.0, "setpoint": [0.0, 0.0, -0.1], "parameters": {"dp_controller": {"transfer_time": 1.0}}},
        ],
    }
    path = folder / "trial.yaml"
    path.write_text(yaml.safe_dump(content | fields), encoding="utf-8")
    return path
