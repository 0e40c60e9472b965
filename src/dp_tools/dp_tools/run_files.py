"""What a run leaves in its folder, and the parameter file that starts it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dp_tools.parameter_service import to_parameter_file
from dp_tools.scenario import Scenario
from dp_tools.workspace import RING_PACKAGES, SIMULATOR_PACKAGE
from marine_model.errors import DpError
from marine_model.section_text import section_text


class FolderError(DpError):
    """A run folder cannot be used."""


def make_writable(folder: Path, *inside: str) -> None:
    """Make ``folder`` and those ``inside`` it, before the work that shall end up there.

    Raises
    ------
    FolderError
        If one of them cannot be written.
    """
    try:
        for each in (folder, *(folder / name for name in inside)):
            each.mkdir(parents=True, exist_ok=True)
            (each / ".writable").touch()
            (each / ".writable").unlink()
    except OSError as error:
        raise FolderError(f"{folder}: cannot be written: {error.strerror}") from error


@dataclass(frozen=True)
class RunFolder:
    """Paths of one run."""

    path: Path

    @property
    def bag(self) -> Path:
        """Folder of the recording."""
        return self.path / "bag"

    @property
    def logs(self) -> Path:
        """Output of every process."""
        return self.path / "logs"

    @property
    def parameters(self) -> Path:
        """Parameter file that the nodes were started with."""
        return self.path / "parameters.yaml"

    def scenario_file(self, scenario: Scenario) -> Path:
        """Return a file that holds ``scenario``: that which it was loaded from, or one written here."""
        if scenario.path is not None:
            return scenario.path
        path = self.path / f"{scenario.name}.yaml"
        path.write_text(section_text(scenario), encoding="utf-8")
        return path

    def prepare(self, overwrite: bool) -> None:
        """Make the folder.

        Raises
        ------
        FolderError
            If it cannot be written, or holds a recording and ``overwrite`` is false.
        """
        if self.bag.exists():
            # What goes is the recorder's to judge: it replaces a bag and nothing else.
            if not overwrite:
                raise FolderError(f"{self.bag}: holds a recording; choose another --output, or --overwrite it")
        make_writable(self.path, self.logs.name)


@dataclass(frozen=True)
class Pace:
    """How simulated time goes: lockstep waits for the ring; rate is simulated over wall seconds, 0 for no limit."""

    lockstep: bool
    rate: float


def start_parameters(vessel: str, scenario: Scenario | None, pace: Pace, hold: bool) -> dict[str, dict[str, Any]]:
    """Return parameters by node: vessel, pace, and what the scenario says."""
    values: dict[str, dict[str, Any]] = {package: {"vessel": vessel} for package in (*RING_PACKAGES, SIMULATOR_PACKAGE)}
    for package in RING_PACKAGES:
        values[package]["synchronous"] = pace.lockstep
    values[SIMULATOR_PACKAGE] |= {"lockstep": pace.lockstep, "rate": float(pace.rate), "hold": hold}
    if scenario is not None:
        for node, own in scenario.start_parameters.items():
            values[node] |= own
    return values


def write_start_parameters(folder: RunFolder, values: dict[str, dict[str, Any]]) -> None:
    """Write the parameter file of a run."""
    folder.parameters.write_text(to_parameter_file(values), encoding="utf-8")
