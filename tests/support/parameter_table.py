"""The table of parameters of a documentation page, written from the settings class.

python tests/support/parameter_table.py    # writes it anew
"""

from __future__ import annotations

import sys
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo

from marine_model import load_vessel
from marine_model.settings import Settings, parameters_of
from thrust_allocator import AllocatorSettings
from thrust_allocator.settings import UNLIMITED

PAGE = Path(__file__).resolve().parents[2] / "docs" / "thrust_allocator.md"
BEGIN, END = "<!-- parameters: tests/support/parameter_table.py -->\n", "<!-- end of parameters -->"


def fields(model: type[Settings], prefix: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """Every parameter with the field that declares it, groups with dots."""
    for name, field in model.model_fields.items():
        group = field.annotation
        if isinstance(group, type) and issubclass(group, Settings):
            yield from fields(group, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", field


def table() -> str:
    """The table, with the defaults of CyberShip III."""
    defaults = parameters_of(AllocatorSettings.for_vessel(load_vessel("cybership3")))
    rows = ["| parameter | default | range | unit | |", "| --- | --- | --- | --- | --- |"]
    for name, field in fields(AllocatorSettings):
        extra: Any = field.json_schema_extra
        default, range_ = _text(defaults[name]), _range(field)
        rows.append(f"| `{name}` | {default} | {range_} | {extra['unit']} | {field.description} |")
    return "\n".join(rows) + "\n"


def page_with(text: str) -> str:
    """The page with its table replaced by ``text``."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, found, after = rest.partition(END)
    if not found:
        sys.exit(f"{PAGE}: expected the lines {BEGIN!r} and {END!r}")
    return before + BEGIN + text + END + after


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return f"all {_text(value[0])}" if len(set(value)) == 1 else "vessel file"
    if isinstance(value, bool):
        return str(value).lower()
    if value == UNLIMITED:
        return "no limit"
    return f"`{value}`" if isinstance(value, str) else f"{value:g}"


def _range(field: FieldInfo) -> str:
    metadata, annotation = field.metadata, field.annotation
    if typing.get_origin(annotation) is tuple:
        element = typing.get_args(annotation)[0]
        metadata = list(getattr(element, "__metadata__", ()))
        annotation = typing.get_args(element)[0] if metadata else element
        metadata = [m for item in metadata for m in getattr(item, "metadata", [item])]
    if typing.get_origin(annotation) is typing.Literal:
        return ", ".join(f"`{choice}`" for choice in typing.get_args(annotation))
    if annotation is bool:
        return "false, true"
    low = next((m.ge for m in metadata if hasattr(m, "ge")), None)
    high = next((m.le for m in metadata if hasattr(m, "le")), None)
    if low is None:
        return "see below"
    return f"{low:g} or more" if high is None or high == UNLIMITED else f"{low:g} to {high:g}"


if __name__ == "__main__":
    content = page_with(table())
    PAGE.write_text(content, encoding="utf-8")
