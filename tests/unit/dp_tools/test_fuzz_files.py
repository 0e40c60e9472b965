"""Spoiled files of every kind: each is read or refused with an error of this project.

DP_FUZZ_CASES says how many of each kind.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from support.file_fuzz import KINDS, outcome, spoiled

CASES = int(os.environ.get("DP_FUZZ_CASES", "20"))
# A bag is checked, read, repaired and read again: fewer of them where nobody asks for a number.
FEWER = {"bag": 10, "chunk": 10} if "DP_FUZZ_CASES" not in os.environ else {}


@pytest.mark.timeout(60 + CASES)
@pytest.mark.parametrize("name", KINDS)
def test_a_spoiled_file_is_read_or_refused(name: str, tmp_path: Path) -> None:
    kind = KINDS[name]
    seeds = kind.seeds()
    refused = 0

    @settings(max_examples=FEWER.get(name, CASES), suppress_health_check=list(HealthCheck))
    @given(st.integers(0, len(seeds) - 1), st.integers(0, 2**62))
    def spoil(good: int, seed: int) -> None:
        nonlocal refused
        error = outcome(kind, spoiled(seeds[good], seed), tmp_path / f"file{kind.suffix}")
        if error is not None:
            refused += 1
            assert str(error)

    spoil()
    assert refused, "spoiling has an effect"
