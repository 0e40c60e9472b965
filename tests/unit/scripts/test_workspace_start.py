"""What happens at every start of the workspace's Python: paths, variables, and the one restart."""

import importlib.metadata
import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[3]
GUARD = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"


@pytest.fixture
def start(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The module, loaded again; with this process marked as already restarted, so that loading it changes nothing."""
    monkeypatch.setenv("_DP_WORKSPACE_RESTARTED_PID", str(os.getpid()))
    spec = importlib.util.spec_from_file_location("start", ROOT / "scripts" / "site" / "dp_workspace.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def venv(tmp_path: Path) -> Path:
    python = "python{}.{}".format(*sys.version_info[:2])
    (tmp_path / ".venv" / "lib" / python / "site-packages" / "ros_rcl.libs").mkdir(parents=True)
    (tmp_path / "install" / "lib").mkdir(parents=True)
    return tmp_path / ".venv"


def test_workspace_stands_before_what_is_there(start: ModuleType, venv: Path) -> None:
    root = venv.parent
    before = {"AMENT_PREFIX_PATH": "/opt/ros/jazzy", "LD_LIBRARY_PATH": "/opt/ros/jazzy/lib"}
    variables = start.workspace_variables(str(root), str(venv), before)
    assert variables["AMENT_PREFIX_PATH"] == f"{root}/install:{venv}:/opt/ros/jazzy"
    folders = variables["LD_LIBRARY_PATH"].split(":")
    assert folders[:2] == [f"{root}/install/lib", f"{venv}/lib"]
    assert folders[2].endswith("site-packages/ros_rcl.libs")
    assert folders[3:] == ["/opt/ros/jazzy/lib"]


def test_variables_of_a_child_stay_as_they_are(start: ModuleType, venv: Path) -> None:
    once = start.workspace_variables(str(venv.parent), str(venv), {})
    assert {**once, **start.workspace_variables(str(venv.parent), str(venv), once)} == once


def test_what_the_user_chose_is_kept(start: ModuleType, venv: Path) -> None:
    chosen = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
        "ROS_LOG_DIR": "/var/log/ros",
        "MPLCONFIGDIR": "/home/user/mpl",
    }
    variables = start.workspace_variables(str(venv.parent), str(venv), chosen)
    assert not variables.keys() & chosen.keys()
    assert start.workspace_variables(str(venv.parent), str(venv), {})["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_restart_only_where_the_loader_lacks_a_folder(start: ModuleType, venv: Path) -> None:
    after = start.workspace_variables(str(venv.parent), str(venv), {})
    assert start.needs_restart({}, after, pid=7)
    assert not start.needs_restart(after, after, pid=7)
    # The guard of the wheels, or of a parent that restarted itself, says nothing about this process.
    assert start.needs_restart({GUARD: "1", "_DP_WORKSPACE_RESTARTED_PID": "6"}, after, pid=7)
    # Never twice, or a loader path that something takes away again would be a loop.
    assert not start.needs_restart({"_DP_WORKSPACE_RESTARTED_PID": "7"}, after, pid=7)


def test_linked_packages_are_found(start: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "marine-model.egg-link").write_text("/checkout/build/marine_model\n.")
    (tmp_path / "other.pth").write_text("/elsewhere\n")
    assert start.linked_folders(str(tmp_path)) == ["/checkout/build/marine_model"]
    assert start.linked_folders(str(tmp_path / "absent")) == []


PROBE = """
import json, os, sys
import rclpy, dp_msgs.msg
print(json.dumps({"argv": sys.argv, "guard": os.environ.get("_ROS_WHEELS_BOOTSTRAP_COMPLETE")}))
"""


@pytest.mark.parametrize(
    "environ",
    [
        pytest.param({}, id="empty environment"),
        pytest.param({GUARD: "1"}, id="guard without library path"),
        pytest.param({GUARD: "1", "_DP_WORKSPACE_RESTARTED_PID": "1"}, id="marks of a parent"),
        pytest.param({"LD_LIBRARY_PATH": "/nowhere"}, id="another library path"),
    ],
)
def test_ros_loads_unsourced_from_any_folder(environ: dict[str, str], tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROBE, "an argument", "--flag"],
        cwd=tmp_path,
        env=environ,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"argv": ["-c", "an argument", "--flag"], "guard": "1"}


def test_standard_input_survives_the_restart() -> None:
    done = subprocess.run(
        [sys.executable, "-"], input="import rclpy; print('read')", env={}, capture_output=True, text=True, check=False
    )
    assert done.stdout == "read\n", done.stderr


def test_locks_hold_what_is_installed() -> None:
    """Every package of the lock is installed in the version it names, unless the lock leaves it to other systems."""
    lock = (ROOT / "locks" / "workspace.txt").read_text()
    pins = [line.split(" \\")[0].split("==") for line in lock.splitlines() if "==" in line and line[0].isalnum()]
    pins = [pin for pin in pins if len(pin) == 2 and ";" not in pin[1]]
    assert len(pins) > 100, "the lock was read"
    assert {name: importlib.metadata.version(name) for name, _ in pins} == dict(pins)
