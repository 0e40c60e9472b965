"""Settings of a core: declared once, used in process and as ROS parameters alike."""

from __future__ import annotations

from typing import Any

from pydantic import Field

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
        SI unit, shown with the description.
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
