"""What re-execution gave, written as a bag."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dp_tools.cdr.types import types_of
from dp_tools.recorder.bag_metadata import TopicInfo
from dp_tools.recorder.bag_writer import BagWriter
from dp_tools.recorder.schemas import full_definition
from dp_tools.reexecution.reexecute import Reexecution
from dp_tools.versions import VERSIONS_RECORD, versions

# Name of the metadata record that says of which bag it is a re-execution.
REEXECUTION_RECORD = "reexecution"


def write_outputs(folder: Path, found: Sequence[Reexecution], overwrite: bool) -> int:
    """Write the messages of re-executed nodes to a bag, with what was attached to theirs; return how many.

    A message has the time at which its node was fed with what it answers.

    Raises
    ------
    RecordingRefusedError
        If the folder holds something already or cannot be written, or a message definition is not installed.
    RecordingStoppedError
        If the disk is full.
    """
    recording = found[0].subject.recording
    kinds = {kind for one in found for kind in one.types.values()}
    definitions = {kind: full_definition(kind) for kind in sorted(kinds)}
    types = types_of(definitions)
    writer = BagWriter(folder, overwrite)
    try:
        for attached in recording.attachments:
            writer.attach(attached.name, "application/yaml", attached.data, attached.time)
        writer.describe(VERSIONS_RECORD, versions())
        given = [f"{one.subject.name}.{name}={value}" for one in found for name, value in one.subject.given.items()]
        names = ", ".join(one.subject.name for one in found)
        writer.describe(REEXECUTION_RECORD, {"of": recording.path.name, "nodes": names, "parameters": "; ".join(given)})
        messages = []
        for one in found:
            for topic, caught in one.outputs.items():
                full = one.subject.namespace + topic
                kind = one.types[topic]
                recorded = recording.topics.get(full)
                offered = recorded.offered_quality if recorded is not None else ()
                info = TopicInfo(full, kind, types.hash_rihs01(kind), tuple(offered))
                channel = writer.add_topic(info, definitions[kind])
                messages += [(message.time, channel, i + 1, message.data) for i, message in enumerate(caught)]
        messages.sort(key=lambda message: message[0])
        for time, channel, number, data in messages:
            writer.write(channel, data, time, time, number)
    finally:
        writer.close({"recorder": "dp_tools", "lost_messages": "0"})
    return len(messages)
