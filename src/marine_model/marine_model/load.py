"""Vessel files by name or path."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from marine_model.errors import DocumentError, UnknownNameError
from marine_model.vessel import Vessel
from marine_model.yaml_document import FieldPath, YamlDocument, read_yaml, validate

VESSEL_FOLDER = Path(__file__).parent / "vessels"


def vessel_names() -> tuple[str, ...]:
    """Return the names of the vessels that come with this package, sorted."""
    return tuple(sorted(path.stem for path in VESSEL_FOLDER.glob("*.yaml")))


def load_vessel(name_or_path: str | Path) -> Vessel:
    """Return a validated vessel.

    Parameters
    ----------
    name_or_path
        A name out of ``vessel_names()``, or the path of a YAML file (anything with a folder or a suffix).

    Raises
    ------
    UnknownNameError
        If no vessel has that name, or the path does not exist.
    DocumentError
        If the file cannot be read or breaks the schema: one line per problem, with file, line and field.
    """
    document = _merged(vessel_path(name_or_path), ())
    return validate(document.content, Vessel, document)


def vessel_path(name_or_path: str | Path) -> Path:
    """Return the file of a vessel. Raises UnknownNameError."""
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") or len(path.parts) > 1:
        if not path.is_file():
            raise UnknownNameError(f"vessel: no such file: {path}")
        return path
    known = VESSEL_FOLDER / f"{path}.yaml"
    if not known.is_file():
        raise UnknownNameError(f"vessel: expected a path or one of {', '.join(vessel_names())}, found '{name_or_path}'")
    return known


def _merged(path: Path, chain: tuple[Path, ...]) -> YamlDocument:
    """Read ``path`` over the vessel it extends, if any: its own fields win."""
    document = read_yaml(path)
    if "extends" not in document.content:
        return document
    base_name = document.content.pop("extends")
    if not isinstance(base_name, str):
        raise DocumentError(document.problem(("extends",), f"expected a vessel, found {base_name!r}"))
    if path.resolve() in chain:
        raise DocumentError(document.problem(("extends",), "a vessel file extends itself"))
    relative = path.parent / base_name
    base_path = relative if relative.is_file() else vessel_path(base_name)
    base = _merged(base_path, (*chain, path.resolve()))
    lines: dict[FieldPath, int] = {}
    content = _overlay(base.content, document.content, (), (), document.lines, lines)
    return YamlDocument(path, content, lines | {(): 1})


def _overlay(
    base: Any, over: Any, field: FieldPath, own: FieldPath, own_lines: dict[FieldPath, int], out: dict[FieldPath, int]
) -> Any:
    """Return ``over`` laid on ``base``; mappings merge by key, lists of named mappings by name.

    ``own_lines`` has the lines of the file that ``over`` was read from, ``own`` the place in it; ``out`` collects
    them under the places of the merged document.
    """
    if own in own_lines:
        out[field] = own_lines[own]
    if isinstance(base, dict) and isinstance(over, dict):
        merged = dict(base)
        for key, value in over.items():
            merged[key] = _overlay(base.get(key), value, (*field, key), (*own, key), own_lines, out)
        return merged
    if _named(base) and _named(over):
        entries = list(base)
        index = {entry["name"]: i for i, entry in enumerate(entries)}
        for i, value in enumerate(over):
            at = index.get(value["name"], len(entries))
            if at == len(entries):
                entries.append({})
            entries[at] = _overlay(entries[at], value, (*field, at), (*own, i), own_lines, out)
        return entries
    if isinstance(over, dict):
        for key, value in over.items():
            _overlay(None, value, (*field, key), (*own, key), own_lines, out)
    elif isinstance(over, list):
        for i, value in enumerate(over):
            _overlay(None, value, (*field, i), (*own, i), own_lines, out)
    return over


def _named(value: Any) -> bool:
    return (
        isinstance(value, list) and bool(value) and all(isinstance(entry, dict) and "name" in entry for entry in value)
    )
