"""Many messages of one topic at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys.store import Typestore

from dp_tools.cdr.layout import Layout, layout_found


@dataclass(frozen=True)
class Batch:
    """Messages with the same texts, lengths and layout.

    Attributes
    ----------
    index
        Which of the messages they are, shape (k,), increasing.
    rows
        Their numbers, shape (k,), fields by path.
    texts
        Texts by path, as in :class:`Layout`.
    """

    index: NDArray[np.intp]
    rows: NDArray[Any]
    texts: Mapping[str, str | tuple[str, ...]]


def serialized(layout: Layout, count: int, numbers: Mapping[str, Any]) -> list[bytes]:
    """Return ``count`` messages.

    Parameters
    ----------
    layout
        Of all of them.
    count
        How many.
    numbers
        By path: one value for all, or one a message. What is missing is zero.
    """
    size = layout.size
    matrix = np.empty((count, size), dtype=np.uint8)
    matrix[:] = np.frombuffer(layout.template, dtype=np.uint8)
    rows = matrix.view(layout.form)[:, 0]
    for path, values in numbers.items():
        rows[path] = values
    data = matrix.tobytes()
    return [data[start : start + size] for start in range(0, count * size, size)]


def batches(types: Typestore, kind: str, messages: Sequence[bytes], texts: Sequence[str]) -> Iterator[Batch]:
    """Sort messages of type ``kind`` into batches; those of one batch agree in the texts at the paths ``texts``.

    Raises
    ------
    LayoutError
        If a message is not of that type, or cannot be laid out.
    """
    sizes = np.fromiter(map(len, messages), dtype=np.intp, count=len(messages))
    for size in np.unique(sizes):
        rest = np.flatnonzero(sizes == size)
        matrix = np.frombuffer(b"".join([messages[i] for i in rest.tolist()]), dtype=np.uint8).reshape(-1, size)
        while len(rest):
            layout = layout_found(types, kind, matrix[0].tobytes())
            places = layout.shared_bytes(texts)
            same = (matrix[:, places] == matrix[0, places]).all(axis=1)
            # Serializers may fill up the end of a message.
            rows = np.ascontiguousarray(matrix[same, : layout.size]).view(layout.form)[:, 0]
            yield Batch(rest[same], rows, layout.texts)
            rest, matrix = rest[~same], matrix[~same]
