"""Full text of message definitions, nested ones included, as the MCAP encoding ``ros2msg`` wants them.

See https://mcap.dev/spec/registry#ros2msg.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from dp_tools.recorder.errors import RecordingRefusedError

_BUILT_IN = frozenset(
    ["bool", "byte", "char", "string", "wstring", "float32", "float64"]
    + [f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)]
)
# Type, then array brackets or a bound, then the name; comments and constants do not matter here.
_FIELD = re.compile(r"^\s*(?P<type>[A-Za-z][A-Za-z0-9_/]*)(<=\d+)?(\[[^\]]*\])?\s+[A-Za-z]")
_SEPARATOR = "=" * 80


class DefinitionMissingError(RecordingRefusedError):
    """The text of a message definition is not installed here."""


def installed_definition(package: str, name: str) -> str:
    """Return the text of share/<package>/msg/<name>.msg out of the ament index.

    Raises
    ------
    DefinitionMissingError
        If it is not there.
    """
    try:
        path = Path(get_package_share_directory(package)) / "msg" / f"{name}.msg"
        return path.read_text(encoding="utf-8")
    except (PackageNotFoundError, OSError) as error:
        raise DefinitionMissingError(f"message type {package}/msg/{name}: no definition installed") from error


def nested_types(package: str, text: str) -> list[tuple[str, str]]:
    """Return package and name of every message type that a definition in ``package`` uses, in order, once each."""
    found: dict[tuple[str, str], None] = {}
    for line in text.splitlines():
        match = _FIELD.match(line.partition("#")[0])
        if match is None or match["type"] in _BUILT_IN:
            continue
        *scope, name = match["type"].split("/")
        found[(scope[0] if scope else package, name)] = None
    return list(found)


def full_definition(kind: str, definition: Callable[[str, str], str] = installed_definition) -> str:
    """Return the text of ``kind`` (e.g. ``nav_msgs/msg/Odometry``) and of all it contains.

    Parameters
    ----------
    kind
        Message type.
    definition
        Returns the text of one definition, by package and name.

    Raises
    ------
    DefinitionMissingError
        If one of them is not installed.
    """
    package, _, name = kind.split("/")
    top = definition(package, name)
    parts = [top]
    waiting = nested_types(package, top)
    seen = set(waiting)
    while waiting:
        package, name = waiting.pop(0)
        text = definition(package, name)
        parts.append(f"{_SEPARATOR}\nMSG: {package}/{name}\n{text}")
        for nested in nested_types(package, text):
            if nested not in seen:
                seen.add(nested)
                waiting.append(nested)
    return "\n".join(part.rstrip("\n") for part in parts) + "\n"
