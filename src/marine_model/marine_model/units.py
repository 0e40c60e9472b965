"""Units of fields, written once, where a field is declared, and what they are made of.

A unit is a text: "N s/m", "kg m^2", "N/(m s)". Commas part the elements of a vector that have units of their own,
semicolons the rows of such a matrix: "N, N, N m".
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from marine_model.errors import InputError


@dataclass(frozen=True)
class Unit:
    """Unit of a field, as metadata of its type: ``Annotated[float, Unit("N s/m")]``.

    "1" is that of a plain number. An empty text says that the unit is not the field's own to tell: who scales the
    section knows it.
    """

    text: str


class Dimension(NamedTuple):
    """Powers of mass, length and time in a unit."""

    mass: int
    length: int
    time: int


_PLAIN = Dimension(0, 0, 0)
# Angles, shares, counts and what they are called in the texts that an operator reads.
_PLAIN_NAMES = ("1", "rad", "deg", "step", "steps", "samples", "decades", "hull", "lengths", "%", "dB")
_BASE = {
    **dict.fromkeys(_PLAIN_NAMES, _PLAIN),
    "kg": Dimension(1, 0, 0),
    "m": Dimension(0, 1, 0),
    "s": Dimension(0, 0, 1),
    "Hz": Dimension(0, 0, -1),
    "N": Dimension(1, 1, -2),
    "J": Dimension(1, 2, -2),
    "W": Dimension(1, 2, -3),
}
_SIGNS = str.maketrans({"²": "^2", "³": "^3"})
_POWER = re.compile(r"\(([^()]*)\)\^(\d+)")
_FACTOR = re.compile(r"([A-Za-z%]+|1)(?:\^(-?\d+))?")


@cache
def dimension(unit: str) -> Dimension:
    """Return the powers of mass, length and time in one unit, such as "N s/m", "N/(m s)" or "(N m)^2".

    Raises
    ------
    InputError
        If a part of it is not known.
    """
    text = unit.strip().translate(_SIGNS)
    whole = _POWER.fullmatch(text)
    if whole is not None:
        return Dimension(*(int(whole[2]) * power for power in dimension(whole[1])))
    above, _, below = text.partition("/")
    powers = [0, 0, 0]
    for sign, product in ((1, above), (-1, below.strip().removeprefix("(").removesuffix(")"))):
        for part in product.split():
            found = _FACTOR.fullmatch(part)
            if found is None or found[1] not in _BASE:
                raise InputError(f"unit: expected products of {', '.join(_BASE)}, found '{unit}'")
            for i, power in enumerate(_BASE[found[1]]):
                powers[i] += sign * power * int(found[2] or 1)
    return Dimension(*powers)


def unit_of(field: FieldInfo) -> str | None:
    """Return the unit of a field of a section or of settings; None where it has none.

    That given with :func:`marine_model.settings.setting` goes before that of its type.
    """
    extra = field.json_schema_extra
    if isinstance(extra, dict) and extra.get("unit"):
        return str(extra["unit"])
    return _unit(field.annotation, field.metadata)


def _unit(annotation: Any, metadata: Any = ()) -> str | None:
    for item in reversed(metadata):  # the outermost comes last
        if isinstance(item, Unit):
            return item.text
    if get_origin(annotation) is Annotated:
        inner, *own = get_args(annotation)
        return _unit(inner, own)
    return next((unit for arg in get_args(annotation) if (unit := _unit(arg)) is not None), None)


def numbers_without_unit(model: type[BaseModel], prefix: str = "") -> Iterator[str]:
    """Yield every field with floating-point numbers in it, at any depth, that has no unit; dots lead down."""
    for name, field in model.model_fields.items():
        if unit_of(field) is None and _has_floats(field.annotation):
            yield f"{prefix}{name}"
        for section in _sections(field.annotation):
            yield from numbers_without_unit(section, f"{prefix}{name}.")


def parameter_units(model: type[BaseModel], prefix: str = "") -> Mapping[str, str]:
    """Return the unit of every parameter of a class of settings that has one, by name with dots for groups."""
    units: dict[str, str] = {}
    for name, field in model.model_fields.items():
        groups = list(_sections(field.annotation))
        for group in groups:
            units |= parameter_units(group, f"{prefix}{name}.")
        unit = unit_of(field)
        if unit is not None and not groups:
            units[f"{prefix}{name}"] = unit
    return units


def _has_floats(annotation: Any) -> bool:
    return annotation is float or any(_has_floats(arg) for arg in get_args(annotation))


def _sections(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the sections that a value of this type may hold."""
    if isinstance(annotation, type) and get_origin(annotation) is None:
        if issubclass(annotation, BaseModel):
            yield annotation
        return
    if get_origin(annotation) in (Annotated, tuple, list, dict, Union, UnionType):
        for arg in get_args(annotation):
            yield from _sections(arg)
