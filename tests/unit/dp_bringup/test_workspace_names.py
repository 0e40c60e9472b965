"""What is looked up by name: executables, shared files, message types, node classes."""

from __future__ import annotations

import importlib
import os
import sys
import types

import pytest

from dp_bringup.composed import main, node_factory
from dp_bringup.message_types import MessageTypeError, message_class
from dp_bringup.workspace import RING_PACKAGES, SIMULATOR_PACKAGE, WorkspaceError, executable, share
from dp_node import DpNode
from marine_model.errors import DpError

NODES = (*RING_PACKAGES, SIMULATOR_PACKAGE)


@pytest.mark.parametrize("package", NODES)
def test_every_node_package_has_its_executable(package: str) -> None:
    path = executable(package, "node")
    assert path.parts[-3:] == ("lib", package, "node")
    assert os.access(path, os.X_OK)


def test_an_executable_that_is_not_there() -> None:
    with pytest.raises(WorkspaceError, match=r"package vessel_sim: expected an executable autopilot, found none at "):
        executable("vessel_sim", "autopilot")
    with pytest.raises(WorkspaceError, match=r"package dp_autopilot: not in the ament index; build the workspace"):
        executable("dp_autopilot", "node")


def test_shared_files() -> None:
    assert (share("dp_bringup") / "launch" / "dp.launch.py").is_file()
    with pytest.raises(WorkspaceError, match=r"package dp_autopilot: not in the ament index"):
        share("dp_autopilot")


def test_message_types() -> None:
    found = message_class("geometry_msgs/msg/PoseStamped")
    assert found is importlib.import_module("geometry_msgs.msg").PoseStamped


@pytest.mark.parametrize("kind", ["geometry_msgs/msg/Nothing", "no_msgs/msg/Pose", "PoseStamped", "a/b/c/d", ""])
def test_message_types_that_are_not_installed(kind: str) -> None:
    with pytest.raises(MessageTypeError, match=rf"message type {kind}: not installed on this machine"):
        message_class(kind)


@pytest.mark.parametrize("package", NODES)
def test_the_node_of_a_package(package: str) -> None:
    factory = node_factory(package)
    assert isinstance(factory, type)
    assert issubclass(factory, DpNode)


def test_a_package_without_a_node(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("empty", "empty.node"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    with pytest.raises(DpError, match=r"empty\.node: expected one node class, found 0"):
        node_factory("empty")


def test_composed_knows_its_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["composed", "vessel_sim", "autopilot", "--ros-args", "-p", "x:=1"])
    with pytest.raises(SystemExit, match=r"composed: expected packages out of dp_observer, .*, found autopilot"):
        main()
