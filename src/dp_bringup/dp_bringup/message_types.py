"""Message classes by their ROS name."""

from __future__ import annotations

import importlib
from typing import Any

from marine_model.errors import DpError


class MessageTypeError(DpError):
    """A message type is not installed here."""


def message_class(kind: str) -> Any:
    """Return the class of a message type, e.g. ``geometry_msgs/msg/PoseStamped``.

    Raises
    ------
    MessageTypeError
        If there is no such message on this machine.
    """
    parts = kind.split("/")
    try:
        package, group, name = parts
        return getattr(importlib.import_module(f"{package}.{group}"), name)
    except (ValueError, ImportError, AttributeError) as error:
        raise MessageTypeError(f"message type {kind}: not installed on this machine") from error
