"""A recording from its beginning to its end."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence

import rclpy
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from dp_node import RingExecutor
from dp_node.run import Stop
from dp_tools.recorder.errors import RecordingStoppedError
from dp_tools.recorder.recorder_node import RecorderNode
from marine_model.errors import DpError

# Periods, s. Messages wait for at most the first in the middleware, which holds thousands.
_DRAIN = 0.01
_DISCOVER = 0.05
_LOOK = 0.2
_SERVE = 0.1
_TELL = 0.25
_ADAPT = 1.0
# A recorder that is killed loses what came since the last flush: less than a second.
_FLUSH = 0.5
# At the end: quiet for this long means that nothing is on its way any more; wait no longer than the second.
_QUIET = 0.1
_QUIET_LIMIT = 2.0
# Before the line that tells why a recording stopped by itself.
STOPPED = "recorder: "

Tell = Callable[[RecorderNode], None]


class Period:
    """Says when something is due again."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._next = 0.0

    def due(self, now: float) -> bool:
        """Return True at most once a period; ``now`` in s."""
        if now < self._next:
            return False
        self._next = now + self._seconds
        return True


class _End:
    """Says when a recording is over: on a signal, or after so many seconds."""

    def __init__(self, stop: Stop, seconds: float) -> None:
        self._stop = stop
        self._last = time.monotonic() + seconds if seconds else math.inf

    @property
    def reached(self) -> bool:
        return self._stop.requested or time.monotonic() >= self._last


def record(node: RecorderNode, executor: RingExecutor, end: _End, tell: Tell) -> None:
    """Record until the ``end``, then take what is still on its way.

    Raises
    ------
    RecordingStoppedError
        If the bag cannot be written any more.
    """
    discover, look, serve, adapt = Period(_DISCOVER), Period(_LOOK), Period(_SERVE), Period(_ADAPT)
    flush, show = Period(_FLUSH), Period(_TELL)
    recorder, watch, writer = node.recorder, node.watch, node.writer
    while not end.reached:
        now = time.monotonic()
        if discover.due(now):
            recorder.discover()
        if adapt.due(now):
            recorder.adapt()
        recorder.drain()
        if look.due(now):
            watch.look(now)
        watch.serve(now, time.time_ns())
        if serve.due(now):
            executor.spin_once(timeout_sec=0.0)
        if flush.due(now):
            writer.flush()
        if show.due(now):
            tell(node)
        time.sleep(max(0.0, now + _DRAIN - time.monotonic()))
    limit = time.monotonic() + _QUIET_LIMIT
    quiet = time.monotonic() + _QUIET
    while time.monotonic() < min(quiet, limit):
        if recorder.drain():
            quiet = time.monotonic() + _QUIET
        time.sleep(_DRAIN)
    recorder.settle()


def _stay(node: RecorderNode, executor: RingExecutor, end: _End) -> None:
    """Stay until the ``end`` after a recording that ended by itself: /diagnostics goes on saying so."""
    node.stop_listening()
    node.publish_health()
    while not end.reached:
        executor.spin_once(timeout_sec=0.1)


def run(
    arguments: list[str] | None = None,
    parameters: Sequence[Parameter] = (),
    namespace: str | None = None,
    tell: Tell = lambda node: None,
    say: Callable[[str], None] = lambda text: print(text, flush=True),
    complain: Callable[[str], None] = lambda text: print(f"{STOPPED}{text}", file=sys.stderr, flush=True),
) -> int:
    """Record until SIGINT or SIGTERM; return the exit code.

    Parameters
    ----------
    arguments
        Of ROS; None for those of the process.
    parameters
        Of the node, in place of its defaults.
    namespace
        Of the node; None for what ``arguments`` say.
    tell
        Called several times a second.
    say, complain
        Called with a line of text.
    """
    # Our own signal handling: rclpy's would close the context before the last messages are in the bag.
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    stop = Stop()
    executor = RingExecutor()
    node: RecorderNode | None = None
    code = 0
    try:
        node = RecorderNode(parameter_overrides=list(parameters), namespace=namespace)
        executor.add_node(node)
        end = _End(stop, node.duration)
        say(f"recording to {node.writer.path}")
        try:
            record(node, executor, end, tell)
        except RecordingStoppedError:
            pass  # close() says it, once the bag is whole
        finally:
            try:
                node.writer.close(node.custom_data())
            finally:
                _report(node, say, complain)
    except DpError as error:
        complain(str(error))
        code = 1
        if node is not None and node.writer.failed is not None:
            _stay(node, executor, end)
    finally:
        executor.shutdown()
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return code


def _report(node: RecorderNode, say: Callable[[str], None], complain: Callable[[str], None]) -> None:
    """Say what is in the bag and what is not."""
    counts, lost, files = node.recorder.counts, node.recorder.lost, node.writer.file_count
    say(
        f"recorded {node.writer.message_count} messages on {len(counts)} topics, "
        f"{node.writer.size / 1e6:.1f} MB{f' in {files} files' if files > 1 else ''}, lost {sum(lost.values())}"
    )
    if lost:
        complain("lost messages: " + ", ".join(f"{count} on {topic}" for topic, count in lost.items()))
    if node.watch.unanswered:
        complain(f"parameters of {', '.join(node.watch.unanswered)} are not in the bag: no answer")
