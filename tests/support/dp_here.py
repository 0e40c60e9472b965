"""The `dp` command called in this process: what it prints, and its exit code."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from rich.console import Console

from dp_tools.cli import main
from dp_tools.commands import (
    bag,
    bag_options,
    compare,
    design,
    detection,
    disturb,
    open_water,
    parameters,
    propeller,
    record,
    replay,
    report,
    root,
    run_scenarios,
    scenarios,
    status,
    topics,
    up,
    vessels,
)

Dp = Callable[..., tuple[int, str]]
_MODULES = (
    bag,
    compare,
    bag_options,
    design,
    detection,
    disturb,
    open_water,
    parameters,
    propeller,
    record,
    replay,
    report,
    root,
    run_scenarios,
    scenarios,
    status,
    topics,
    up,
    vessels,
)


@pytest.fixture
def dp_here(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Dp:
    """A function that runs `dp` with these words and returns exit code and what it printed, errors included."""
    # Wide enough that no message is broken.
    for name, stderr in (("console", False), ("error_console", True)):
        wide = Console(stderr=stderr, width=250)
        for module in _MODULES:
            if hasattr(module, name):
                monkeypatch.setattr(module, name, wide)

    def run(*words: str | Path) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["dp", *map(str, words)])
        capsys.readouterr()
        try:
            main()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
        else:
            code = 0
        return code, "".join(capsys.readouterr())

    return run
