"""Versions of what takes part in a run."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

_DISTRIBUTIONS = ("dp_tools", "numpy", "daqp")


def versions() -> dict[str, str]:
    """Return the version of Python and of every distribution that the numbers depend on, by name."""
    found = {"python": platform.python_version()}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # run from a source tree that is not installed
            found[name] = "not installed"
    return found
