"""YAML files that come with a package and go by name, beside those that anybody names by path."""

from __future__ import annotations

from pathlib import Path

from marine_model.errors import UnknownNameError


def file_names(folder: Path) -> tuple[str, ...]:
    """Return the names of the YAML files in ``folder``, sorted."""
    return tuple(sorted(path.stem for path in folder.glob("*.yaml")))


def is_path(name_or_path: str | Path) -> bool:
    """Return whether this is a path, with a folder or a suffix, and no name."""
    path = Path(name_or_path)
    return path.suffix in (".yaml", ".yml") or len(path.parts) > 1


def named_file(kind: str, name_or_path: str | Path, folder: Path) -> Path:
    """Return the file that is meant.

    Parameters
    ----------
    kind
        What it describes, for the message: "vessel".
    name_or_path
        A name out of ``file_names(folder)``, or a path.
    folder
        Where the files with names are.

    Raises
    ------
    UnknownNameError
        If there is no such file.
    """
    path = Path(name_or_path)
    if is_path(path):
        if not path.is_file():
            raise UnknownNameError(f"{kind}: no such file: {path}")
        return path
    known = folder / f"{path}.yaml"
    if not known.is_file():
        raise UnknownNameError(
            f"{kind}: expected a path or one of {', '.join(file_names(folder))}, found '{name_or_path}'"
        )
    return known
