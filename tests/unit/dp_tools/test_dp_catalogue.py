"""The list of commands is known without loading them, and says what they say of themselves."""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
import typer

from dp_tools.commands import catalogue
from support.dp_here import Dp, dp_here

__all__ = ["dp_here"]

# Each takes a tenth of a second or more to load.
SLOW = ("dp_msgs", "matplotlib", "numba", "numpy", "pyarrow", "pydantic", "rclpy", "rosbags", "scipy")

LOADED = """\
import json, sys
from dp_tools.cli import main
try:
    main()
finally:
    print(json.dumps([name for name in sys.modules if "." not in name]))
"""


def loaded_by(*words: str) -> set[str]:
    done = subprocess.run([sys.executable, "-c", LOADED, *words], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize("words", [("--help",), ()])
def test_the_list_of_commands_loads_nothing_slow(words: tuple[str, ...]) -> None:
    done = subprocess.run([sys.executable, "-c", LOADED, *words], capture_output=True, text=True, check=False)
    assert all(name in done.stdout for name in catalogue.ENTRIES)
    loaded = set(json.loads(done.stdout.splitlines()[-1]))
    assert {"typer", "rich", "dp_tools"} <= loaded
    assert loaded.isdisjoint(SLOW)


@pytest.mark.parametrize("command", ["status", "topics", "restart", "record", "replay"])
def test_what_an_operator_asks_of_a_graph_needs_no_compiler(command: str) -> None:
    loaded = loaded_by(command, "--help")
    assert "rclpy" in loaded
    assert loaded.isdisjoint({"matplotlib", "numba", "pyarrow", "scipy"})


def test_the_list_of_vessels_needs_neither_compiler_nor_ros() -> None:
    assert loaded_by("vessel", "list").isdisjoint({"matplotlib", "numba", "pyarrow", "rclpy", "scipy"})


@pytest.mark.parametrize("name", catalogue.ENTRIES)
def test_the_list_says_what_the_command_says(name: str, dp_here: Dp) -> None:
    entry = catalogue.ENTRIES[name]
    found = getattr(import_module(f"dp_tools.commands.{entry.module}"), entry.attribute)
    if not isinstance(found, typer.Typer):
        said = inspect.getdoc(found)
        assert said is not None
        assert entry.text == said.partition("\n\n")[0].replace("\n", " ")
    code, output = dp_here(name, "--help")
    assert code == 0
    # What stands there is the command itself: beside the help, options or commands of its own.
    assert f"dp {name} " in output
    assert sum(line.startswith("│ ") for line in output.splitlines()) > 1


def test_every_command_is_in_the_list() -> None:
    """A module of commands has a function of its name, or a Typer; the others help them."""
    folder = Path(catalogue.__file__).parent
    modules = {path.stem for path in folder.glob("*.py")} - {"__init__", "catalogue", "root"}
    with_command = {
        name
        for name in modules
        for found in vars(import_module(f"dp_tools.commands.{name}")).values()
        if isinstance(found, typer.Typer)
        or (inspect.isfunction(found) and found.__name__ == name and found.__module__.endswith(f".{name}"))
    }
    assert with_command == {entry.module for entry in catalogue.ENTRIES.values()}


def test_a_name_that_is_no_command_is_refused(dp_here: Dp) -> None:
    code, output = dp_here("statsu")
    assert code == 2
    assert "No such command 'statsu'" in output
