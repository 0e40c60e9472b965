"""The launch file, read with small stand-ins for launch and launch_ros, which PyPI does not have."""

from __future__ import annotations

import importlib.util
import sys
import types
from dataclasses import dataclass, field
from typing import Any

import pytest

from dp_bringup.parameter_file import read_parameter_file
from dp_tools.node_settings import default_settings
from marine_model import load_vessel
from marine_model.settings import parameters_of, with_parameters
from support.repository import ROOT

BRINGUP = ROOT / "src" / "dp_bringup"
NODES = ("dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers", "vessel_sim")


@dataclass
class Stated:
    """What a launch file says: the arguments that an action or substitution was made with."""

    positional: tuple[Any, ...] = ()
    named: dict[str, Any] = field(default_factory=dict)

    def __init__(self, *positional: Any, **named: Any) -> None:
        self.positional, self.named = positional, named


class LaunchDescription(Stated):
    pass


class DeclareLaunchArgument(Stated):
    pass


class IfCondition(Stated):
    pass


class LaunchConfiguration(Stated):
    pass


class PathJoinSubstitution(Stated):
    pass


class LifecycleNode(Stated):
    pass


class FindPackageShare(Stated):
    pass


@pytest.fixture
def entities(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    for name, content in {
        "launch": (LaunchDescription,),
        "launch.actions": (DeclareLaunchArgument,),
        "launch.conditions": (IfCondition,),
        "launch.substitutions": (LaunchConfiguration, PathJoinSubstitution),
        "launch_ros": (),
        "launch_ros.actions": (LifecycleNode,),
        "launch_ros.substitutions": (FindPackageShare,),
    }.items():
        module = types.ModuleType(name)
        for kind in content:
            setattr(module, kind.__name__, kind)
        monkeypatch.setitem(sys.modules, name, module)
    spec = importlib.util.spec_from_file_location("dp_launch", BRINGUP / "launch" / "dp.launch.py")
    assert spec is not None
    assert spec.loader is not None
    launch_file = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(launch_file)
    (found,) = launch_file.generate_launch_description().positional
    return list(found)


def nodes(entities: list[Any]) -> dict[str, LifecycleNode]:
    return {entity.named["package"]: entity for entity in entities if isinstance(entity, LifecycleNode)}


def test_five_life_cycle_nodes_each_the_executable_of_its_package(entities: list[Any]) -> None:
    found = nodes(entities)
    assert sorted(found) == sorted(NODES)
    for package, node in found.items():
        assert node.named["name"] == package
        assert node.named["executable"] == "node"
        scripts = (ROOT / "src" / package / "setup.py").read_text(encoding="utf-8")
        assert f'"node = {package}.node:main"' in scripts
        assert node.named["namespace"].positional == ("namespace",)


def test_parameters_come_from_the_file_and_the_vessel_from_the_argument(entities: list[Any]) -> None:
    for node in nodes(entities).values():
        file, own = node.named["parameters"]
        assert file.positional == ("params_file",)
        assert {name: value.positional for name, value in own.items()} == {"vessel": ("vessel",)}


def test_every_configuration_is_declared_with_a_default_and_a_description(entities: list[Any]) -> None:
    declared = {e.positional[0]: e.named for e in entities if isinstance(e, DeclareLaunchArgument)}
    assert sorted(declared) == ["namespace", "params_file", "simulate", "vessel"]
    assert all(named["description"] for named in declared.values())
    assert declared["vessel"]["default_value"] == "cybership3"
    package, *path = declared["params_file"]["default_value"].positional[0]
    assert package.positional == ("dp_bringup",)
    assert BRINGUP.joinpath(*path).is_file()


def test_only_the_simulator_can_be_left_out(entities: list[Any]) -> None:
    conditions = {package: node.named.get("condition") for package, node in nodes(entities).items()}
    simulator = conditions.pop("vessel_sim")
    assert isinstance(simulator, IfCondition)
    assert simulator.positional[0].positional == ("simulate",)
    assert set(conditions.values()) == {None}


def test_default_parameters_are_parameters_of_the_nodes() -> None:
    """Of the settings of a core, or of the simulator's node; and each core takes its values."""
    settings = default_settings(load_vessel("cybership3"))
    values = read_parameter_file(BRINGUP / "config" / "defaults.yaml")
    assert set(values) <= set(NODES)
    for node, own in values.items():
        of_the_core = {name: value for name, value in own.items() if name in parameters_of(settings[node])}
        with_parameters(settings[node], of_the_core)
        # Of every node, and of the simulator's.
        assert set(own) - set(of_the_core) <= {"input_lease"} | ({"rate"} if node == "vessel_sim" else set()), node


def test_launch_config_and_scenario_files_are_installed() -> None:
    setup = (BRINGUP / "setup.py").read_text(encoding="utf-8")
    for folder, pattern in (
        ("launch", "launch/*.launch.py"),
        ("config", "config/*"),
        ("scenarios", "scenarios/*.yaml"),
    ):
        assert f'(f"share/{{package_name}}/{folder}", glob("{pattern}"))' in setup
        assert sorted(path for path in (BRINGUP / folder).iterdir() if path.is_file()) == sorted(
            path for path in BRINGUP.glob(pattern)
        )
