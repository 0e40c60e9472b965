"""Stamps of serialized messages, without deserializing them."""

from __future__ import annotations

import struct

_NANOSECONDS = 1_000_000_000
_LITTLE_ENDIAN = 1


def stamp_of(data: bytes) -> int:
    """Return the time (ns) with which a message begins: that of its header, or of a clock."""
    sec, nanosec = struct.unpack_from("<iI" if data[1] == _LITTLE_ENDIAN else ">iI", data, 4)
    return int(sec) * _NANOSECONDS + int(nanosec)
