"""The state of objects, kept and put back in place.

A copy of the objects will not do: cores keep arrays of which others are views, and copies of both would no longer be
one memory. So the contents of everything mutable that is reached are kept, and put back into the same objects.
"""

from __future__ import annotations

import types
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from enum import Enum
from functools import partial
from typing import Any

import numpy as np

from marine_model.schema import Section

_PLAIN = (bool, int, float, complex, str, bytes, type(None), Enum, type, np.dtype, np.generic, types.ModuleType)
Restore = Callable[[], None]


class Memento:
    """Contents of all mutable objects that ``roots`` lead to.

    Parameters
    ----------
    roots
        Where to begin.
    apart
        Objects that are left as they are, with all that only they lead to.
    """

    def __init__(self, roots: Iterable[Any], apart: Iterable[Any]) -> None:
        self._restores: list[Restore] = []
        self._keep: list[Any] = []  # an object that went away would give its id to another
        seen = {id(one) for one in apart}
        waiting = list(roots)
        while waiting:
            one = waiting.pop()
            # Vessels and settings never change.
            if isinstance(one, (*_PLAIN, Section)) or id(one) in seen:
                continue
            seen.add(id(one))
            self._keep.append(one)
            waiting.extend(self._note(one))

    def restore(self) -> None:
        """Put all contents back."""
        for restore in self._restores:
            restore()

    def _note(self, one: Any) -> Iterator[Any]:
        """Keep the contents of one object; yield what it leads to."""
        if isinstance(one, np.ndarray):
            if one.flags.writeable:
                self._restores.append(partial(np.copyto, one, one.copy()))
            if one.base is not None:
                yield one.base
        elif isinstance(one, np.random.Generator):
            self._restores.append(partial(setattr, one.bit_generator, "state", one.bit_generator.state))
        elif isinstance(one, dict):
            self._restores.append(partial(_refill, one, dict(one)))
            yield from one.values()
        elif isinstance(one, list | deque):
            self._restores.append(partial(_extend, one, list(one)))
            yield from one
        elif isinstance(one, set):
            self._restores.append(partial(_refill, one, set(one)))
            yield from one
        elif isinstance(one, tuple | frozenset):
            yield from one
        elif isinstance(one, types.MethodType):
            yield one.__self__
        elif isinstance(one, partial):
            yield from (one.func, one.args, one.keywords)
        elif isinstance(one, types.FunctionType):
            yield from (cell.cell_contents for cell in one.__closure__ or () if _is_full(cell))
        else:
            yield from self._note_attributes(one)

    def _note_attributes(self, one: Any) -> Iterator[Any]:
        names = [name for kind in type(one).__mro__ for name in _slots(kind)]
        values = {name: getattr(one, name) for name in names if hasattr(one, name)}
        if values:
            self._restores.append(partial(_set_all, one, values))
            yield from values.values()
        if hasattr(one, "__dict__"):
            own = vars(one)
            self._restores.append(partial(_refill, own, dict(own)))
            yield from own.values()


def _slots(kind: type) -> Iterable[str]:
    """Return the names of slots that a class adds, as they are kept."""
    slots = kind.__dict__.get("__slots__", ())
    names = (slots,) if isinstance(slots, str) else slots
    hidden = f"_{kind.__name__.lstrip('_')}"
    return [
        f"{hidden}{name}" if name.startswith("__") and not name.endswith("__") else name
        for name in names
        if name not in ("__dict__", "__weakref__")
    ]


def _is_full(cell: Any) -> bool:
    try:
        return cell.cell_contents is not None
    except ValueError:  # not filled yet
        return False


def _refill(container: Any, content: Any) -> None:
    container.clear()
    container.update(content)


def _extend(container: Any, content: list[Any]) -> None:
    container.clear()
    container.extend(content)


def _set_all(one: Any, values: Mapping[str, Any]) -> None:
    for name, value in values.items():
        object.__setattr__(one, name, value)
