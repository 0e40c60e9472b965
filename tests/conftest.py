"""Fixtures that every test may use."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from support.domains import reserve_domain_id

# Speed is judged in benchmarks/, never by a test. In CI the same examples every time: a red run is the change's own.
settings.register_profile("project", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("project")

KINDS = ("unit", "node", "system")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Marks each test by the folder it is in."""
    here = Path(__file__).parent
    # With --reruns, 0 included, it is as whoever runs the tests says.
    again = config.pluginmanager.hasplugin("rerunfailures") and config.getoption("reruns", None) is None
    for item in items:
        if here in item.path.parents:
            kind = item.path.relative_to(here).parts[0]
            if kind in KINDS:
                item.add_marker(kind)
            # Discovery between processes may lose a datagram on a busy machine. A second try is shown in
            # the summary as a rerun, and what fails twice has failed.
            if again and kind in ("node", "system"):
                item.add_marker(pytest.mark.flaky(reruns=1))


@pytest.fixture
def ros_domain_id(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A ROS domain that is this test's own on this machine; in ROS_DOMAIN_ID, for nodes and child processes."""
    with reserve_domain_id() as domain_id:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain_id))
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        yield domain_id
