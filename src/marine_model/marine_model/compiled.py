"""Python functions as machine code, for the few loops that every step of a core goes through."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile ``function`` at its first call and keep the machine code on disk for the next process.

    It must be written in what numba knows: numbers, tuples, numpy arrays of one type, loops. Division by zero gives
    infinity or NaN, as numpy does, and raises nothing; floating-point operations are not reordered, so that results
    are the same in every process. ``function.py_func`` is the plain Python function.
    """
    return cast("F", numba.njit(cache=True, error_model="numpy")(function))
