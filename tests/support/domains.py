"""ROS domains that no other test on this machine uses at the same time."""

import fcntl
import os
import random
import socket
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

# Up to 101 the ports of a domain stay below Linux's range of ephemeral ports.
DOMAIN_IDS = range(1, 102)


# Participants that find one another without multicast have a port each; rmw_fastrtps tries so many.
PARTICIPANTS = 32


def discovery_ports(domain_id: int) -> list[int]:
    """DDS-RTPS 9.6.1.1: port base 7400, 250 ports a domain; offset 0 is multicast, then 10 and every second one."""
    base = 7400 + 250 * domain_id
    return [base, *(base + 10 + 2 * number for number in range(PARTICIPANTS))]


def _is_in_use(domain_id: int) -> bool:
    """Whether anything on this machine still takes part in the domain, reservation or not.

    A node of an earlier test does until the garbage collector finds it, although it was destroyed and its context shut
    down: whoever looked for nodes in the domain would find it.
    """
    for port in discovery_ports(domain_id):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", port))
            except OSError:
                return True
    return False


@contextmanager
def reserve_domain_id(candidates: Iterable[int] = DOMAIN_IDS, folder: Path | None = None) -> Iterator[int]:
    """Holds a domain for as long as the context lasts.

    The reservation is a lock on a file in the temporary folder that all users share, so it holds against parallel
    pytest workers and other pytest runs, and the kernel drops it when a worker dies.
    """
    folder = folder or Path(tempfile.gettempdir())
    # In random order, so that a domain just left is seldom taken at once: its last messages may still be on their way.
    shuffled = list(candidates)
    random.shuffle(shuffled)
    for domain_id in shuffled:
        path = folder / f"ros_domain_{domain_id}.lock"
        try:
            lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError:  # another user's file
            continue
        try:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            if _is_in_use(domain_id):
                continue
            yield domain_id
            return
        finally:
            os.close(lock)
    message = f"every ROS domain of {len(shuffled)} is taken on this machine"
    raise RuntimeError(message)
