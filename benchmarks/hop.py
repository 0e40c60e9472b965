"""Hop latency: from a demand that goes out to the command that answers it, through the real allocator in its process.

A hop is measured in the client alone, as a round trip: from before `publish` of the request to the entry of the
callback of the answer, by one clock. So it holds two messages between two processes and what the other process does.
The peer is a process that does nothing but answer. Client, quality of service, message of the request and the moment
are the same: blocks of requests go to the two in turn, each block with the other one idle.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from dp_msgs.msg import ThrusterCommand
from geometry_msgs.msg import WrenchStamped

from benchmarks import echo_node
from benchmarks.plan import Plan
from benchmarks.result import Aim, Result
from benchmarks.statistics import summarize
from dp_bringup.operator_node import NoAnswerError, Operator, operator
from dp_bringup.processes import Children
from dp_bringup.workspace import executable
from dp_node import RING, RING_PUBLISHER, from_nanoseconds, to_nanoseconds
from dp_tools.in_process import ClosedLoop
from marine_model import Vessel, load_vessel
from marine_model.frames import BODY_FRAME

_PEER = "bare rclpy echo"
_ANSWER_SECONDS = 10.0
# Requests before the first that counts: the middleware sends its first messages another way.
_WARM_UP = 20
_MICROSECOND = 1e-6


class Line:
    """A request topic and its answer topic, seen from the client."""

    def __init__(self, one: Operator, request: str, answer: str, kind: Any) -> None:
        self._one = one
        self._answer = answer
        self._publisher = one.node.create_publisher(WrenchStamped, request, RING_PUBLISHER)
        self._subscription = one.node.create_subscription(kind, answer, self._note, RING)
        self._stamp = 0
        self._arrived = 0.0

    def ready(self, listeners: int = 1) -> bool:
        """Return whether both topics have their other end; ``listeners`` of the request."""
        ends = self._publisher.get_subscription_count(), self._subscription.get_publisher_count()
        return bool(ends == (listeners, 1))

    def hop(self, request: Any) -> float:
        """Send a request and return the time to its answer, s.

        Raises
        ------
        NoAnswerError
            If there is none within 10 s.
        """
        stamp = to_nanoseconds(request.header.stamp)
        spin = self._one.executor.spin_once
        begin = time.perf_counter()
        self._publisher.publish(request)
        while self._stamp != stamp:
            spin(timeout_sec=1.0)
            if time.perf_counter() - begin > _ANSWER_SECONDS:
                raise NoAnswerError(f"waited {_ANSWER_SECONDS:g} s for {self._answer}")
        return self._arrived - begin

    def _note(self, message: Any) -> None:
        self._arrived = time.perf_counter()
        self._stamp = to_nanoseconds(message.header.stamp)


def measure_hop(plan: Plan) -> list[Result]:
    """Measure the hop through the allocator beside the bare one."""
    requests = demands(plan)
    with operator() as one, _servers(plan, one):
        ring = Line(one, "tau_desired", "thruster_command", ThrusterCommand)
        bare = Line(one, echo_node.REQUEST, echo_node.ANSWER, WrenchStamped)
        one.wait_until(lambda: ring.ready() and bare.ready(), 30.0, "allocator and echo to be there")
        times = hops_in_turn(one, (ring, bare), (requests, requests), plan.hop_blocks, plan.hop_requests)
    return hop_results("hop_latency", times, _PEER, 1.5, "")


def hops_in_turn(
    one: Operator, lines: Sequence[Line], requests: Sequence[Iterator[Any]], blocks: int, size: int, pace: float = 0.0
) -> list[list[float]]:
    """Return the times of hops through two lines, us: blocks of ``size`` requests in turn, after a warm-up of each.

    A request goes out ``pace`` s after the one before it; with 0 as soon as that is answered.
    """

    def hop(k: int) -> float:
        begin = time.perf_counter()
        taken = lines[k].hop(next(requests[k]))
        while (left := begin + pace - time.perf_counter()) > 0.0:
            one.executor.spin_once(timeout_sec=left)
        return taken / _MICROSECOND

    for line, own in zip(lines, requests, strict=True):
        for _ in range(_WARM_UP):
            line.hop(next(own))
    times: list[list[float]] = [[], []]
    for block in range(blocks):
        # Neither is always first, nor always the one that comes after a pause.
        for k in (0, 1) if block % 2 == 0 else (1, 0):
            one.watch()
            times[k] += [hop(k) for _ in range(size)]
    return times


def hop_results(name: str, times: Sequence[Sequence[float]], peer: str, aim: float, more: str) -> list[Result]:
    """Return median and 99th percentile of the first line beside those of the second, ``peer``."""
    ours, theirs = summarize(times[0]), summarize(times[1])
    note = f"round trip, {ours.count} requests each in alternate blocks{more}"
    return [
        Result(f"{name}_median", ours.median, "us", peer, theirs.median, Aim("ratio", "<=", aim), note),
        Result(f"{name}_p99", ours.p99, "us", peer, theirs.p99, None, note),
    ]


@contextmanager
def _servers(plan: Plan, one: Operator) -> Iterator[None]:
    """Start the two processes that answer, and stop them in the end."""
    children = Children(plan.scratch / "hop")
    one.watch = children.check
    allocator: list[str | Path] = [executable("thrust_allocator", "node"), "--ros-args", "-p", f"vessel:={plan.vessel}"]
    try:
        children.start("thrust_allocator", [*allocator, "-p", "azimuth_mode:=rotating"])
        children.start("echo", [sys.executable, Path(echo_node.__file__)])
        yield
    finally:
        children.stop()


def demands(plan: Plan) -> Iterator[Any]:
    """Yield the demands of the scenario one after another, over and over, with stamps that go on."""
    vessel: Vessel = load_vessel(plan.vessel)
    demands = ClosedLoop(vessel, plan.scenario).run()["tau_desired"].values.tolist()
    sample = round(vessel.measurement.sample_time * 1e9)
    message = WrenchStamped()
    message.header.frame_id = BODY_FRAME
    stamp = 0
    while True:
        for surge, sway, yaw in demands:
            stamp += sample
            message.header.stamp = from_nanoseconds(stamp)
            message.wrench.force.x, message.wrench.force.y, message.wrench.torque.z = surge, sway, yaw
            yield message
