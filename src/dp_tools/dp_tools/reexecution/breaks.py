"""Where the life of a recorded node broke: from there on it does not follow from what came before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from lifecycle_msgs.msg import State, TransitionEvent
from rclpy.serialization import deserialize_message

from dp_tools.reexecution.recording import Recorded, Recording

_EVENTS = "/parameter_events"
_LEAVING = (State.TRANSITION_STATE_DEACTIVATING, State.PRIMARY_STATE_INACTIVE)


@dataclass(frozen=True)
class Break:
    """The end of a life.

    Attributes
    ----------
    time
        Publish time of the first message of the next life, or of the transition, ns.
    last
        Publish time of the last message before, ns.
    reason
        What happened.
    """

    time: int
    last: int
    reason: str


def first_break(outputs: Mapping[str, Sequence[Recorded]], transitions: Sequence[Recorded]) -> Break | None:
    """Return the first restart or deactivation of a node; None if it lived on to the end.

    A publisher that was made anew counts its messages from 1 again.

    Parameters
    ----------
    outputs
        Its messages by topic, each in order of publish time.
    transitions
        Its lifecycle_msgs/TransitionEvent.
    """
    found = [
        (after.published, "restarted")
        for messages in outputs.values()
        for before, after in pairwise(messages)
        if after.number == 1 and before.number >= 1
    ]
    for message in transitions:
        event = deserialize_message(message.data, TransitionEvent)
        if event.start_state.id == State.PRIMARY_STATE_ACTIVE and event.goal_state.id in _LEAVING:
            found.append((message.published, "deactivated"))
    if not found:
        return None
    time, reason = min(found)
    before_it = [one.published for messages in outputs.values() for one in messages if one.published < time]
    return Break(time, max(before_it, default=0), reason)


def until(recording: Recording, broken: Break, outputs: Sequence[str]) -> Recording:
    """Return a recording without what came after a break; ``outputs`` are full names of the node's topics."""
    topics = {}
    for name, topic in recording.topics.items():
        # Of another life are events of parameters that were declared anew, before any other message.
        end = broken.last if name in outputs or name == _EVENTS else broken.time
        topics[name] = replace(topic, messages=[one for one in topic.messages if one.published <= end])
    return replace(recording, topics=topics)
