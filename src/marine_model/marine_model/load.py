"""Vessel files by name or path, with the data files of their propellers and drives."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from marine_model.errors import DocumentError, UnknownNameError
from marine_model.named_files import file_names, named_file
from marine_model.propellers.sections import DATA_FIELDS
from marine_model.vessel import Vessel
from marine_model.wave_response.load import FOLDER, wave_response_path
from marine_model.yaml_document import FieldPath, YamlDocument, read_yaml, validate

VESSEL_FOLDER = Path(__file__).parent / "vessels"
DATA_FOLDER = Path(__file__).parent / "data"
DRIVE_FOLDER = Path(__file__).parent / "drive_files"


def vessel_names() -> tuple[str, ...]:
    """Return the names of the vessels that come with this package, sorted."""
    return file_names(VESSEL_FOLDER)


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
    document = with_propeller_data(_merged(vessel_path(name_or_path), ()))
    _find_wave_response(document)
    return validate(document.content, Vessel, document)


def vessel_path(name_or_path: str | Path) -> Path:
    """Return the file of a vessel. Raises UnknownNameError."""
    return named_file("vessel", name_or_path, lambda: VESSEL_FOLDER)


def _merged(path: Path, chain: tuple[Path, ...]) -> YamlDocument:
    """Read ``path`` over the vessel it extends, if any: its own fields win."""
    document = read_yaml(path)
    if "extends" not in document.content:
        return document
    here = ("extends",)
    base_name = document.content.pop("extends")
    if not isinstance(base_name, str):
        raise DocumentError(document.problem(here, f"expected a vessel, found {base_name!r}"))
    if path.resolve() in chain:
        raise DocumentError(document.problem(here, "a vessel file extends itself"))
    relative = path.parent / base_name
    try:
        base_path = relative if relative.is_file() else vessel_path(base_name)
    except UnknownNameError as error:
        raise UnknownNameError(document.problem(here, str(error))) from error
    return _Overlay(_merged(base_path, (*chain, path.resolve())), document).document()


def _find_wave_response(document: YamlDocument) -> None:
    """Put the path of a data file that is named by path in its place: such a path starts from the file that has it.

    Raises DocumentError if there is no such file. What is in it is read when it is asked for.
    """
    forces = document.content.get("wave_forces")
    if not isinstance(forces, dict):
        return
    name = forces.get("response")
    if not isinstance(name, str) or not name:
        return
    place = ("wave_forces", "response")
    try:
        path = wave_response_path(name, document.files.get(place, document.path).parent)
    except UnknownNameError as error:
        raise DocumentError(document.problem(place, str(error))) from error
    if path.parent != FOLDER:
        forces["response"] = str(path.resolve())


def with_propeller_data(document: YamlDocument) -> YamlDocument:
    """Put the content of every propeller's and drive's data file in the place of its name, as if it stood there.

    ``document`` is a vessel or propeller file. Problems in the data are told with file and line of the data file.
    Raises DocumentError.
    """
    lines, files = dict(document.lines), dict(document.files)

    def insert(name: Any, place: FieldPath, at: FieldPath, folder: Path) -> Any:
        """Return the content of the file ``name``, which is named at ``place`` and stands for what is ``at``."""
        if not isinstance(name, str):
            raise DocumentError(document.problem(place, f"expected a file name, found {name!r}"))
        path = _data_path(name, document, place, folder)
        data = read_yaml(path)
        for within, line in data.lines.items():
            lines[(*at, *within)] = line
            files[(*at, *within)] = path
        return data.content

    for place, propeller in _sections(document.content, "propeller"):
        model = propeller.get("model")
        field = DATA_FIELDS.get(model) if isinstance(model, str) else None
        if field is None or "file" not in propeller:
            continue
        name = propeller.pop("file")
        if isinstance(name, str) and field in propeller:
            raise DocumentError(document.problem((*place, field), "expected none beside 'file', found one"))
        propeller[field] = insert(name, (*place, "file"), (*place, field), DATA_FOLDER)
    for place, drive in _sections(document.content, "drive"):
        if "file" not in drive:
            continue
        name = drive.pop("file")
        if drive:
            raise DocumentError(document.problem((*place, next(iter(drive))), "expected none beside 'file', found one"))
        drive.update(insert(name, (*place, "file"), place, DRIVE_FOLDER))
    return YamlDocument(document.path, document.content, lines, files)


def _sections(content: dict[str, Any], kind: str) -> Iterator[tuple[FieldPath, dict[str, Any]]]:
    """Yield every section ``kind`` with its place: one a thruster, or that of a propeller file."""
    thrusters = content.get("thrusters")
    found: list[tuple[FieldPath, Any]] = [((kind,), content.get(kind))]
    for i, thruster in enumerate(thrusters if isinstance(thrusters, list) else []):
        if isinstance(thruster, dict):
            found.append((("thrusters", i, kind), thruster.get(kind)))
    for place, section in found:
        if isinstance(section, dict):
            yield place, section


def _data_path(name: str, document: YamlDocument, place: FieldPath, folder: Path) -> Path:
    """Return a data file: beside the file that names it, or in ``folder`` among those of this package."""
    beside = document.files.get(place, document.path).parent / name
    for path in (beside, folder / name):
        if path.is_file():
            return path
    known = ", ".join(sorted(path.name for path in folder.glob("*.yaml")))
    raise DocumentError(document.problem(place, f"expected a file beside this one or one of {known}, found '{name}'"))


class _Overlay:
    """Lays one document on another: mappings merge by key, lists of named mappings by name, the rest is replaced.

    A mapping with another ``model`` is another thing and is replaced whole.

    Keeps track of file and line of every field of the result.
    """

    def __init__(self, base: YamlDocument, over: YamlDocument) -> None:
        self._base = base
        self._over = over
        self._lines = dict(base.lines)
        self._files = {place: base.files.get(place, base.path) for place in base.lines}

    def document(self) -> YamlDocument:
        """Return the result. Raises DocumentError if a name appears twice in a list of ``over``."""
        content = self._lay(self._base.content, self._over.content, (), ())
        return YamlDocument(self._over.path, content, self._lines, self._files)

    def _lay(self, base: Any, over: Any, place: FieldPath, own: FieldPath) -> Any:
        """Return ``over`` on ``base``; ``place`` is where it goes, ``own`` where it is in its own file."""
        self._note(place, own)
        if isinstance(base, dict) and isinstance(over, dict) and over.get("model") in (None, base.get("model")):
            merged = dict(base)
            for key, value in over.items():
                merged[key] = self._lay(base.get(key), value, (*place, key), (*own, key))
            return merged
        if _named(base) and _named(over):
            return self._lay_by_name(base, over, place, own)
        self._forget_below(place)
        self._note_below(over, place, own)
        return over

    def _lay_by_name(
        self, base: list[dict[str, Any]], over: list[dict[str, Any]], place: FieldPath, own: FieldPath
    ) -> list[dict[str, Any]]:
        entries = list(base)
        index = {entry["name"]: i for i, entry in enumerate(entries)}
        seen: set[str] = set()
        for i, value in enumerate(over):
            name = value["name"]
            if name in seen:
                problem = self._over.problem((*own, i, "name"), f"every name must be unique, found '{name}' twice")
                raise DocumentError(problem)
            seen.add(name)
            at = index.get(name, len(entries))
            if at == len(entries):
                entries.append({})
            entries[at] = self._lay(entries[at], value, (*place, at), (*own, i))
        return entries

    def _note(self, place: FieldPath, own: FieldPath) -> None:
        self._lines[place] = self._over.lines[own]
        self._files[place] = self._over.path

    def _note_below(self, value: Any, place: FieldPath, own: FieldPath) -> None:
        if isinstance(value, dict):
            children = list(value.items())
        elif isinstance(value, list):
            children = list(enumerate(value))
        else:
            return
        for key, child in children:
            self._note((*place, key), (*own, key))
            self._note_below(child, (*place, key), (*own, key))

    def _forget_below(self, place: FieldPath) -> None:
        for field in [f for f in self._lines if f[: len(place)] == place and len(f) > len(place)]:
            del self._lines[field]
            del self._files[field]


def _named(value: Any) -> bool:
    return (
        isinstance(value, list)
        and bool(value)
        and all(isinstance(entry, dict) and isinstance(entry.get("name"), str) for entry in value)
    )
