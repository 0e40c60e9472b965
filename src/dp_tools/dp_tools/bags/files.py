"""Which files a bag consists of."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dp_tools.bags.errors import BagError
from dp_tools.bags.yaml_text import YAML_ERRORS, from_yaml

METADATA = "metadata.yaml"
_NUMBER = re.compile(r"_(\d+)\.mcap$")


@dataclass(frozen=True)
class BagFiles:
    """Files of a bag.

    Attributes
    ----------
    path
        As named by the user: a folder or an MCAP file.
    files
        MCAP files in order of recording.
    metadata
        What metadata.yaml says, under ``rosbag2_bagfile_information``; None where there is none, as the recording was
        not closed, or where one file was named.
    """

    path: Path
    files: tuple[Path, ...]
    metadata: Mapping[str, Any] | None


def bag_files(path: Path) -> BagFiles:
    """Return the files of a bag, given its folder, the folder of a run, or one MCAP file.

    Raises
    ------
    BagError
        If there are none, metadata.yaml cannot be read, or it names files that are not there.
    """
    try:
        if path.is_file():
            return BagFiles(path, (path,), None)
        if not path.is_dir():
            raise BagError(f"{path}: no such bag")
        folder = path
        found = _in_order(folder)
        if not found and (path / "bag").is_dir():
            folder = path / "bag"
            found = _in_order(folder)
        metadata = read_metadata(folder / METADATA) if (folder / METADATA).exists() else None
        if metadata is not None:
            found = _named(folder, metadata)
    except OSError as error:
        raise BagError(f"{path}: cannot be read: {error.strerror or error}") from error
    if not found:
        raise BagError(f"{path}: expected MCAP files, found none")
    return BagFiles(folder, found, metadata)


def _in_order(folder: Path) -> tuple[Path, ...]:
    def key(path: Path) -> tuple[int, str]:
        number = _NUMBER.search(path.name)
        return (int(number[1]) if number else 0, path.name)

    return tuple(sorted(folder.glob("*.mcap"), key=key))


def read_metadata(path: Path) -> Mapping[str, Any]:
    """Return what metadata.yaml says. Raises BagError, OSError."""
    try:
        document = from_yaml(path.read_text(encoding="utf-8"))
        information = document["rosbag2_bagfile_information"]
    except (*YAML_ERRORS, KeyError, TypeError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise BagError(f"{path}: not the metadata of a bag: {reason}") from error
    if not isinstance(information, dict):
        raise BagError(f"{path}: not the metadata of a bag: rosbag2_bagfile_information is no mapping")
    return information


def _named(folder: Path, metadata: Mapping[str, Any]) -> tuple[Path, ...]:
    names = metadata.get("relative_file_paths")
    if not isinstance(names, list) or not names or not all(isinstance(name, str) and name for name in names):
        raise BagError(f"{folder / METADATA}: relative_file_paths: expected names of files, found {names}")
    for name in names:
        if not (folder / name).is_file():
            raise BagError(f"{folder / METADATA}: names {name}, which is not there")
        if not name.endswith(".mcap"):
            raise BagError(f"{folder / name}: expected an MCAP file; other storage is not read here")
    return tuple(folder / name for name in names)
