"""The `dp` command: the operator's work without the `ros2` command."""

from __future__ import annotations

from dp_tools.commands.catalogue import fill
from dp_tools.commands.root import app, main

fill(app)

__all__ = ["app", "main"]
