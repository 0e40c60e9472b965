"""metadata.yaml against what is in the files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from dp_tools.bags.bag import Bag
from dp_tools.bags.files import METADATA
from dp_tools.bags.finding import Finding
from dp_tools.bags.yaml_text import YAML_ERRORS, from_yaml


def check_metadata(bag: Bag, counts: Mapping[str, int]) -> Iterator[Finding]:
    """Yield what metadata.yaml says and the files do not hold; nothing where a single file was named.

    Parameters
    ----------
    bag
        Open.
    counts
        Messages by name of the file.
    """
    told = bag.files.metadata
    if told is None:
        if bag.files.path.is_dir():
            yield Finding(METADATA, "is not there: the recording was not closed")
        return
    messages = bag.messages
    first, last = (int(messages.log_time.min()), int(messages.log_time.max())) if len(messages) else (0, 0)
    checks = [
        ("message_count", _at(told, "message_count"), len(messages)),
        ("starting_time", _at(told, "starting_time", "nanoseconds_since_epoch"), first),
        ("duration", _at(told, "duration", "nanoseconds"), last - first),
        ("storage_identifier", _at(told, "storage_identifier"), "mcap"),
    ]
    for name, says, there in checks:
        if says != there:
            yield Finding(METADATA, f"{name}: it says {says}, the bag holds {there}")
    listed = told.get("files")
    for one in listed if isinstance(listed, list) else []:
        name, says = _at(one, "path"), _at(one, "message_count")
        if name not in counts or says != counts[name]:
            yield Finding(METADATA, f"files: {name}: it says {says} messages, the file holds {counts.get(name, 0)}")
    yield from _check_topics(bag, told)
    unknown = sorted({path.name for path in bag.files.path.glob("*.mcap")} - {path.name for path in bag.files.files})
    if unknown:
        yield Finding(METADATA, f"does not name {', '.join(unknown)}")


def _check_topics(bag: Bag, told: Mapping[str, Any]) -> Iterator[Finding]:
    counts = np.bincount(bag.messages.topic, minlength=len(bag.topics))
    there: dict[str, tuple[str, int]] = {}
    quality: dict[str, list[Any]] = {}
    for topic, count in zip(bag.topics, counts.tolist(), strict=True):
        there[topic.name] = topic.kind, count + there.get(topic.name, ("", 0))[1]
        quality[topic.name] = [*quality.get(topic.name, []), list(topic.offered_quality)]
    seen: dict[str, tuple[Any, int]] = {}
    listed = told.get("topics_with_message_count")
    for one in listed if isinstance(listed, list) else []:
        name, count = _at(one, "topic_metadata", "name"), _at(one, "message_count")
        before = seen.get(str(name), ("", 0))[1]
        seen[str(name)] = _at(one, "topic_metadata", "type"), before + (count if isinstance(count, int) else 0)
        offered = _offered(_at(one, "topic_metadata", "offered_qos_profiles"))
        if name in quality and offered not in quality[name]:
            yield Finding(METADATA, f"{name}: another quality of service than in the file")
    for name in sorted(there.keys() | seen.keys()):
        if seen.get(name) != there.get(name) and (name in seen or there[name][1]):
            says, holds = (
                f"{kind}, {count} messages" if kind else "nothing"
                for kind, count in (seen.get(name, ("", 0)), there.get(name, ("", 0)))
            )
            yield Finding(METADATA, f"{name}: it says {says}, the bag holds {holds}")


def _offered(value: Any) -> Any:
    """Return profiles as a list; before version 9 they were YAML in a text."""
    if isinstance(value, str):
        try:
            value = from_yaml(value)
        except YAML_ERRORS:
            return None
    return value or []


def _at(tree: Any, *keys: str) -> Any:
    for key in keys:
        tree = tree.get(key) if isinstance(tree, dict) else None
    return tree
