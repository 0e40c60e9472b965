"""What the text of a message definition says of its fields: units, and whether a number may be none."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache

_SEPARATOR = re.compile(r"^={10,}\s*$", re.MULTILINE)
_FIELD = re.compile(r"^\s*(?P<type>[A-Za-z][\w/]*(?:<=\d+)?)(?:\[[^\]]*\])?\s+(?P<name>[a-z]\w*)\s*(?:$|[^=\s(])")
_UNIT = r"[kM]?(?:N m|N|m|s|rad|deg|W|Hz|kg|Pa|V|A|J|K)(?:/(?:s\^2|s²|s|m|Hz))?"
# A comment tells a unit if it begins with it; several are of the elements of a vector.
_UNITS = re.compile(rf"^(?P<units>{_UNIT}(?:, {_UNIT})*)(?=$|[,:;.(]| \(| in )")
_NOT_A_NUMBER = re.compile(r"\b(nan|inf(inite)?|not a number)\b", re.IGNORECASE)


@dataclass(frozen=True)
class Definition:
    """Comments of one message type.

    Attributes
    ----------
    head
        What stands before the first field.
    comments
        By field: what stands behind it, or else in the lines before it.
    types
        By field, as written.
    """

    head: str
    comments: Mapping[str, str] = field(default_factory=dict)
    types: Mapping[str, str] = field(default_factory=dict)

    def units(self, name: str) -> tuple[str, ...]:
        """Return the unit of a field, or one an element; empty where the comment tells none."""
        found = _UNITS.match(self.comments.get(name, ""))
        return tuple(found["units"].split(", ")) if found else ()

    def may_be_none(self, name: str) -> bool:
        """Return whether the definition says of a field, or of all, that it may be NaN or infinite."""
        return bool(_NOT_A_NUMBER.search(self.comments.get(name, "")) or _NOT_A_NUMBER.search(self.head))


@cache
def definitions_in(kind: str, text: str) -> Mapping[str, Definition]:
    """Return the definitions in a full text (encoding ros2msg) by type; ``kind`` is that of the first."""
    found: dict[str, Definition] = {}
    for number, part in enumerate(_SEPARATOR.split(text)):
        name = kind
        if number:
            head, _, part = part.lstrip("\n").partition("\n")
            name = head.removeprefix("MSG:").strip()
        package, _, short = name.rpartition("/")
        full = name if "/msg/" in name else f"{package}/msg/{short}"
        found[full] = _definition(part)
    return found


def _definition(text: str) -> Definition:
    head: list[str] = []
    above: list[str] = []
    comments: dict[str, str] = {}
    types: dict[str, str] = {}
    for line in text.splitlines():
        code, _, comment = line.partition("#")
        match = _FIELD.match(code)
        if match is not None:
            comments[match["name"]] = comment.strip() or " ".join(above)
            types[match["name"]] = match["type"]
            above = []
        elif code.strip():
            above = []  # a constant
        elif not comments and not types:
            head.append(comment.strip())
        elif comment:
            above.append(comment.strip())
        else:
            above = []
    return Definition(" ".join(head), comments, types)
