"""Three-element vectors as plain tuples: for so few elements, several times faster than arrays."""

from __future__ import annotations

import math

Triple = tuple[float, float, float]
Mask = tuple[bool, bool, bool]

ZERO: Triple = (0.0, 0.0, 0.0)


def to_body(heading: float, vector: Triple) -> Triple:
    """Return R(heading)^T vector: NED to body; the third element is unchanged."""
    c, s = math.cos(heading), math.sin(heading)
    x, y, z = vector
    return c * x + s * y, c * y - s * x, z


def to_ned(heading: float, vector: Triple) -> Triple:
    """Return R(heading) vector: body to NED; the third element is unchanged."""
    c, s = math.cos(heading), math.sin(heading)
    x, y, z = vector
    return c * x - s * y, s * x + c * y, z


def masked(vector: Triple, mask: tuple[bool, bool, bool]) -> Triple:
    """Return ``vector`` with zeros where ``mask`` is false."""
    return (
        vector[0] if mask[0] else 0.0,
        vector[1] if mask[1] else 0.0,
        vector[2] if mask[2] else 0.0,
    )


def product(a: Triple, b: Triple) -> Triple:
    """Return the products of the elements."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


def limited(demand: Triple, limits: Triple) -> Triple:
    """Return ``demand`` with every element within its limit either way; a limit of 0 is none."""
    x, y, n = (
        math.copysign(limit, value) if 0.0 < limit < abs(value) else value
        for value, limit in zip(demand, limits, strict=True)
    )
    return x, y, n


def both(a: Mask, b: Mask) -> Mask:
    """Return what is in both masks."""
    return a[0] and b[0], a[1] and b[1], a[2] and b[2]
