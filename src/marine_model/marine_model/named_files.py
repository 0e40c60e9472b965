"""YAML files that come with a package and go by name, beside those that anybody names by path."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from marine_model.errors import UnknownNameError


def file_names(folder: Path) -> tuple[str, ...]:
    """Return the names of the YAML files in ``folder``, sorted."""
    return tuple(sorted(path.stem for path in folder.glob("*.yaml")))


def named_file(kind: str, name_or_path: str | Path, find_folder: Callable[[], Path]) -> Path:
    """Return the file that is meant.

    Parameters
    ----------
    kind
        What it describes, for the message: "vessel".
    name_or_path
        A name out of ``file_names`` of the folder, or a path: anything with a folder or a suffix.
    find_folder
        Returns where the files with names are; asked for a name only, as a path needs no such folder.

    Raises
    ------
    UnknownNameError
        If there is no such file.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") or len(path.parts) > 1:
        if not path.is_file():
            raise UnknownNameError(f"{kind}: no such file: {path}")
        return path
    folder = find_folder()
    known = folder / f"{path}.yaml"
    if not known.is_file():
        raise UnknownNameError(
            f"{kind}: expected a path or one of {', '.join(file_names(folder))}, found '{name_or_path}'"
        )
    return known
