"""A whole bag out of a damaged one."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import psutil
from mcap.records import Attachment, Metadata

from dp_tools.bags.copy import BagCopy, custom_data
from dp_tools.bags.errors import BagError
from dp_tools.bags.files import METADATA, BagFiles, bag_files
from dp_tools.bags.salvage import Salvage, SavedMessage
from dp_tools.recorder.bag_writer import RESERVE

_DAMAGED = ".damaged"
# Where the new bag is made until it is whole.
_WORKSHOP = ".repair"


@dataclass
class Repaired:
    """What became of a repair.

    Attributes
    ----------
    bag
        The new bag: a folder, or a file where one file was repaired.
    messages
        Recovered messages by file.
    damage
        What could not be read, with its file.
    kept
        Damaged originals, under their new names.
    """

    bag: Path
    messages: dict[str, int] = field(default_factory=dict)
    damage: list[str] = field(default_factory=list)
    kept: list[Path] = field(default_factory=list)


def repair(path: Path, output: Path | None = None, progress: Callable[[int], None] = lambda done: None) -> Repaired:
    """Write what can be read of a bag as a whole one, with all indexes and metadata.yaml.

    Parameters
    ----------
    path
        Its folder, the folder of a run, or one MCAP file.
    output
        Folder of the new bag; None to put it in the place of the old one, whose files are kept as ``*.damaged``.
    progress
        Called with the bytes read so far.

    Raises
    ------
    BagError
        If there is nothing to read, or an earlier damaged original is in the way.
    RecordingRefusedError, RecordingStoppedError
        If the new bag cannot be written.
    """
    files = _files(path)
    if output is not None:
        done = Repaired(output)
        _write(files, BagCopy(output), done, progress)
        return done
    single = files.path.is_file()
    folder = files.path.parent if single else files.path
    originals = [*files.files, *([folder / METADATA] if not single and (folder / METADATA).exists() else [])]
    for original in originals:
        if original.with_name(original.name + _DAMAGED).exists():
            raise BagError(f"{original.name}{_DAMAGED}: is there already, from an earlier repair; move it away first")
    _expect_no_writer(files)
    workshop = folder / _WORKSHOP
    done = Repaired(files.path)
    try:
        made = workshop / (files.path.stem if single else files.path.absolute().name)
        _write(files, BagCopy(made, overwrite=True), done, progress)
        for original in originals:
            done.kept.append(original.rename(original.with_name(original.name + _DAMAGED)))
        (folder / RESERVE).unlink(missing_ok=True)  # of a recorder that was killed
        for new in sorted(made.iterdir()):
            if not single:
                new.rename(folder / new.name)
            elif new.suffix == ".mcap":
                new.rename(files.path)
    except OSError as error:
        raise BagError(f"{folder}: cannot be written: {error.strerror or error}") from error
    finally:
        shutil.rmtree(workshop, ignore_errors=True)
    return done


def _files(path: Path) -> BagFiles:
    """Return the files of a bag, even if metadata.yaml is no help."""
    try:
        return bag_files(path)
    except BagError:
        folder = path / "bag" if (path / "bag").is_dir() and not list(path.glob("*.mcap")) else path
        found = tuple(sorted(folder.glob("*.mcap"))) if folder.is_dir() else ()
        if not found:
            raise
        return BagFiles(folder, found, None)


def _expect_no_writer(files: BagFiles) -> None:
    """Raise BagError if a process on this machine writes to a file: what looks unfinished may not be finished yet."""
    watched = {str(path.resolve()) for path in files.files}
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            for one in process.open_files():
                if one.path in watched and one.mode != "r":
                    raise BagError(f"{one.path}: is being written by process {process.pid}")


def _write(files: BagFiles, copy: BagCopy, done: Repaired, progress: Callable[[int], None]) -> None:
    before = 0
    custom = custom_data(files.metadata)
    try:
        for path in files.files:
            count, salvage = copy.count, Salvage(path)

            def show(at: int, start: int = before) -> None:
                progress(start + at)

            for one in salvage.saved(show):
                if isinstance(one, SavedMessage):
                    copy.write(one.topic, one.sequence, one.log_time, one.publish_time, one.data)
                elif isinstance(one, Attachment):
                    copy.attach(one)
                elif isinstance(one, Metadata):
                    copy.describe(one)
            done.messages[path.name] = copy.count - count
            done.damage += [f"{path.name}: {error}" for error in salvage.damage]
            before += path.stat().st_size
    except OSError as error:
        raise BagError(f"{files.path}: cannot be read: {error.strerror or error}") from error
    finally:
        custom["repaired"] = "; ".join(done.damage[:10])
        copy.close(custom)
