"""Python functions as machine code, for the few loops that every step of a core goes through."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.caching import FunctionCache

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile ``function`` at its first call and keep the machine code on disk for the next process.

    It must be written in what numba knows: numbers, tuples, numpy arrays of one type, loops. Division by zero gives
    infinity or NaN, as numpy does, and raises nothing; floating-point operations are not reordered, so that results
    are the same in every process. ``function.py_func`` is the plain Python function.
    """
    return _dispatcher(function)


def inlined(function: F) -> F:
    """Do what ``compiled`` does, and put the machine code into that of every function that calls it.

    For small functions in a hot loop: numba hands over an array as seven numbers.
    """
    return _dispatcher(function, forceinline=True)


def unlocked(function: F) -> F:
    """Do what ``compiled`` does, and let other threads run Python meanwhile: for work that is split among threads."""
    return _dispatcher(function, nogil=True)


def _dispatcher(function: F, **options: bool) -> F:
    dispatcher = numba.njit(error_model="numpy", **options)(function)
    dispatcher._cache = _PackageCache(function)
    return cast("F", dispatcher)


class _PackageCache(FunctionCache):
    """Machine code that is good as long as no file of its package has changed.

    numba itself looks at the file of the function only, and would go on using what was compiled from a function that
    it calls in another file.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        packages = {__name__.partition(".")[0], function.__module__.partition(".")[0]}
        self._cache_file._source_stamp = tuple(_stamp(name) for name in sorted(packages))


@cache
def _stamp(package: str) -> tuple[tuple[str, int, int], ...]:
    """Return name, time and size of every source file of a package that is being imported."""
    found = []
    for folder in getattr(sys.modules.get(package), "__path__", ()):
        for path in sorted(Path(folder).rglob("*.py")):
            status = path.stat()
            found.append((path.name, status.st_mtime_ns, status.st_size))
    return tuple(found)
