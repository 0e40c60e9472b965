"""What every node of the dynamic-positioning graph shares."""

from dp_node.alarms import ALARMS, Alarm, AlarmKind, raised
from dp_node.answer_gate import AnswerGate
from dp_node.executor import RingExecutor
from dp_node.health import Health, health_with
from dp_node.inbox import Inbox, WaitingRoom
from dp_node.level import Level
from dp_node.node import DpNode
from dp_node.quality import RING, RING_LOCKSTEP, RING_PUBLISHER
from dp_node.ring_node import RingNode
from dp_node.run import run_node, run_nodes
from dp_node.stamps import SourceRestartError, StampSequence, from_nanoseconds, seconds_between, to_nanoseconds

__all__ = [
    "ALARMS",
    "RING",
    "RING_LOCKSTEP",
    "RING_PUBLISHER",
    "Alarm",
    "AlarmKind",
    "AnswerGate",
    "DpNode",
    "Health",
    "Inbox",
    "Level",
    "RingExecutor",
    "RingNode",
    "SourceRestartError",
    "StampSequence",
    "WaitingRoom",
    "from_nanoseconds",
    "health_with",
    "raised",
    "run_node",
    "run_nodes",
    "seconds_between",
    "to_nanoseconds",
]
