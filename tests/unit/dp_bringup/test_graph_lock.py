"""One graph a domain and namespace."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from dp_bringup.graph_lock import graph_lock


def test_the_second_is_refused_until_the_first_ends(tmp_path: Path) -> None:
    with graph_lock("7", "fleet/port", tmp_path) as first:
        assert first
        with graph_lock("7", "/fleet/port/", tmp_path) as second:
            assert not second
        for other in (("8", "fleet/port"), ("7", "fleet/starboard"), ("7", "")):
            with graph_lock(*other, tmp_path) as free:
                assert free
    with graph_lock("7", "fleet/port", tmp_path) as again:
        assert again


def test_the_kernel_drops_the_lock_of_a_process_that_dies(tmp_path: Path) -> None:
    program = (
        "import os, pathlib, sys; from dp_bringup.graph_lock import graph_lock\n"
        "with graph_lock('1', '', pathlib.Path(sys.argv[1])) as free: os._exit(10 + free)"
    )
    assert subprocess.run([sys.executable, "-c", program, str(tmp_path)], check=False).returncode == 11
    with graph_lock("1", "", tmp_path) as free:
        assert free


def test_a_file_that_cannot_be_opened_refuses_nobody(tmp_path: Path) -> None:
    (tmp_path / "dp_graph_1_.lock").mkdir()
    with graph_lock("1", "", tmp_path) as free:
        assert free


def test_a_failure_inside_is_not_swallowed(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), graph_lock("1", "", tmp_path):
        raise ZeroDivisionError
    with graph_lock("1", "", tmp_path) as free:
        assert free
