"""Types of messages out of their definitions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from rosbags.typesys import get_types_from_msg
from rosbags.typesys.store import Typestore


def types_of(definitions: Mapping[str, str]) -> Typestore:
    """Return a store that knows the types of ``definitions``: full text (encoding ros2msg) by type.

    Nothing else is in it, so a recording is read by the definitions that it holds.
    """
    store = Typestore()
    for kind, text in definitions.items():
        # Types that two definitions contain are the same in both.
        store.register({name: form for name, form in _parsed(text, kind).items() if name not in store.types})
    return store


@lru_cache(maxsize=64)
def _parsed(text: str, kind: str) -> Mapping[str, Any]:
    return dict(get_types_from_msg(text, kind))
