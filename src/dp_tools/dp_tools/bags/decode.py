"""Messages of one topic as columns: one number or text a message and field."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import TypesysError
from rosbags.typesys.store import Typestore

from dp_tools.bags.bag import Bag, BagTopic
from dp_tools.bags.definitions import definitions_in
from dp_tools.bags.errors import BagError
from dp_tools.cdr.bulk import batches
from dp_tools.cdr.layout import LayoutError, layout_found
from dp_tools.cdr.types import types_of

# Messages decoded at a time.
BLOCK = 20_000
# More columns than this are no table: arrays of messages of some length.
_MOST_COLUMNS = 2000
_TIMES = frozenset(("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"))
_INDEX = re.compile(r"\[(\d+)\]")
_NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class Cells:
    """One column of a block.

    Attributes
    ----------
    values
        One a message; of no meaning where there is none. Texts have dtype object.
    there
        Which messages have the field: elements of arrays of different length may be missing.
    """

    values: NDArray[Any]
    there: NDArray[np.bool_]


class TopicDecoder:
    """Decodes messages of a topic by the definition in the bag.

    Numbers and texts are found by path, ``pose.pose.position.x``; elements of arrays are ``thrust[0]``; a time is one
    whole number of ns.

    Parameters
    ----------
    topic
        Its name, type and definition.

    Raises
    ------
    BagError
        If the definition cannot be understood.
    """

    def __init__(self, topic: BagTopic) -> None:
        self.topic = topic
        if topic.encoding != "cdr" or topic.definition_encoding != "ros2msg":
            raise BagError(
                f"{topic.name}: expected messages in cdr defined in ros2msg, "
                f"found {topic.encoding} and {topic.definition_encoding}"
            )
        try:
            self.types: Typestore = types_of({topic.kind: topic.definition})
            self._paths = dict(_times(self.types, topic.kind, ""))
        except (TypesysError, KeyError, ValueError, RecursionError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise BagError(f"{topic.name}: the definition of {topic.kind} cannot be understood: {reason}") from error
        self._definitions = definitions_in(topic.kind, topic.definition)

    def block(self, data: Sequence[bytes]) -> dict[str, Cells]:
        """Return the columns of some messages, by path.

        Raises
        ------
        BagError
            If a message is not of its type.
        """
        try:
            return self._in_bulk(data)
        except (LayoutError, UnicodeDecodeError, KeyError, struct.error):
            return self._one_by_one(data)

    def message(self, data: bytes) -> Any:
        """Return one message as an object with the fields of its definition. Raises BagError."""
        try:
            form: Any = self.types.get_msgdef(self.topic.kind)
            read = form.deserialize_cdr_le if data[1] else form.deserialize_cdr_be
            # Not types.deserialize_cdr: serializers may fill up the end of a message, which it does not allow.
            return read(data[4:], 0, form.cls, self.types)[0]
        except (SerdeError, AssertionError, struct.error, ValueError, IndexError, TypeError, MemoryError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise BagError(
                f"{self.topic.name}: message is not of type {self.topic.kind}: {reason}, found {data[:32].hex()}"
            ) from error

    def _in_bulk(self, data: Sequence[bytes]) -> dict[str, Cells]:
        columns = _Columns(len(data))
        for batch in batches(self.types, self.topic.kind, data, ()):
            for path in batch.rows.dtype.names or ():
                values = batch.rows[path]
                if values.ndim == 1:
                    columns.add(path, batch.index, values)
                else:
                    for k in range(values.shape[1]):
                        columns.add(f"{path}[{k}]", batch.index, values[:, k])
            index = batch.index.tolist()
            layout = layout_found(self.types, self.topic.kind, data[index[0]])
            for path, text in layout.texts.items():
                keys = [path] if isinstance(text, str) else [f"{path}#{k}" for k in range(len(text))]
                for key in keys:
                    begin, end = layout.spans[key][1]
                    words = np.array([data[i][begin:end].decode() for i in index], dtype=object)
                    columns.add(f"{path}[{key.rpartition('#')[2]}]" if "#" in key else path, batch.index, words)
        return columns.finished(self._paths)

    def _one_by_one(self, data: Sequence[bytes]) -> dict[str, Cells]:
        columns = _Columns(len(data))
        for number, message in enumerate(data):
            decoded = self.message(message)
            index = np.array([number])
            for path, value in _flat(decoded, self.types, self.topic.kind, ""):
                columns.add(path, index, np.array([value], dtype=object if isinstance(value, str) else None))
                if len(columns.found) > _MOST_COLUMNS:
                    raise BagError(f"{self.topic.name}: expected at most {_MOST_COLUMNS} columns, found more")
        return columns.finished(self._paths)

    # What is known of a column ----------------------------------------------------------------------------------------

    def place(self, path: str) -> tuple[int, ...]:
        """Return a key that sorts columns as the fields are defined."""
        key: list[int] = []
        kind = self.topic.kind
        for part in path.split("."):
            name, _, index = part.partition("[")
            fields = self.types.fielddefs[kind][1] if kind in self.types.fielddefs else []
            names = [one[0] for one in fields]
            key += [names.index(name) if name in names else -1, int(index.rstrip("]")) if index else -1]
            kind = _inner(dict(fields).get(name))
        return tuple(key)

    def unit(self, path: str) -> str:
        """Return the unit that the definition tells; empty for none."""
        if base_path(path) in self._paths:
            return "ns"
        owner, name, index = self._owner(path)
        units = self._definitions[owner].units(name) if owner in self._definitions else ()
        if len(units) > 1:
            return units[index] if index is not None and index < len(units) else ""
        return units[0] if units else ""

    def may_be_none(self, path: str) -> bool:
        """Return whether the definition allows a number to be NaN or infinite."""
        owner, name, _ = self._owner(path)
        return owner in self._definitions and self._definitions[owner].may_be_none(name)

    def _owner(self, path: str) -> tuple[str, str, int | None]:
        """Return the type in which the last field of a path is defined, its name, and its index."""
        parts = path.split(".")
        kind = self.topic.kind
        for part in parts[:-1]:
            fields = self.types.fielddefs[kind][1] if kind in self.types.fielddefs else []
            kind = _inner(dict(fields).get(part.partition("[")[0]))
        found = _INDEX.search(parts[-1])
        return kind, parts[-1].partition("[")[0], int(found[1]) if found else None


def base_path(path: str) -> str:
    """Return a path without the places in arrays."""
    return _INDEX.sub("", path)


def blocks(bag: Bag, number: int) -> Iterator[tuple[NDArray[np.int64], list[bytes]]]:
    """Yield rows and messages of topic ``number`` of a bag, some thousands at a time."""
    rows = np.flatnonzero(bag.messages.topic == number)
    for start in range(0, len(rows), BLOCK):
        part = rows[start : start + BLOCK]
        yield part, [bag.data(row) for row in part.tolist()]


class _Columns:
    """Columns that are being filled."""

    def __init__(self, count: int) -> None:
        self._count = count
        self.found: dict[str, tuple[NDArray[Any], NDArray[np.bool_]]] = {}

    def add(self, path: str, index: NDArray[np.intp], values: NDArray[Any]) -> None:
        if path not in self.found:
            filled = np.zeros(self._count, dtype=values.dtype)
            self.found[path] = filled, np.zeros(self._count, dtype=np.bool_)
        column, there = self.found[path]
        column[index] = values
        there[index] = True

    def finished(self, times: Mapping[str, Callable[[Any, Any], Any]]) -> dict[str, Cells]:
        """Return all columns; the two parts of a time as one."""
        cells: dict[str, Cells] = {}
        for path, (values, there) in self.found.items():
            owner, _, part = path.rpartition(".")
            if base_path(owner) in times and part in ("sec", "nanosec"):
                if part == "sec":
                    nanosec = self.found[f"{owner}.nanosec"][0].astype(np.int64)
                    cells[owner] = Cells(values.astype(np.int64) * _NANOSECONDS + nanosec, there)
                continue
            cells[path] = Cells(values, there)
        return cells


def _inner(form: Any) -> str:
    """Return the message type of a field or of its elements; empty for a number or a text."""
    if form is None:
        return ""
    node, detail = form
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        node, detail = detail[0]
    return str(detail) if node is Nodetype.NAME else ""


def _times(types: Typestore, kind: str, prefix: str, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield the paths, without places in arrays, at which there is a time."""
    if depth > 30:
        raise ValueError(f"{kind}: contains itself")
    for name, form in types.fielddefs[kind][1]:
        inner = _inner(form)
        if inner and inner not in types.fielddefs:
            raise ValueError(f"{inner} is not defined")
        if inner in _TIMES:
            parts = [part for part, _ in types.fielddefs[inner][1]]
            if parts != ["sec", "nanosec"]:
                raise ValueError(f"{inner}: expected sec, nanosec, found {', '.join(parts)}")
            yield f"{prefix}{name}", None
        elif inner:
            yield from _times(types, inner, f"{prefix}{name}.", depth + 1)


def _flat(message: Any, types: Typestore, kind: str, prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield path and value of every number and text in a decoded message."""
    for name, (node, detail) in types.fielddefs[kind][1]:
        value, path = getattr(message, name), f"{prefix}{name}"
        if node is Nodetype.NAME:
            yield from _flat(value, types, str(detail), f"{path}.")
        elif node is Nodetype.BASE:
            yield path, value
        else:
            element: Any = detail[0]
            for k, one in enumerate(value):
                if element[0] is Nodetype.NAME:
                    yield from _flat(one, types, str(element[1]), f"{path}[{k}].")
                else:
                    yield f"{path}[{k}]", one
