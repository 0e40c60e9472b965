"""Messages of a topic as a table: CSV or Parquet."""

from __future__ import annotations

import csv
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dp_tools.bags.bag import Bag
from dp_tools.bags.decode import Cells, TopicDecoder, blocks
from dp_tools.bags.errors import BagError

_TIMES = ("log_time", "publish_time")
_NO_PYARROW = "Parquet needs the package pyarrow, which is not installed here: pip install pyarrow"


class TopicTable:
    """Columns of a topic, and its messages block by block.

    Parameters
    ----------
    bag
        Open.
    number
        Of the topic.

    Raises
    ------
    BagError
        If a message cannot be decoded.
    """

    def __init__(self, bag: Bag, number: int) -> None:
        self._bag = bag
        self._number = number
        self._decoder = TopicDecoder(bag.topics[number])
        found: dict[str, np.dtype[Any]] = {}
        for _, data in blocks(bag, number):
            for path, cells in self._decoder.block(data).items():
                found[path] = np.promote_types(found.get(path, cells.values.dtype), cells.values.dtype)
        self.columns: Mapping[str, np.dtype[Any]] = {
            path: found[path] for path in sorted(found, key=self._decoder.place)
        }
        """Type of the values by path, in the order of the definition; object for texts."""

    def unit(self, path: str) -> str:
        """Return the unit of a column; empty for none."""
        return "ns" if path in _TIMES else self._decoder.unit(path)

    def blocks(self) -> Iterator[tuple[NDArray[np.int64], dict[str, Cells]]]:
        """Yield rows of the bag and their cells, times first, then all columns."""
        messages = self._bag.messages
        for rows, data in blocks(self._bag, self._number):
            there = np.ones(len(rows), dtype=np.bool_)
            cells = {
                "log_time": Cells(messages.log_time[rows], there),
                "publish_time": Cells(messages.publish_time[rows], there),
            }
            found = self._decoder.block(data)
            for path, form in self.columns.items():
                cells[path] = found.get(path) or Cells(np.zeros(len(rows), dtype=form), ~there)
            yield rows, cells


def write_tables(
    bag: Bag,
    names: Collection[str],
    folder: Path,
    parquet: bool = False,
    overwrite: bool = False,
    progress: Callable[[int], None] = lambda done: None,
) -> list[tuple[str, Path, int, int]]:
    """Write one file a topic that has messages; return topic, file, rows and columns of each.

    Parameters
    ----------
    bag
        Open.
    names
        Topics to write.
    folder
        For the files; made if it is not there.
    parquet
        True for Parquet, False for CSV.
    overwrite
        True to replace files that are there.
    progress
        Called with the number of messages written.

    Raises
    ------
    BagError
        If a message cannot be decoded, a file is there or cannot be written, or pyarrow is not installed.
    """
    write = _parquet_writer() if parquet else _write_csv
    suffix = ".parquet" if parquet else ".csv"
    numbers = [n for n, topic in enumerate(bag.topics) if topic.name in names and (bag.messages.topic == n).any()]
    paths: dict[int, Path] = {}
    for number in numbers:
        base = bag.topics[number].name.strip("/").replace("/", ".")
        path = folder / f"{base}{suffix}"
        if path in paths.values():  # the same topic with another type
            path = folder / f"{base}.{number}{suffix}"
        if path.exists() and not overwrite:
            raise BagError(f"{path}: is there already; --overwrite replaces it")
        paths[number] = path
    done = 0
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for number, path in paths.items():
            table = TopicTable(bag, number)

            def show(count: int, start: int = done) -> None:
                progress(start + count)

            temporary = path.with_name(path.name + ".part")
            try:
                rows = write(table, bag.topics[number].kind, temporary, show)
                temporary.replace(path)
            finally:
                temporary.unlink(missing_ok=True)
            done += rows
            written.append((bag.topics[number].name, path, rows, len(table.columns) + len(_TIMES)))
    except OSError as error:
        raise BagError(f"{folder}: cannot be written: {error.strerror or error}") from error
    return written


Writer = Callable[[TopicTable, str, Path, Callable[[int], None]], int]


def _write_csv(table: TopicTable, kind: str, path: Path, progress: Callable[[int], None]) -> int:
    count = 0
    with path.open("w", encoding="utf-8", newline="") as stream:
        # Line ends as in RFC 4180; with another, a carriage return in a text would not be quoted.
        writer = csv.writer(stream, lineterminator="\r\n")
        head = [*_TIMES, *table.columns]
        writer.writerow([f"{path} [{unit}]" if (unit := table.unit(path)) else path for path in head])
        for rows, cells in table.blocks():
            writer.writerows(zip(*(_words(cells[path]) for path in head), strict=True))
            count += len(rows)
            progress(count)
    return count


def _words(cells: Cells) -> list[Any]:
    """Return the cells of a column as they are written: numbers with all their digits, nothing where there is none."""
    values = cells.values
    if values.dtype.kind == "b":
        words: list[Any] = ["true" if value else "false" for value in values.tolist()]
    elif values.dtype == np.float32:
        words = [str(value) for value in values]  # as few digits as single precision needs
    else:
        words = values.tolist()
    if not cells.there.all():
        words = [word if there else "" for word, there in zip(words, cells.there.tolist(), strict=True)]
    return words


def _parquet_writer() -> Writer:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise BagError(_NO_PYARROW) from error

    def form_of(path: str, form: np.dtype[Any]) -> Any:
        if path in _TIMES:
            return pyarrow.timestamp("ns", tz="UTC")
        return pyarrow.string() if form.kind == "O" else pyarrow.from_numpy_dtype(form)

    def write(table: TopicTable, kind: str, path: Path, progress: Callable[[int], None]) -> int:
        whole = np.dtype(np.int64)
        fields = [
            pyarrow.field(name, form_of(name, form), metadata={"unit": unit} if (unit := table.unit(name)) else None)
            for name, form in {**dict.fromkeys(_TIMES, whole), **table.columns}.items()
        ]
        schema = pyarrow.schema(fields, metadata={"type": kind})
        count = 0
        try:
            with pyarrow.parquet.ParquetWriter(path, schema, compression="zstd") as writer:
                for rows, cells in table.blocks():
                    arrays = [
                        pyarrow.array(cells[field.name].values, type=field.type, mask=~cells[field.name].there)
                        for field in fields
                    ]
                    writer.write_table(pyarrow.table(arrays, schema=schema))
                    count += len(rows)
                    progress(count)
        except pyarrow.ArrowException as error:
            raise BagError(f"{path}: cannot be written: {error}") from error
        return count

    return write
