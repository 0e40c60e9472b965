"""Data files of wave response by name or path."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from marine_model.errors import DocumentError, UnknownNameError
from marine_model.guards import FloatArray
from marine_model.wave_response import columns
from marine_model.wave_response.response import WaveResponse

FOLDER = Path(__file__).parent

# Headings are written with ten decimals.
_ROUNDING = 1e-9


def wave_response_names() -> tuple[str, ...]:
    """Return the names of the data files that come with this package, sorted."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.csv")))


def wave_response_path(name_or_path: str | Path, beside: Path | None = None) -> Path:
    """Return a data file.

    Parameters
    ----------
    name_or_path
        A name out of ``wave_response_names()``, or a path: anything with a folder or the suffix .csv.
    beside
        Folder that a relative path starts from; the working folder if None.

    Raises
    ------
    UnknownNameError
        If there is no such file.
    """
    path = Path(name_or_path)
    if path.suffix == ".csv" or len(path.parts) > 1:
        path = path if beside is None else beside / path
        if not path.is_file():
            raise UnknownNameError(f"wave response: no such file: {path}")
        return path
    known = FOLDER / f"{path}.csv"
    if not known.is_file():
        raise UnknownNameError(
            f"wave response: expected a path or one of {', '.join(wave_response_names())}, found '{name_or_path}'"
        )
    return known


def load_wave_response(name_or_path: str | Path) -> WaveResponse:
    """Return the response in a data file.

    A data file has comments (#), a line with the names of the columns, then a line for every heading of every
    frequency; frequencies rise, and so do the headings of each.

    Parameters
    ----------
    name_or_path
        As in ``wave_response_path``.

    Raises
    ------
    UnknownNameError
        If there is no such file.
    DocumentError
        If it cannot be read or is not such a table; the message has file and line.
    """
    path = wave_response_path(name_or_path)
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DocumentError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    first = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), len(lines))
    found = lines[first] if first < len(lines) else "nothing"
    if found != columns.HEADER:
        raise DocumentError(f"{path}:{first + 1}: header: expected '{columns.HEADER}', found '{found}'")
    return _response(path, first + 2, _table(path, first + 2, lines[first + 1 :]))


def _table(path: Path, start: int, lines: list[str]) -> FloatArray:
    """Return the numbers, shape (rows, ``columns.WIDTH``); ``start`` is the number of the first line."""
    if not lines:
        raise DocumentError(f"{path}:{start}: expected a line for every frequency and heading, found none")
    # numpy.loadtxt skips blank lines.
    if any(line.count(",") != columns.WIDTH - 1 for line in lines):
        raise DocumentError(_first_bad_line(path, start, lines))
    try:
        table = np.loadtxt(lines, delimiter=",", comments=None, ndmin=2)
    except ValueError as error:
        raise DocumentError(_first_bad_line(path, start, lines)) from error
    bad = np.flatnonzero(~np.isfinite(table).all(axis=1))
    if bad.size:
        row = int(bad[0])
        column = int(np.flatnonzero(~np.isfinite(table[row]))[0])
        name = columns.HEADER.split(",")[column]
        raise DocumentError(f"{path}:{start + row}: {name}: expected a finite number, found {table[row, column]}")
    return table


def _first_bad_line(path: Path, start: int, lines: list[str]) -> str:
    for number, line in enumerate(lines, start=start):
        cells = line.split(",")
        if len(cells) != columns.WIDTH:
            return f"{path}:{number}: expected {columns.WIDTH} numbers, found {len(cells)}"
        for name, cell in zip(columns.HEADER.split(","), cells, strict=True):
            try:
                float(cell)
            except ValueError:
                return f"{path}:{number}: {name}: expected a number, found '{cell}'"
    return f"{path}:{start}: not a table of numbers"


def _response(path: Path, start: int, table: FloatArray) -> WaveResponse:
    """Fold the table into frequency by heading; ``start`` is the line of its first row."""
    frequency = table[:, columns.FREQUENCY]
    ends = np.flatnonzero(frequency != frequency[0])
    count = int(ends[0]) if ends.size else len(frequency)
    heading = table[:count, columns.HEADING].copy()
    if (
        count < 2
        or (np.diff(heading) <= 0.0).any()
        or abs(heading[0]) > _ROUNDING
        or abs(heading[-1] - np.pi) > _ROUNDING
    ):
        raise DocumentError(
            f"{path}:{start}: heading: expected to rise from 0 to pi, found {heading[0]} to {heading[-1]}"
        )
    for row in range(0, len(table), count):
        block = table[row : row + count]
        whole = len(block) == count and (block[:, columns.FREQUENCY] == block[0, columns.FREQUENCY]).all()
        if not whole or (block[:, columns.HEADING] != heading).any():
            raise DocumentError(f"{path}:{start + row}: heading: expected the {count} headings of the first frequency")
    rows = frequency[::count]
    if len(rows) < 2 or rows[0] <= 0.0 or (np.diff(rows) <= 0.0).any():
        bad = int(np.flatnonzero(np.diff(rows, prepend=0.0) <= 0.0)[0]) if len(rows) > 1 else 0
        raise DocumentError(
            f"{path}:{start + bad * count}: frequency: expected at least two that rise from above 0, found {rows[bad]}"
        )
    heading[-1] = np.pi
    parts = table[:, columns.MOTION].reshape(len(rows), count, 6, 2)
    response = WaveResponse(
        frequency=rows.copy(),
        heading=heading,
        motion=parts[..., 0] + 1j * parts[..., 1],
        drift=table[:, columns.DRIFT].reshape(len(rows), count, 3).copy(),
    )
    for array in (response.frequency, response.heading, response.motion, response.drift):
        array.setflags(write=False)
    return response
