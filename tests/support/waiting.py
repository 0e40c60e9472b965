"""Waiting for a condition, never for a time."""

import time
from collections.abc import Callable


def wait_until(
    condition: Callable[[], object],
    *,
    timeout: float = 20.0,
    message: str | Callable[[], str] = "",
    spin: Callable[[float], object] | None = None,
) -> None:
    """Returns as soon as `condition()` is true; fails with `message` when `timeout` s have passed.

    `spin(seconds)` is done meanwhile, at most `seconds` long; e.g. `lambda s: executor.spin_once(timeout_sec=s)`.
    Without it the processor is yielded. The default timeout is far above what any condition needs on a loaded machine:
    it bounds a failure only.
    """
    deadline = time.monotonic() + timeout
    while not condition():
        left = deadline - time.monotonic()
        if left <= 0:
            text = message() if callable(message) else message
            raise AssertionError(f"not within {timeout} s: {text or 'the condition became true'}")
        step = min(left, 0.05)
        if spin is None:
            time.sleep(min(step, 0.005))
        else:
            spin(step)
