"""Where the fields of a serialized message are, once the lengths of its texts and sequences are known.

ROS 2 serializes by XCDR1, little endian: a head of four bytes, then the fields in order, each aligned to its own size
from the end of the head; texts and sequences begin with their length as uint32. Of an empty sequence there is nothing
but the length. So all messages of a topic whose texts and sequences have the same lengths have one layout, and
thousands of them are written or read as one array.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

from marine_model.errors import DpError

HEAD = b"\x00\x01\x00\x00"  # plain CDR, little endian
_LITTLE_ENDIAN = 1
_NUMBERS = {
    "bool": "?",
    "byte": "u1",
    "char": "u1",
    "float32": "<f4",
    "float64": "<f8",
    **{f"{sign}int{bits}": f"<{sign or 'i'}{bits // 8}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
}


class LayoutError(DpError):
    """A message cannot be laid out: its bytes are not those of its type, or its type is beyond what is done here."""


class Lengths(Protocol):
    """Says how long texts and sequences are."""

    def text(self, path: str, at: int) -> bytes:
        """Return the text of field ``path``, whose length is at byte ``at``."""

    def count(self, path: str, at: int) -> int:
        """Return the number of elements of sequence ``path``, whose length is at byte ``at``."""


@dataclass(frozen=True)
class Layout:
    """Layout of a message with given lengths.

    Attributes
    ----------
    form
        Numbers by path (``pose.pose.position.x``, arrays and sequences as sub-arrays), at their places in the message.
    template
        The message with every number zero.
    texts
        Text by path, a tuple of them for a sequence of texts.
    spans
        Byte ranges of lengths and texts, by path: what a message must share to have the same lengths or texts.
    """

    form: np.dtype[Any]
    template: bytes
    texts: Mapping[str, str | tuple[str, ...]]
    spans: Mapping[str, tuple[tuple[int, int], tuple[int, int]]]

    @property
    def size(self) -> int:
        """Bytes of a message."""
        return len(self.template)

    def shared_bytes(self, texts: Sequence[str]) -> NDArray[np.intp]:
        """Return the places of the head, of all lengths, and of the texts at the paths ``texts``."""
        places = [np.arange(len(HEAD))]
        for path, (length, text) in self.spans.items():
            places.append(np.arange(*length))
            if path.partition("#")[0] in texts:
                places.append(np.arange(*text))
        return np.concatenate(places)


class _Builder:
    """Walks over the fields of a type."""

    def __init__(self, types: Typestore, lengths: Lengths) -> None:
        self._types = types
        self._lengths = lengths
        self._template = bytearray(HEAD)
        self._names: list[str] = []
        self._formats: list[Any] = []
        self._offsets: list[int] = []
        self._texts: dict[str, str | tuple[str, ...]] = {}
        self._spans: dict[str, tuple[tuple[int, int], tuple[int, int]]] = {}

    def layout(self, kind: str) -> Layout:
        self._message(kind, "")
        size = len(self._template)
        form = np.dtype({"names": self._names, "formats": self._formats, "offsets": self._offsets, "itemsize": size})
        return Layout(form, bytes(self._template), self._texts, self._spans)

    def _align(self, size: int) -> int:
        """Fill up to a multiple of ``size`` and return where that is."""
        missing = -(len(self._template) - len(HEAD)) % size
        self._template += b"\0" * missing
        return len(self._template)

    def _message(self, kind: str, prefix: str) -> None:
        detail: Any  # what it is depends on the node
        for name, (node, detail) in self._types.fielddefs[kind][1]:
            path = prefix + name
            if node is Nodetype.NAME:
                self._message(detail, f"{path}.")
            elif node is Nodetype.BASE:
                self._base(path, detail[0], None)
            elif node is Nodetype.ARRAY:
                self._elements(path, detail[0], detail[1])
            else:
                at = self._align(4)
                count = self._lengths.count(path, at)
                self._template += count.to_bytes(4, "little")
                self._spans[path] = ((at, at + 4), (at, at))
                self._elements(path, detail[0], count)

    def _elements(self, path: str, element: Any, count: int) -> None:
        node, detail = element
        if node is not Nodetype.BASE:
            if count:
                raise LayoutError(f"{path}: expected an array of numbers or texts, found one of {detail}")
        elif detail[0] == "string":
            self._texts[path] = tuple(self._text(f"{path}#{i}") for i in range(count))
        else:
            self._base(path, detail[0], count)

    def _base(self, path: str, kind: str, count: int | None) -> None:
        if kind == "string":
            self._texts[path] = self._text(path)
            return
        if kind not in _NUMBERS:
            raise LayoutError(f"{path}: expected a number or a text, found {kind}")
        number = np.dtype(_NUMBERS[kind])
        self._names.append(path)
        self._formats.append(number if count is None else (number, (count,)))
        elements = 1 if count is None else count
        self._offsets.append(self._align(number.itemsize) if elements else len(self._template))
        self._template += b"\0" * (number.itemsize * elements)

    def _text(self, path: str) -> str:
        at = self._align(4)
        text = self._lengths.text(path, at)
        self._template += (len(text) + 1).to_bytes(4, "little") + text + b"\0"
        self._spans[path] = ((at, at + 4), (at + 4, at + 4 + len(text)))
        return text.decode()


@dataclass(frozen=True)
class _Given:
    texts: Mapping[str, str | Sequence[str]]
    counts: Mapping[str, int]

    def text(self, path: str, at: int) -> bytes:
        path, _, index = path.partition("#")
        text = self.texts.get(path, "")
        return (text if isinstance(text, str) else text[int(index)]).encode()

    def count(self, path: str, at: int) -> int:
        texts = self.texts.get(path)
        return self.counts.get(path, 0) if texts is None else len(texts)


@dataclass(frozen=True)
class _Found:
    data: bytes

    def text(self, path: str, at: int) -> bytes:
        length = self.count(path, at)
        if length == 0:  # some writers leave the final zero out as well
            raise LayoutError(f"{path}: expected a text with its final zero, found none")
        return self.data[at + 4 : at + 3 + length]

    def count(self, path: str, at: int) -> int:
        count = int.from_bytes(self.data[at : at + 4], "little")
        if at + 4 + count > len(self.data):
            raise LayoutError(f"{path}: expected a length within the message, found {count}")
        return count


def layout_of(
    types: Typestore, kind: str, texts: Mapping[str, str | Sequence[str]], counts: Mapping[str, int]
) -> Layout:
    """Return the layout of messages of type ``kind``.

    Parameters
    ----------
    types
        Knows the type.
    kind
        E.g. ``nav_msgs/msg/Odometry``.
    texts
        Text by path, several for a sequence of texts; empty where there is none.
    counts
        Elements of sequences of numbers by path; none where it is missing.

    Raises
    ------
    LayoutError
        If the type has sequences of messages.
    """
    return _Builder(types, _Given(texts, counts)).layout(kind)


def layout_found(types: Typestore, kind: str, data: bytes) -> Layout:
    """Return the layout of one serialized message of type ``kind``. Raises LayoutError."""
    if len(data) < len(HEAD) or data[1] != _LITTLE_ENDIAN:
        raise LayoutError(f"{kind}: expected plain CDR, little endian, found the head {data[:4].hex()}")
    layout = _Builder(types, _Found(data)).layout(kind)
    if layout.size > len(data):
        raise LayoutError(f"{kind}: expected {layout.size} bytes, found {len(data)}")
    return layout
