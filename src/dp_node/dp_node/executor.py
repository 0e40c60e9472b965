"""An executor for message rings: a message is taken and its callback run in tens of microseconds.

rclpy's single-threaded executor builds its wait set anew for every callback, over all services, timers and event
handlers of all nodes. Here the handles are gathered once, kept until an entity comes or goes, and messages go from the
wait set straight to their callbacks; everything that is not a message is left to rclpy.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.executors import SingleThreadedExecutor, TimeoutObject
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.subscription import Subscription
from rclpy.utilities import timeout_sec_to_nsec

# Messages taken from one subscription before the others get their turn.
_BURST = 64
# Between two looks at coroutines that wait for something.
_TASK_PERIOD_NS = 1_000_000
# Between two looks at QoS events, which the fast wait set does not hold.
_FULL_PERIOD_NS = 100_000_000


class RingExecutor(SingleThreadedExecutor):
    """Single-threaded executor that serves subscriptions first. Callbacks of messages must not be coroutines."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._tasks: list[Any]  # rclpy's
        self._stale = True
        self._wait_set: Any = None
        self._handles: list[tuple[Callable[[Any], Any], Any]] = []
        self._subscriptions: dict[int, Subscription] = {}
        self._next_full = 0
        self._next_task = 0

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
        timeout = timeout_sec_to_nsec(timeout_sec)
        wait_set = self._wait_set
        wait_set.clear_entities()
        for add, handle in self._handles:
            add(handle)
        wait_set.wait(_FULL_PERIOD_NS if timeout < 0 else min(timeout, _FULL_PERIOD_NS))
        messages = wait_set.get_ready_entities("subscription")
        others = (
            wait_set.get_ready_entities("service")
            or wait_set.get_ready_entities("timer")
            or wait_set.get_ready_entities("client")
        )
        for pointer in messages:
            self._take(self._subscriptions[pointer])
        # The executor's own guard conditions only end a wait; rclpy sets them off after every callback it runs, so that
        # taking them for work would send every message through rclpy.
        own = {self._guard.handle.pointer, self._sigint_gc.handle.pointer}
        if others or not own.issuperset(wait_set.get_ready_entities("guard_condition")):
            super()._spin_once_impl(0.0, wait_condition)

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

    def _gather(self) -> None:
        """Collect the handles of all nodes and make a wait set of their number."""
        nodes = list(self.get_nodes())
        subscriptions = [s for node in nodes for s in node.subscriptions]
        services = [s for node in nodes for s in node.services]
        timers = [t for node in nodes for t in node.timers]
        clients = [c for node in nodes for c in node.clients]
        guards = [g for node in nodes for g in node.guards]
        guards += [self._guard, self._sigint_gc]
        self._wait_set = _rclpy.WaitSet(
            len(subscriptions),
            len(guards),
            len(timers),
            len(clients),
            len(services),
            0,
            self._context.handle,
        )
        wait_set = self._wait_set
        self._subscriptions = {s.handle.pointer: s for s in subscriptions}
        self._handles = (
            [(wait_set.add_subscription, s.handle) for s in subscriptions]
            + [(wait_set.add_service, s.handle) for s in services]
            + [(wait_set.add_timer, t.handle) for t in timers]
            + [(wait_set.add_client, c.handle) for c in clients]
            + [(wait_set.add_guard_condition, g.handle) for g in guards]
        )
