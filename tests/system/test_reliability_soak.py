"""A short soak: the long one is `python -m benchmarks --only soak`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.plan import whole
from benchmarks.soak import sail, trend

pytestmark = [pytest.mark.timeout(240), pytest.mark.usefixtures("ros_domain_id")]


def test_memory_of_the_composed_graph_does_not_grow_by_the_sample(tmp_path: Path) -> None:
    seconds, warm = 400.0, 220.0
    readings = sail(replace(whole(tmp_path), scratch=tmp_path), seconds, 10.0)
    kept = [reading for reading in readings if reading.simulated >= warm]
    found = trend(
        np.array([reading.simulated for reading in kept]), np.array([reading.resident / 1e6 for reading in kept])
    )
    # By then every topic of the ring has filled its history of 1000 messages (200 s at 5 a second); /diagnostics has
    # not. A leak of 100 bytes a message on each of a dozen topics at 50 a second would be 10 MB.
    assert found.growth < 3.0
