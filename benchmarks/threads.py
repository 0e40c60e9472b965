"""One function in several threads at once."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor


class Threads:
    """A thread for every processor, that of the caller among them."""

    def __init__(self) -> None:
        self.count = len(os.sched_getaffinity(0))
        self._pool = ThreadPoolExecutor(max(self.count - 1, 1))

    def __call__(self, work: Callable[[], None]) -> None:
        """Run ``work``, which takes from one heap in all threads, until the heap is empty."""
        others = [self._pool.submit(work) for _ in range(self.count - 1)]
        work()
        for other in others:
            if not other.cancel():  # what a busy processor has not begun is done already
                other.result()

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown()
