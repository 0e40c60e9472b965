"""Two hosts on one machine: two network namespaces joined by a pair of virtual Ethernet interfaces."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import pytest


@dataclass(frozen=True)
class TwoHosts:
    """Names of the two namespaces, and of the link's end in the first."""

    first: str
    second: str
    link: str

    def on(self, host: str) -> list[str]:
        """Return the words before a command that runs it there."""
        return ["ip", "netns", "exec", host]

    def set_link(self, up: bool) -> None:
        """Cut the link, or restore it."""
        _ip("-n", self.first, "link", "set", self.link, "up" if up else "down")


def _ip(*words: str, check: bool = True) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["ip", *words], check=check, capture_output=True, text=True)


@contextmanager
def two_hosts() -> Iterator[TwoHosts]:
    """Make two namespaces and the link; both are gone in the end. Skips the test where that is not permitted."""
    own = os.getpid()
    hosts = TwoHosts(f"dp{own}a", f"dp{own}b", f"dp{own % 100000}a")
    other = f"dp{own % 100000}b"
    try:
        try:
            for name in (hosts.first, hosts.second):
                _ip("netns", "add", name)
            _ip("link", "add", hosts.link, "netns", hosts.first, "type", "veth", "peer", other, "netns", hosts.second)
        except (OSError, subprocess.CalledProcessError) as error:
            reason = getattr(error, "stderr", "") or str(error)
            pytest.skip(f"network namespaces of our own are not permitted here: {reason.strip()}")
        for host, link, address in ((hosts.first, hosts.link, "10.213.7.1"), (hosts.second, other, "10.213.7.2")):
            _ip("-n", host, "addr", "add", f"{address}/24", "dev", link)
            _ip("-n", host, "link", "set", "lo", "up")
            _ip("-n", host, "link", "set", link, "up")
            _ip("-n", host, "route", "add", "224.0.0.0/4", "dev", link)
        yield hosts
    finally:
        for name in (hosts.first, hosts.second):
            _ip("netns", "delete", name, check=False)
