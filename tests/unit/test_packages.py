"""Every package says the same of itself in package.xml, setup.py and setup.cfg, and needs what it imports."""

from __future__ import annotations

import ast
import configparser
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from support.repository import ROOT

PYTHON_PACKAGES = sorted(path.parent for path in ROOT.glob("src/*/package.xml"))
ALL_PACKAGES = [ROOT / "msgs", *PYTHON_PACKAGES]
NODE_PACKAGES = [
    path for path in PYTHON_PACKAGES if (path / path.name / "node.py").is_file() and path.name != "dp_node"
]

every_package = pytest.mark.parametrize("package", ALL_PACKAGES, ids=lambda path: path.name)
python_packages = pytest.mark.parametrize("package", PYTHON_PACKAGES, ids=lambda path: path.name)

# Runs a setup.py without doing anything, and prints what it told setuptools.
PROBE = """
import json, sys, setuptools
told = {}
setuptools.setup = lambda **words: told.update(words)
sys.argv = ["setup.py"]
exec(compile(open("setup.py").read(), "setup.py", "exec"))
print(json.dumps(told))
"""


@cache
def manifest(package: Path) -> ElementTree.Element:
    return ElementTree.parse(package / "package.xml").getroot()


@cache
def told_to_setuptools(package: Path) -> dict[str, Any]:
    import json

    done = subprocess.run([sys.executable, "-c", PROBE], cwd=package, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def text(package: Path, tag: str) -> str:
    found = manifest(package).findtext(tag)
    assert found is not None, tag
    return found.strip()


def test_the_packages_are_found() -> None:
    assert len(PYTHON_PACKAGES) == 9
    assert {path.name for path in NODE_PACKAGES} == {
        *("vessel_sim", "dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers")
    }


@every_package
def test_package_xml(package: Path) -> None:
    assert manifest(package).get("format") == "3"
    assert text(package, "name") == ("dp_msgs" if package.name == "msgs" else package.name)
    assert text(package, "version") == text(PYTHON_PACKAGES[0], "version")
    assert re.fullmatch(r"\d+\.\d+\.\d+", text(package, "version"))
    assert text(package, "license") == "Apache-2.0"
    assert len(text(package, "description")) > 20
    assert "@" in (manifest(package).find("maintainer") or manifest(package).findall("maintainer")[0]).get("email", "")
    build_type = manifest(package).findtext("export/build_type")
    assert build_type == ("ament_cmake" if package.name == "msgs" else "ament_python")


def test_every_package_describes_itself() -> None:
    descriptions = [text(package, "description") for package in ALL_PACKAGES]
    assert len(set(descriptions)) == len(descriptions)


@python_packages
def test_setup_py_agrees_with_package_xml(package: Path) -> None:
    told = told_to_setuptools(package)
    assert told["name"] == text(package, "name")
    assert told["version"] == text(package, "version")
    assert told["license"] == text(package, "license")
    files = {folder: list(names) for folder, names in told["data_files"]}
    assert files["share/ament_index/resource_index/packages"] == [f"resource/{package.name}"]
    assert (package / "resource" / package.name).is_file()
    assert files[f"share/{package.name}"] == ["package.xml"]


@python_packages
def test_executables_go_where_ros2_run_looks(package: Path) -> None:
    config = configparser.ConfigParser()
    config.read(package / "setup.cfg")
    assert config["develop"]["script_dir"] == f"$base/lib/{package.name}"
    assert config["install"]["install_scripts"] == f"$base/lib/{package.name}"
    scripts = told_to_setuptools(package).get("entry_points", {}).get("console_scripts", [])
    entries = dict(re.split(r"\s*=\s*", script) for script in scripts)
    if package in NODE_PACKAGES:
        assert entries == {"node": f"{package.name}.node:main"}
    for target in entries.values():
        module, _, function = target.partition(":")
        tree = ast.parse((package / Path(*module.split("."))).with_suffix(".py").read_text(encoding="utf-8"))
        names = {item.name for item in tree.body if isinstance(item, ast.FunctionDef)}
        names |= {a.asname or a.name for item in tree.body if isinstance(item, ast.ImportFrom) for a in item.names}
        assert function in names, target


@python_packages
def test_type_information_is_installed(package: Path) -> None:
    told = told_to_setuptools(package)
    if not (package / package.name).is_dir():  # files only
        assert told["packages"] == []
        return
    assert (package / package.name / "py.typed").is_file()
    assert "py.typed" in told["package_data"][package.name]
    on_disk = {".".join(p.parent.relative_to(package).parts) for p in (package / package.name).rglob("__init__.py")}
    assert set(told["packages"]) == on_disk


@python_packages
def test_every_ros_package_that_is_imported_is_named_as_a_dependency(package: Path) -> None:
    ours = {path.name for path in PYTHON_PACKAGES} | {"dp_msgs"}
    imported: set[str] = set()
    for path in (package / package.name).rglob("*.py"):
        for item in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(item, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in item.names}
            elif isinstance(item, ast.ImportFrom) and item.module:
                imported.add(item.module.partition(".")[0])
    ros = {
        name
        for name in imported
        if name in ours or re.fullmatch(r"rclpy|ament_index_python|\w+_(msgs|interfaces)", name)
    }
    named = {item.text for tag in ("exec_depend", "depend") for item in manifest(package).iter(tag)}
    assert ros - {package.name} <= named
