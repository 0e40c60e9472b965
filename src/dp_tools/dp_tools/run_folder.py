"""Folders that runs and reports are written into."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from marine_model.errors import DpError
from marine_model.section_text import section_text

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


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
