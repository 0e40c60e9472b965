"""One graph a ROS domain and namespace on this machine, whatever DDS has found out by then."""

from __future__ import annotations

import fcntl
import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def graph_lock(domain: str, namespace: str, folder: Path | None = None) -> Iterator[bool]:
    """Hold a lock for a domain and namespace while the context lasts; yield whether nobody else had it.

    The kernel drops it when the process dies. Where the file cannot be opened (another user's) nothing is known, and
    the lock counts as free: discovery is asked as well.
    """
    name = re.sub(r"[^A-Za-z0-9_]", "-", namespace.strip("/"))
    path = (folder or Path(tempfile.gettempdir())) / f"dp_graph_{domain}_{name}.lock"
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError:
        yield True
        return
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True
    finally:
        os.close(file)
