"""What a bag says of itself."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from dp_tools.bags.bag import Bag
from dp_tools.bags.content import lost_messages, several_publishers
from dp_tools.bags.copy import custom_data
from dp_tools.bags.parameters import changes, snapshots
from dp_tools.bags.yaml_text import YAML_ERRORS, from_yaml
from dp_tools.recorder.attachments import SCENARIO_ATTACHMENT, VESSEL_ATTACHMENT
from dp_tools.versions import VERSIONS_RECORD
from marine_model.errors import DpError


@dataclass(frozen=True)
class TopicSummary:
    """A topic: its messages, their mean rate in Hz (None below two), what was offered, and gaps (None: unknown)."""

    name: str
    type: str
    messages: int
    rate: float | None
    quality: str
    lost: int | None


@dataclass
class BagInfo:
    """All that is known of a bag without looking at fields; times in s since 1970, lengths in s, sizes in bytes."""

    path: str
    files: dict[str, int]
    unfinished: list[str]
    begin: float | None
    begin_utc: str
    duration: float
    messages: int
    compression: dict[str, int]
    uncompressed_size: int
    topics: list[TopicSummary]
    attachments: list[dict[str, Any]]
    parameters: dict[str, dict[str, Any]]
    vessel: str
    scenario: str
    lost_messages: str
    records: dict[str, dict[str, str]] = field(default_factory=dict)
    custom_data: dict[str, str] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return sum(self.files.values())

    @property
    def versions(self) -> dict[str, str]:
        """What was running, by name."""
        return self.records.get(VERSIONS_RECORD, {})


def bag_info(bag: Bag) -> BagInfo:
    """Return what a bag says of itself. Raises BagError."""
    messages = bag.messages
    times = messages.log_time
    custom = custom_data(bag.files.metadata)
    documents = {attachment.name: attachment.data for attachment in bag.attachments}
    return BagInfo(
        path=str(bag.files.path),
        files={path.name: path.stat().st_size for path in bag.files.files},
        unfinished=[f"{path.name}: {error}" for path, error in bag.cut_off.items()],
        begin=int(times.min()) * 1e-9 if len(times) else None,
        begin_utc=_utc(int(times.min())) if len(times) else "",
        duration=int(times.max() - times.min()) * 1e-9 if len(times) else 0.0,
        messages=len(messages),
        compression=dict(bag.chunks),
        uncompressed_size=bag.unpacked_size,
        topics=_topics(bag),
        attachments=[{"name": one.name, "size": len(one.data), "time": one.log_time * 1e-9} for one in bag.attachments],
        parameters=_parameters(bag),
        vessel=custom.get("vessel") or _name(documents.get(VESSEL_ATTACHMENT)),
        scenario=custom.get("scenario") or _name(documents.get(SCENARIO_ATTACHMENT)),
        lost_messages=custom.get("lost_messages", "not told"),
        records={one.name: one.metadata for one in bag.records if one.name != "rosbag2"},
        custom_data=custom,
    )


def _utc(time: int) -> str:
    return datetime.fromtimestamp(time // 1_000_000_000, UTC).isoformat() if time < 253_402_300_800_000_000_000 else ""


def _topics(bag: Bag) -> list[TopicSummary]:
    found = []
    for number, topic in enumerate(bag.topics):
        rows = np.flatnonzero(bag.messages.topic == number)
        times = bag.messages.publish_time[rows]
        span = int(times.max() - times.min()) * 1e-9 if len(rows) > 1 else 0.0
        lost = None if several_publishers(topic) else lost_messages(bag.messages.sequence[rows])
        rate = (len(rows) - 1) / span if span > 0.0 else None
        found.append(TopicSummary(topic.name, topic.kind, len(rows), rate, _quality(topic.offered_quality), lost))
    return found


def _quality(offered: Any) -> str:
    """Return the offers of all publishers in short, e.g. ``reliable, transient_local (2)``."""
    counts: Counter[str] = Counter()
    for one in offered:
        words = [str(one[name]) for name in ("reliability", "durability") if name in one]
        if one.get("history") in ("keep_last", 1):
            words.append(f"depth {one.get('depth')}")
        counts[", ".join(words)] += 1
    return "; ".join(f"{words} ({count})" if count > 1 else words for words, count in counts.items())


def _parameters(bag: Bag) -> dict[str, dict[str, Any]]:
    """Return, by node, how often its parameters were taken, how many there are, how often they changed."""
    found: dict[str, dict[str, Any]] = {}
    try:
        for snapshot in snapshots(bag):
            own = found.setdefault(snapshot.node, {"snapshots": 0, "parameters": 0, "changes": 0})
            own["snapshots"] += not snapshot.repeated
            own["parameters"] = len(snapshot.values)
        for change in changes(bag):
            if change.node in found:
                found[change.node]["changes"] += 1
    except DpError as error:
        found["?"] = {"error": str(error)}
    return found


def _name(document: bytes | None) -> str:
    """Return the name in a vessel or scenario file; empty where there is none."""
    try:
        content = from_yaml(document) if document else None
    except YAML_ERRORS:
        return ""
    return str(content.get("name", "")) if isinstance(content, dict) else ""
