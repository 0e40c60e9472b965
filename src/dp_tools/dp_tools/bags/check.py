"""Everything that can be checked of a bag."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from dp_tools.bags.bag import open_bag
from dp_tools.bags.content import check_content
from dp_tools.bags.errors import BagError
from dp_tools.bags.files import bag_files
from dp_tools.bags.finding import Finding
from dp_tools.bags.metadata_check import check_metadata
from dp_tools.bags.structure import StructureCheck


@dataclass
class Checked:
    """Outcome of a check.

    Attributes
    ----------
    structure
        Findings about the files themselves and metadata.yaml: what a repair sees to.
    content
        Findings about the messages.
    messages
        Number of messages that can be read.
    """

    structure: list[Finding] = field(default_factory=list)
    content: list[Finding] = field(default_factory=list)
    messages: int = 0

    @property
    def needs_repair(self) -> bool:
        """Whether the files are damaged."""
        return any(finding.wrong for finding in self.structure)

    @property
    def whole(self) -> bool:
        """Whether nothing is wrong."""
        return not any(finding.wrong for finding in (*self.structure, *self.content))


def check_bag(path: Path, progress: Callable[[int], None] = lambda done: None) -> Checked:
    """Check a bag.

    Parameters
    ----------
    path
        Its folder, the folder of a run, or one MCAP file.
    progress
        Called with the bytes read so far.

    Raises
    ------
    BagError
        If there is no bag, or it cannot be read at all.
    """
    checked = Checked()
    files = bag_files(path)
    done = 0
    counts = {}
    for file in files.files:
        structure = StructureCheck(file)

        def show(at: int, start: int = done) -> None:
            progress(start + at)

        try:
            structure.run(show)
            done += file.stat().st_size
        except OSError as error:
            raise BagError(f"{file}: cannot be read: {error.strerror or error}") from error
        checked.structure += structure.findings
        counts[file.name] = structure.contents.messages.total()
        checked.messages += structure.contents.messages.total()
    try:
        with open_bag(path) as bag:
            checked.messages = len(bag.messages)
            checked.structure += check_metadata(bag, counts)
            checked.content += check_content(bag)
    except BagError as error:
        # What is damaged has been told; the messages are looked at once it is repaired.
        if not checked.needs_repair:
            checked.structure.append(Finding(file.name, str(error)))
    return checked
