"""The arrows of the house: who may import whom. Packages are found, not listed."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import pytest

SOURCE = Path(__file__).parents[2] / "src"
VOCABULARY, MESSAGES, SCAFFOLDING, BRINGUP, TOOLS = "marine_model", "dp_msgs", "dp_node", "dp_bringup", "dp_tools"
ROS = re.compile(r"rclpy|rosidl\w*|ament\w*|launch\w*|rosbags|\w+_msgs|\w+_interfaces")


@dataclass(frozen=True)
class Module:
    package: str
    path: Path

    @property
    def name(self) -> str:
        parts = self.path.relative_to(SOURCE / self.package).with_suffix("").parts
        return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)

    @property
    def is_node(self) -> bool:
        return self.path.name == "node.py" or self.path.name.startswith("node_")

    @property
    def tree(self) -> ast.Module:
        return ast.parse(self.path.read_text(encoding="utf-8"))

    def imports(self) -> set[str]:
        """Full names of all modules it imports anywhere, in functions and for type checking too."""
        found: set[str] = set()
        for item in ast.walk(self.tree):
            if isinstance(item, ast.Import):
                found |= {alias.name for alias in item.names}
            elif isinstance(item, ast.ImportFrom):
                assert item.level == 0, f"{self.path}: relative import"
                assert item.module is not None
                found |= {item.module} | {f"{item.module}.{alias.name}" for alias in item.names}
        return found

    def packages(self) -> set[str]:
        return {name.partition(".")[0] for name in self.imports()}


PACKAGES = sorted(path.parent.name for path in SOURCE.glob("*/package.xml"))
MODULES = [
    Module(package, path)
    for package in PACKAGES
    for path in sorted((SOURCE / package / package).rglob("*.py"))
    if "__pycache__" not in path.parts
]
CORES = [package for package in PACKAGES if package not in (SCAFFOLDING, BRINGUP, TOOLS)]
CORE_MODULES = [module for module in MODULES if module.package in CORES and not module.is_node]
NODE_MODULES = [module for module in MODULES if module.package in CORES and module.is_node]
OURS = {*PACKAGES, MESSAGES}


def by_name(modules: list[Module]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("module", modules, ids=lambda module: module.name)


def test_something_was_found() -> None:
    assert {VOCABULARY, SCAFFOLDING, TOOLS} < set(PACKAGES)
    assert len({module.package for module in NODE_MODULES}) >= 3
    assert len(CORE_MODULES) > len(NODE_MODULES)


@by_name(CORE_MODULES)
def test_cores_import_the_vocabulary_only_and_no_ros(module: Module) -> None:
    assert (module.packages() & OURS) - {module.package, VOCABULARY} == set()
    assert {package for package in module.packages() if ROS.fullmatch(package)} == set()


def test_the_vocabulary_imports_nothing_of_ours() -> None:
    for module in MODULES:
        if module.package == VOCABULARY:
            assert module.packages() & OURS <= {VOCABULARY}, module.name


@by_name(NODE_MODULES)
def test_nodes_import_their_own_core_messages_and_scaffolding(module: Module) -> None:
    assert module.packages() & OURS <= {module.package, VOCABULARY, MESSAGES, SCAFFOLDING}


def test_the_scaffolding_knows_the_vocabulary_and_messages_only() -> None:
    for module in MODULES:
        if module.package == SCAFFOLDING:
            assert module.packages() & OURS <= {SCAFFOLDING, VOCABULARY, MESSAGES}, module.name


def test_bringing_up_knows_the_scaffolding_and_no_core() -> None:
    for module in MODULES:
        if module.package == BRINGUP:
            assert module.packages() & OURS <= {BRINGUP, SCAFFOLDING, VOCABULARY, MESSAGES}, module.name


def test_only_the_tools_know_of_bringing_up() -> None:
    for module in MODULES:
        if module.package not in (BRINGUP, TOOLS):
            assert BRINGUP not in module.packages(), module.name


def test_nobody_imports_the_tools_or_a_node() -> None:
    nodes = {module.name for module in NODE_MODULES}
    for module in MODULES:
        if module.package != TOOLS:
            assert TOOLS not in module.packages(), module.name
        if not module.is_node:
            assert module.imports() & nodes == set(), module.name


# What a core may not touch: time comes in as dt, and what it knows of the world comes in as arguments. The vocabulary
# reads vessel files; that is what it is for.
WORLD = {"asyncio", "datetime", "io", "logging", "os", "pathlib", "random", "shutil", "signal", "socket", "subprocess"}
WORLD |= {"tempfile", "threading"}
PURE = [module for module in CORE_MODULES if module.package != VOCABULARY]


@by_name(PURE)
def test_cores_touch_no_clock_file_or_thread(module: Module) -> None:
    assert module.packages() & WORLD == set()
    for item in ast.walk(module.tree):
        if isinstance(item, ast.Call) and isinstance(item.func, ast.Name):
            assert item.func.id not in ("open", "print", "input"), f"{module.path}:{item.lineno}"
        # A solver may time itself: the figure is reported and decides nothing.
        if isinstance(item, ast.Attribute) and isinstance(item.value, ast.Name) and item.value.id == "time":
            assert "time" not in module.packages() or item.attr == "perf_counter", f"{module.path}:{item.lineno}"


BLOCKER = """
import importlib, importlib.abc, re, sys
class Blocker(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if re.fullmatch(sys.argv[1], name.partition(".")[0]):
            raise ImportError(f"blocked: {name}")
sys.meta_path.insert(0, Blocker())
for name in ("rclpy", "std_msgs.msg", sys.argv[2]):
    try:
        importlib.import_module(name)
    except ImportError as error:
        assert "blocked" in str(error), error
    else:
        sys.exit(f"{name} was not blocked")
sys.path[:0] = sys.argv[3].split(":")
for name in sys.argv[4:]:
    importlib.import_module(name)
"""


@pytest.mark.parametrize("package", [package for package in CORES if (SOURCE / package / package).is_dir()])
def test_cores_run_without_ros(package: str) -> None:
    """Every core module is imported in a process that has no ROS and none of our node packages."""
    blocked = f"{ROS.pattern}|{SCAFFOLDING}|{TOOLS}"
    paths = ":".join(str(SOURCE / name) for name in {package, VOCABULARY})
    names = [module.name for module in CORE_MODULES if module.package == package]
    answer = subprocess.run(
        [sys.executable, "-c", BLOCKER, blocked, SCAFFOLDING, paths, *names],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr


LIGHT = """
import sys
import dp_controller, dp_observer
from marine_model import load_vessel
load_vessel("cybership3").propellers
print(*sorted({"numba", "scipy"} & set(sys.modules)))
"""


def test_observer_and_controller_load_no_compiler() -> None:
    """Each is a process of its own, and a compiler and SciPy that it never uses would cost it 50 MB."""
    answer = subprocess.run(
        [sys.executable, "-c", LIGHT],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
        env={
            **os.environ,
            "PYTHONPATH": ":".join(str(SOURCE / name) for name in (VOCABULARY, "dp_observer", "dp_controller")),
        },
    )
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.strip() == ""


# Names that rosdep has for what we import from PyPI; others come with the project's lock file.
ROSDEP = {
    "matplotlib": "python3-matplotlib",
    "numpy": "python3-numpy",
    "psutil": "python3-psutil",
    "pydantic": "python3-pydantic",
    "scipy": "python3-scipy",
    "yaml": "python3-yaml",
}


@pytest.mark.parametrize("package", PACKAGES)
def test_package_xml_names_what_is_imported(package: str) -> None:
    root = ElementTree.parse(SOURCE / package / "package.xml").getroot()
    kinds = ("depend", "exec_depend", "build_depend")
    declared = {item.text for kind in kinds for item in root.findall(kind)}
    imported = {name for module in MODULES if module.package == package for name in module.packages()} - {package}
    needed = {name for name in imported if name in OURS or (ROS.fullmatch(name) and name != "rosbags")}
    needed |= {ROSDEP[name] for name in imported if name in ROSDEP}
    assert needed - declared == set()
    assert root.findtext("license") == "Apache-2.0"
    assert root.get("format") == "3"
