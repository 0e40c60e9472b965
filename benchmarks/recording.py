"""The recorder: messages a second without loss, processor time of a message, and what a recording does to a hop.

Several processes send messages of the size of ThrusterFeedback, serialized once. The recorder is the one that `dp up
--record` starts; its processor time is what the kernel counts for the process, reception by the middleware's threads
included.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import psutil
import yaml
from dp_msgs.msg import ThrusterCommand

from benchmarks import record_sender
from benchmarks.hop import Line, demands, hop_results, hops_in_turn
from benchmarks.plan import Plan
from benchmarks.record_sender import feedback
from benchmarks.result import Aim, Result
from dp_bringup.graph_nodes import is_there
from dp_bringup.operator_node import Operator, operator
from dp_bringup.processes import Child, Children
from dp_bringup.workspace import executable
from dp_tools.recorder import RECORDER_EARS
from marine_model import load_vessel

_WANTED = 20_000  # messages a second
_SENDERS = 4
# A publisher keeps a second of what it sends; a topic of the ring, at 100 Hz at most, keeps ten. For a burst, more than
# the recorder's readers hold.
_DEPTH = 5000
_BURST_DEPTH = 10_000
_BURST = 4000  # messages of each sender, less than the 5000 that a reader of the middleware holds
# So many times more blocks than for the plain hop, and as much shorter: what else the machine does falls on both.
_FINER = 10
# At the pace of the graph a block takes 30 times as long: so many times fewer of them.
_FEWER = 5
_MICROSECOND = 1e-6
_SECONDS = 60.0


@dataclass(frozen=True)
class Recorded:
    """What one recording showed.

    Parameters
    ----------
    sent
        Messages.
    rate
        Of all senders together, messages a second, as they came to send.
    kept, lost
        Messages in the bag; messages that the recorder missed.
    processor
        Processor time of the recorder, s, while the messages came.
    """

    sent: int
    rate: float
    kept: int
    lost: int
    processor: float


def measure_recording(plan: Plan) -> list[Result]:
    """Measure rate, loss, processor time and the effect on a hop."""
    size = len(feedback(plan.vessel))
    steady = record(plan, "steady", _WANTED / _SENDERS, round(_WANTED / _SENDERS * plan.record_seconds), _DEPTH)
    burst = record(plan, "burst", 0.0, _BURST, _BURST_DEPTH)
    cost = steady.processor / steady.kept
    note = f"{_SENDERS} senders, {size} bytes a message, load {os.getloadavg()[0]:.1f}"
    sent = f"{steady.sent} sent at {steady.rate:.0f}/s"
    return [
        Result(
            "recorder_rate",
            steady.kept * steady.rate / steady.sent,
            "1/s",
            None,
            None,
            Aim("value", ">=", _WANTED * 0.99),
            f"{sent}; {note}",
        ),
        Result("recorder_lost", steady.sent - steady.kept, "messages", None, None, Aim("value", "<=", 0.0), sent),
        Result("recorder_message", cost / _MICROSECOND, "us", None, None, None, f"processor time, all threads; {note}"),
        Result(
            "recorder_rate_of_one_core", 1.0 / cost, "1/s", None, None, Aim("value", ">=", _WANTED), "1 over the former"
        ),
        Result("recorder_burst_rate", burst.rate, "1/s", None, None, None, f"{burst.sent} sent as fast as it goes"),
        Result("recorder_burst_lost", burst.sent - burst.kept, "messages", None, None, Aim("value", "<=", 0.0), ""),
        *_hop(plan),
    ]


def record(plan: Plan, name: str, rate: float, number: int, depth: int) -> Recorded:
    """Record ``number`` messages of each sender, ``rate`` a second each (0: as fast as it goes)."""
    children = Children(plan.scratch / f"recording_{name}")
    bag = plan.scratch / f"bag_{name}"
    try:
        with operator() as one:
            one.watch = children.check
            recorder = start_recorder(children, one, bag)
            process = psutil.Process(recorder.pid)
            before = _processor(process)
            senders = [
                children.start(
                    f"sender_{k}",
                    [
                        sys.executable,
                        "-m",
                        record_sender.__name__,
                        f"/load/sender_{k}",
                        plan.vessel,
                        f"{rate}",
                        f"{number}",
                        f"{depth}",
                    ],
                )
                for k in range(_SENDERS)
            ]
            one.watch = lambda: None  # senders end by themselves
            one.wait_until(
                lambda: all(s.exit_code is not None for s in senders),
                _SECONDS + 10 * plan.record_seconds,
                "the senders",
            )
            processor = _processor(process) - before
            seconds = [
                float((plan.scratch / f"recording_{name}" / f"{s.name}.log").read_text().split()[0]) for s in senders
            ]
    finally:
        children.stop()
    information = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    kept = sum(
        topic["message_count"]
        for topic in information["topics_with_message_count"]
        if topic["topic_metadata"]["name"].startswith("/load/")
    )
    lost = int(information["custom_data"]["lost_messages"])
    return Recorded(_SENDERS * number, sum(number / s for s in seconds), kept, lost, processor)


def start_recorder(children: Children, one: Operator, bag: Path, *more: str) -> Child:
    """Start the recorder and wait until it listens."""
    command: list[str | Path] = [executable("dp_tools", "recorder"), "--ros-args", "-p", f"output:={bag}", *more]
    recorder = children.start("recorder", command)
    one.wait_until(lambda: is_there(one, RECORDER_EARS), _SECONDS, "the recorder")
    return recorder


def _processor(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


# The hop -------------------------------------------------------------------------------------------------------------


def _hop(plan: Plan) -> list[Result]:
    """Measure the hop through an allocator that is recorded, beside the same through one that is not.

    Once at the pace of the fastest messages of the graph, and once back to back: then the recorder is still busy with
    the last hop when the next one begins, and has to find a processor of its own.
    """
    pace = load_vessel(plan.vessel).simulation.time_step
    # Each has its own: stamps that go on without a gap.
    requests = demands(plan), demands(plan)
    with operator() as one, _allocators(plan, one):
        lines = [
            Line(one, f"/{name}/tau_desired", f"/{name}/thruster_command", ThrusterCommand)
            for name in ("recorded", "alone")
        ]
        # The recorder listens to the demand as well.
        one.wait_until(lambda: lines[1].ready() and lines[0].ready(listeners=2), _SECONDS, "the allocators to be there")
        number = _FINER * plan.hop_blocks, plan.hop_requests // _FINER
        close = hops_in_turn(one, lines, requests, *number)
        paced = hops_in_turn(one, lines, requests, number[0] // _FEWER, number[1], pace)
    load = f"load {os.getloadavg()[0]:.1f}"
    return [
        *hop_results("hop_recorded", paced, "not recorded", 1.1, f", {1.0 / pace:.0f} requests a second, {load}"),
        *hop_results("hop_recorded_back_to_back", close, "not recorded", 1.1, f", {load}"),
    ]


@contextmanager
def _allocators(plan: Plan, one: Operator) -> Iterator[None]:
    """Start two allocators, and a recorder for one of them; stop them in the end."""
    children = Children(plan.scratch / "hop_recorded")
    one.watch = children.check
    try:
        start_recorder(children, one, plan.scratch / "bag_hop", "-p", "regex:=^/recorded/")
        for name in ("recorded", "alone"):
            allocator: list[str | Path] = [executable("thrust_allocator", "node"), "--ros-args", "-r", f"__ns:=/{name}"]
            children.start(name, [*allocator, "-p", f"vessel:={plan.vessel}", "-p", "azimuth_mode:=rotating"])
        yield
    finally:
        children.stop()
