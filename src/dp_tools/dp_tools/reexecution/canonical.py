"""Messages as bytes that are the same exactly if every field is the same to the bit.

Serialized messages will not do: between two fields and at the end they have padding, whose bytes may be anything.
"""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable, Hashable
from functools import cache
from typing import Any, cast

import numpy as np

Add = Callable[[bytes], None]
_DOUBLE = struct.Struct("<d").pack
_LENGTH = struct.Struct("<I").pack
_INTEGER = struct.Struct("<q").pack


def canonical(message: Any) -> bytes:
    """Return what stands for a message; NaN is equal to the same NaN, and zeros of two signs differ."""
    parts: list[bytes] = []
    _add_message(message, parts.append)
    return b"".join(parts)


@cache
def _writers(kind: Any) -> tuple[tuple[str, Callable[[Any, Add], None]], ...]:
    """Return for every field of a message class how its value becomes bytes."""
    fields = kind.get_fields_and_field_types()
    return tuple((name, _writer(text)) for name, text in fields.items())


def _writer(kind: str) -> Callable[[Any, Add], None]:
    if "[" in kind or kind.startswith("sequence<"):
        return _add_sequence
    if kind in ("double", "float"):
        return _add_double
    if kind.startswith(("string", "wstring")):
        return _add_text
    if "/" in kind:
        return _add_message
    if kind == "octet":
        return _add_octet
    return _add_integer


def _add_message(message: Any, add: Add) -> None:
    for name, write in _writers(cast(Hashable, type(message))):
        write(getattr(message, name), add)


def _add_double(value: Any, add: Add) -> None:
    add(_DOUBLE(value))


def _add_integer(value: Any, add: Add) -> None:
    add(_INTEGER(value) if value < 1 << 63 else _LENGTH(0) + int(value).to_bytes(8, "little"))


def _add_octet(value: Any, add: Add) -> None:
    add(bytes(value))


def _add_text(value: Any, add: Add) -> None:
    data = value.encode()
    add(_LENGTH(len(data)))
    add(data)


def _add_sequence(value: Any, add: Add) -> None:
    add(_LENGTH(len(value)))
    if isinstance(value, array | np.ndarray):
        add(value.tobytes())
        return
    for element in value:
        if isinstance(element, float):
            add(_DOUBLE(element))
        elif isinstance(element, str):
            _add_text(element, add)
        elif isinstance(element, bytes):
            add(element)
        elif isinstance(element, int):
            add(_INTEGER(element))
        else:
            _add_message(element, add)
