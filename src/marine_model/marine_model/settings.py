"""Settings of a core: declared once, used in process and as ROS parameters alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from pydantic import Field, ValidationError

from marine_model.errors import InputError
from marine_model.schema import Section


class Settings(Section):
    """Operator-facing options of one core; frozen, validated whole.

    Every field is made with :func:`setting`. A field that is itself a ``Settings`` groups parameters: its fields
    appear to ROS as ``group.field``.
    """


def setting(
    default: Any,
    description: str,
    *,
    unit: str = "",
    ge: float | None = None,
    le: float | None = None,
    read_only: bool = False,
) -> Any:
    """Return a field of a :class:`Settings` class.

    Parameters
    ----------
    default
        Value when nothing else is said.
    description
        One sentence for the operator.
    unit
        SI unit, shown with the description; "1" for a plain number. Every floating-point number needs one, because
        Froude's law scales by it. Where the elements of a vector differ, one for each: "N, N, N m".
    ge, le
        Closed range; refused outside.
    read_only
        True for what cannot change while the node runs.
    """
    return Field(
        default=default,
        description=description,
        ge=ge,
        le=le,
        json_schema_extra={"unit": unit, "read_only": read_only},
    )


S = TypeVar("S", bound=Settings)


def parameters_of(settings: Settings) -> dict[str, Any]:
    """Return every parameter by its name, groups with dots: ``{"waves.amplitude": 0.06, ...}``."""
    return dict(_flat(settings.model_dump()))


def read_only_parameters(model: type[Settings], prefix: str = "") -> frozenset[str]:
    """Return the names of the parameters that cannot change while the node runs."""
    names: set[str] = set()
    for name, field in model.model_fields.items():
        group = field.annotation
        if isinstance(group, type) and issubclass(group, Settings):
            names |= read_only_parameters(group, f"{prefix}{name}.")
        elif isinstance(field.json_schema_extra, dict) and field.json_schema_extra.get("read_only"):
            names.add(f"{prefix}{name}")
    return frozenset(names)


def with_parameters(settings: S, changes: Mapping[str, Any]) -> S:
    """Return ``settings`` with some parameters changed, validated whole.

    Parameters
    ----------
    settings
        Where to start; not changed.
    changes
        Value by name, groups with dots.

    Raises
    ------
    InputError
        If a name is unknown or a value is refused; the message names each and says what was expected and found.
    """
    values = parameters_of(settings)
    unknown = sorted(set(changes) - set(values))
    if unknown:
        raise InputError(f"parameter: expected one of {', '.join(values)}, found '{unknown[0]}'")
    try:
        return type(settings).model_validate(_nested(values | dict(changes)))
    except ValidationError as error:
        raise InputError(explain(error)) from error


def explain(error: ValidationError) -> str:
    """Return a pydantic error as one line: every field with what is wrong and what was found."""
    parts = []
    for item in error.errors():
        field = ".".join(str(part) for part in item["loc"])
        text = item["msg"].removeprefix("Value error, ")
        found = "" if item["type"] == "value_error" else f", found {item['input']!r}"
        parts.append(f"{field}: {text}{found}" if field else f"{text}{found}")
    return "; ".join(parts)


def _flat(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _nested(flat: Mapping[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for name, value in flat.items():
        *groups, leaf = name.split(".")
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
        # Sequences reach a node as lists or array.array; the models keep tuples.
        scalar = value is None or isinstance(value, str | bytes | bool | int | float)
        branch[leaf] = value if scalar else tuple(value)
    return tree
