"""A short-lived ROS node through which the command line talks to the graph."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import rclpy
from rclpy.context import Context
from rclpy.exceptions import InvalidNamespaceException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.validate_namespace import validate_namespace

from dp_node import RingExecutor
from marine_model.errors import DpError

T = TypeVar("T")

# A second call does no harm, and on an idle machine the first is answered within milliseconds.
_CALL_AGAIN_SECONDS = 1.0


class NoAnswerError(DpError):
    """A node or service did not answer within its time."""


class NamespaceError(DpError):
    """A namespace is not one that ROS knows."""


class Operator:
    """One node on one executor, with bounded waits.

    Parameters
    ----------
    node
        The ROS node; its executor is made here.
    watch
        Called while waiting; raises to give the wait up, e.g. because a process has died.
    """

    def __init__(self, node: Node, watch: Callable[[], None] = lambda: None) -> None:
        self.node = node
        self.watch = watch
        self.executor = RingExecutor(context=node.context)
        self.executor.add_node(node)
        self._others: list[Node] = []

    def make_node(self, name: str) -> Node:
        """Return another node in the same namespace, spun and closed together with this one."""
        node = rclpy.create_node(name, context=self.node.context, namespace=self.node.get_namespace())
        self._others.append(node)
        self.executor.add_node(node)
        return node

    def close(self) -> None:
        """Give everything back."""
        self.executor.shutdown()
        for node in (*self._others, self.node):
            node.destroy_node()

    def wait_until(self, condition: Callable[[], bool], seconds: float | None, what: str) -> None:
        """Spin until ``condition`` holds.

        Raises
        ------
        NoAnswerError
            If it does not hold within ``seconds`` (None: no limit); the text names ``what`` was waited for.
        """
        deadline = None if seconds is None else time.monotonic() + seconds
        while not condition():
            self.watch()
            if deadline is not None and time.monotonic() > deadline:
                raise NoAnswerError(f"waited {seconds:g} s for {what}" if seconds else f"expected {what}")
            self.executor.spin_once(timeout_sec=0.05)

    def settled(self, observe: Callable[[], T], quiet: float = 1.0, seconds: float = 5.0) -> T:
        """Spin until ``observe`` has returned the same for ``quiet`` s, at most ``seconds``: discovery takes time."""
        deadline = time.monotonic() + seconds
        seen, since = observe(), time.monotonic()
        while time.monotonic() < min(deadline, since + quiet):
            self.executor.spin_once(timeout_sec=0.05)
            now = observe()
            if now != seen:
                seen, since = now, time.monotonic()
        return seen

    def call(self, client: Any, request: Any, seconds: float, what: str) -> Any:
        """Call a service whose calls may be repeated, and return its response.

        A service drops its response if it has not heard of this client's reader yet, which the client cannot see: so
        the request goes out again from time to time.

        Raises
        ------
        NoAnswerError
            If there is no response within ``seconds``.
        """
        self.wait_until(client.service_is_ready, seconds, f"service {client.srv_name}")
        futures: list[Future] = []
        next_call = 0.0

        def answered() -> bool:
            nonlocal next_call
            if time.monotonic() >= next_call:
                futures.append(client.call_async(request))
                next_call = time.monotonic() + _CALL_AGAIN_SECONDS
            return any(future.done() for future in futures)

        try:
            self.wait_until(answered, seconds, what)
            return next(future.result() for future in futures if future.done())
        finally:
            for future in futures:
                client.remove_pending_request(future)


def full_namespace(namespace: str) -> str:
    """Return a namespace with its leading slash. Raises NamespaceError."""
    full = f"/{namespace.strip('/')}"
    try:
        validate_namespace(full)
    except InvalidNamespaceException as error:
        raise NamespaceError(f"namespace: expected one such as 'ship' or 'fleet/ship', found '{namespace}'") from error
    return full


@contextmanager
def operator(namespace: str = "", name: str = "") -> Iterator[Operator]:
    """Make an operator node, named after this process unless it has a name, and close it in the end.

    Raises
    ------
    NamespaceError
        If the namespace is none.
    """
    # Ctrl-C stays Python's KeyboardInterrupt, so that children can be stopped in order.
    full = full_namespace(namespace)
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    # Without a name of its own it is hidden: nobody's to talk to, and no part of a recording.
    node = rclpy.create_node(name or f"_dp_operator_{os.getpid()}", context=context, namespace=full)
    one = Operator(node)
    try:
        yield one
    finally:
        one.close()
        rclpy.try_shutdown(context=context)
