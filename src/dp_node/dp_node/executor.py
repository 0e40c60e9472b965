"""An executor for message rings: a message is taken and its callback run in tens of microseconds.

rclpy's single-threaded executor builds its wait set anew for every callback, over all services, timers and event
handlers of all nodes. Here the handles are gathered once, kept until an entity comes or goes, and messages and timers
go from the wait set straight to their callbacks; everything else is left to rclpy. While messages come one after the
other, as in a ring within one process, only subscriptions are looked at, and the rest now and then.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.executors import SingleThreadedExecutor, TimeoutObject
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.subscription import Subscription
from rclpy.timer import Timer

# Messages taken from one subscription before the others get their turn.
_BURST = 64
# Between two looks at coroutines that wait for something.
_TASK_PERIOD_NS = 1_000_000
# Between two looks at services, timers and clients while messages keep coming.
_MESSAGES_ALONE_NS = 5_000_000
# Between two looks at QoS events, which the wait sets here do not hold.
_FULL_PERIOD_NS = 500_000_000

Handles = list[tuple[Callable[[Any], Any], Any]]  # how to add to a wait set, and what


class RingExecutor(SingleThreadedExecutor):
    """Single-threaded executor that serves subscriptions first.

    Callbacks of messages and timers must not be coroutines.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._tasks: list[Any]  # rclpy's
        self._stale = True
        self._wait_set: Any = None
        self._handles: Handles = []
        self._message_wait_set: Any = None
        self._message_handles: Handles = []
        self._subscriptions: dict[int, Subscription] = {}
        self._timers: dict[int, Timer] = {}
        self._own_guards: set[int] = set()
        self._busy = False
        self._next_full = 0
        self._next_task = 0
        self._next_wait = 0

    def wake(self) -> None:
        """Wake the wait, and gather the handles anew: an entity came or went."""
        self._stale = True
        super().wake()

    def _spin_once_impl(
        self,
        timeout_sec: float | TimeoutObject | None = None,
        wait_condition: Callable[[], bool] = lambda: False,
    ) -> None:
        if isinstance(timeout_sec, TimeoutObject):
            timeout_sec = timeout_sec.timeout
        now = time.monotonic_ns()
        if self._stale or now >= self._next_full:
            self._stale = False
            self._next_full = now + _FULL_PERIOD_NS
            super()._spin_once_impl(0.0, wait_condition)
            self._gather()
            timeout_sec = 0.0 if timeout_sec is None else min(timeout_sec, 0.0)
        if self._tasks:
            # A finished task stays in the list until rclpy next looks: it is nothing to wait for.
            with self._tasks_lock:
                self._tasks = [t for t in self._tasks if not (t[0].done() or t[0].cancelled())]
        if self._tasks:
            if now >= self._next_task:
                self._next_task = now + _TASK_PERIOD_NS
                super()._spin_once_impl(0.0, wait_condition)
            timeout_sec = 0.001 if timeout_sec is None else min(timeout_sec, 0.001)
        if self._stale or not self._context.ok():
            return
        if self._busy and self._message_handles and now < self._next_wait:
            self._busy = self._serve_messages(self._message_wait_set, self._message_handles, 0)
            if self._busy or self._is_outdated():
                return
        self._next_wait = now + _MESSAGES_ALONE_NS
        wait_set = self._wait_set
        timeout = -1 if timeout_sec is None or timeout_sec < 0.0 else int(timeout_sec * 1e9)
        self._busy = self._serve_messages(
            wait_set, self._handles, _FULL_PERIOD_NS if timeout < 0 else min(timeout, _FULL_PERIOD_NS)
        )
        if self._is_outdated():
            return
        for pointer in wait_set.get_ready_entities("timer"):
            self._call(self._timers[pointer])
        # The executor's own guard conditions only end a wait; rclpy sets them off after every callback it runs, so that
        # taking them for work would send every message through rclpy.
        if (
            wait_set.get_ready_entities("service")
            or wait_set.get_ready_entities("client")
            or not self._own_guards.issuperset(wait_set.get_ready_entities("guard_condition"))
        ):
            self._next_wait = 0  # rclpy serves one at a time: look for the next at once
            super()._spin_once_impl(0.0, wait_condition)

    def _is_outdated(self) -> bool:
        """Return whether a callback made or destroyed an entity since the handles were gathered."""
        return self._stale

    def _serve_messages(self, wait_set: Any, handles: Handles, timeout: int) -> bool:
        """Wait up to ``timeout`` ns, take what has come to subscriptions; return whether there was anything."""
        wait_set.clear_entities()
        for add, handle in handles:
            add(handle)
        wait_set.wait(timeout)
        ready = wait_set.get_ready_entities("subscription")
        for pointer in ready:
            if self._is_outdated():
                break  # a callback before may have destroyed what comes next; it is looked for anew
            self._take(self._subscriptions[pointer])
        return bool(ready)

    def _take(self, subscription: Subscription) -> None:
        take, kind, raw = subscription.handle.take_message, subscription.msg_type, subscription.raw
        with_info = subscription._callback_type is Subscription.CallbackType.WithMessageInfo
        for _ in range(_BURST):
            taken = take(kind, raw)
            if taken is None:
                return
            if with_info:
                subscription.callback(*taken)
            else:
                subscription.callback(taken[0])

    def _call(self, timer: Timer) -> None:
        """Call a timer that is due; one that was cancelled since is not."""
        with timer.handle:
            if not timer.handle.is_timer_ready():
                return
            timer.handle.call_timer()
        timer.callback()

    def _gather(self) -> None:
        """Collect the handles of all nodes and make wait sets of their number."""
        nodes = list(self.get_nodes())
        subscriptions = [s for node in nodes for s in node.subscriptions]
        services = [s for node in nodes for s in node.services]
        timers = [t for node in nodes for t in node.timers]
        clients = [c for node in nodes for c in node.clients]
        own = [self._guard, self._sigint_gc]
        guards = [g for node in nodes for g in node.guards] + own
        context = self._context.handle
        self._subscriptions = {s.handle.pointer: s for s in subscriptions}
        self._timers = {t.handle.pointer: t for t in timers}
        self._own_guards = {g.handle.pointer for g in own}
        alone = _rclpy.WaitSet(len(subscriptions), 0, 0, 0, 0, 0, context)
        self._message_wait_set = alone
        self._message_handles = [(alone.add_subscription, s.handle) for s in subscriptions]
        whole = _rclpy.WaitSet(len(subscriptions), len(guards), len(timers), len(clients), len(services), 0, context)
        self._wait_set = whole
        self._handles = (
            [(whole.add_subscription, s.handle) for s in subscriptions]
            + [(whole.add_service, s.handle) for s in services]
            + [(whole.add_timer, t.handle) for t in timers]
            + [(whole.add_client, c.handle) for c in clients]
            + [(whole.add_guard_condition, g.handle) for g in guards]
        )
