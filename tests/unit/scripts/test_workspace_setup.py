"""The set-up tool: what it says on a machine that does not fit, and when it has nothing to do."""

import importlib.util
import io
import os
import shutil
import subprocess
import sys
import urllib.error
from email.message import Message
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[3]


def _load() -> ModuleType:
    spec = importlib.util.spec_from_file_location("workspace", ROOT / "scripts" / "workspace.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


workspace = _load()
SetupError = workspace.SetupError


def _message(raised: pytest.ExceptionInfo[Exception]) -> str:
    text = str(raised.value)
    assert "\n" not in text, "one line, not more"
    return text


# A machine that does not fit


@pytest.mark.parametrize(
    ("system", "machine", "named"),
    [
        ("Linux", "aarch64", "aarch64 Linux"),
        ("Darwin", "arm64", "arm64 Darwin"),
        ("Darwin", "x86_64", "x86_64 Darwin"),
        ("", "", "unknown CPU"),
    ],
)
def test_other_machines_are_named_with_the_way_out(system: str, machine: str, named: str) -> None:
    with pytest.raises(SetupError) as raised:
        workspace.check_platform(system, machine, "glibc")
    assert named in _message(raised)
    assert "install ROS 2 Jazzy and run `colcon build`" in _message(raised)


def test_linux_without_glibc_is_refused() -> None:
    with pytest.raises(SetupError, match=r"need glibc, this Linux has another libc; use e\.g\. Debian or Ubuntu"):
        workspace.check_platform("Linux", "x86_64", "")


def test_supported_machine_passes() -> None:
    workspace.check_platform("Linux", "x86_64", "glibc")


@pytest.mark.parametrize("version", [(3, 8, 18), (3, 10, 13), (3, 13, 0), (2, 7, 18)])
def test_other_python_versions_are_refused(version: tuple[int, int, int]) -> None:
    with pytest.raises(SetupError) as raised:
        workspace.check_python("cpython", version)
    assert "needs CPython 3.11 or 3.12, this is cpython {}.{}.{}".format(*version) in _message(raised)
    assert "make PYTHON=" in _message(raised)


@pytest.mark.parametrize("version", [(3, 11, 0), (3, 12, 7)])
def test_supported_python_versions_pass(version: tuple[int, int, int]) -> None:
    workspace.check_python("cpython", version)


def test_another_python_implementation_is_refused() -> None:
    with pytest.raises(SetupError, match="this is pypy"):
        workspace.check_python("pypy", (3, 11, 0))


def test_split_python_names_the_packages_to_install(tmp_path: Path) -> None:
    with pytest.raises(SetupError) as raised:
        workspace.check_python_is_complete((3, 12, 3), lambda name: name != "ensurepip", tmp_path)
    assert "apt-get install python3.12-venv python3.12-dev" in _message(raised)


def test_complete_python_passes(tmp_path: Path) -> None:
    (tmp_path / "Python.h").touch()
    workspace.check_python_is_complete((3, 12, 3), lambda name: True, tmp_path)


@pytest.mark.parametrize(
    ("working", "expected"),
    [
        ([], "no working C and no working C++ compiler"),
        (["gcc"], "no working C++ compiler"),
        (["g++"], "no working C compiler"),
    ],
)
def test_missing_compilers_are_named(working: list[str], expected: str) -> None:
    with pytest.raises(SetupError) as raised:
        workspace.check_compilers({}, lambda command, source: command[0] in working)
    assert expected in _message(raised)
    assert "apt-get install gcc g++" in _message(raised)


def test_compilers_named_in_the_environment_are_the_ones_tried() -> None:
    tried = []

    def run(command: list[str], source: str) -> bool:
        tried.append(command)
        return True

    workspace.check_compilers({"CC": "ccache my-cc", "CXX": "my-c++"}, run)
    check = ["-fsyntax-only", "-"]
    assert tried == [["ccache", "my-cc", "-x", "c", *check], ["my-c++", "-x", "c++", *check]]


def test_compiler_without_its_headers_counts_as_missing(tmp_path: Path) -> None:
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\ncat >/dev/null\nexit 1\n")
    compiler.chmod(0o755)
    with pytest.raises(SetupError, match=r"no working C and no working C\+\+ compiler"):
        workspace.check_compilers({"CC": str(compiler), "CXX": str(compiler)}, workspace._compiles)


@pytest.mark.parametrize(
    "error",
    [urllib.error.URLError("Name or service not known"), TimeoutError("timed out"), ConnectionRefusedError()],
)
def test_no_network_says_so_and_how_to_go_on(error: Exception) -> None:
    def no_network(url: str) -> None:
        raise error

    with pytest.raises(SetupError) as raised:
        workspace.check_network("https://pypi.org/simple", no_network)
    assert "no connection to the package index https://pypi.org/simple" in _message(raised)
    assert "run the same command again" in _message(raised)


@pytest.mark.parametrize(
    "error",
    [
        urllib.error.HTTPError("https://pypi.org", 404, "Not Found", Message(), io.BytesIO()),
        urllib.error.URLError("[SSL: CERTIFICATE_VERIFY_FAILED] self-signed certificate"),
    ],
)
def test_any_answer_is_a_network(error: Exception) -> None:
    def answers(url: str) -> None:
        raise error

    workspace.check_network("https://pypi.org/simple", answers)


# When there is something to do


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout with one Python package and one interface package."""
    root = tmp_path / "checkout"
    for name, content in {
        "locks/workspace.txt": "uv==1.0 \\\n    --hash=sha256:aa\n",
        "locks/bench.txt": "pandas==3.0\n",
        "scripts/workspace.py": "tool",
        "scripts/site/dp_workspace.py": "module",
        "scripts/site/dp_workspace.pth": "import dp_workspace",
        "colcon.meta": "{}",
        "msgs/package.xml": "<package/>",
        "msgs/msg/State.msg": "float64 x",
        "src/pilot/package.xml": "<package/>",
        "src/pilot/setup.py": "setup()",
        "src/pilot/pilot/__init__.py": "",
        "src/pilot/pilot/core.py": "x = 1",
        "src/pilot/config/pilot.yaml": "gain: 1",
    }.items():
        file = root / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content)
    return root


def test_packages_are_discovered(checkout: Path) -> None:
    assert [package.name for package in workspace.find_packages(checkout)] == ["msgs", "pilot"]


@pytest.mark.parametrize(
    ("file", "rebuilds"),
    [
        ("msgs/msg/State.msg", True),
        ("msgs/msg/Other.msg", True),
        ("src/pilot/setup.py", True),
        ("src/pilot/package.xml", True),
        ("src/pilot/config/other.yaml", True),
        ("src/pilot/launch/pilot.launch.py", True),
        ("src/helm/package.xml", True),
        ("colcon.meta", True),
        # Linked to the source, so an edit is live without a build.
        ("src/pilot/pilot/core.py", False),
        ("src/pilot/pilot/new_module.py", False),
        ("src/pilot/config/pilot.yaml", False),
        # Made by running, not by writing.
        ("src/pilot/pilot/__pycache__/core.cpython-311.pyc", False),
        ("src/pilot/pilot.egg-info/PKG-INFO", False),
        ("README.md", False),
    ],
)
def test_only_what_the_build_reads_calls_for_a_build(checkout: Path, file: str, rebuilds: bool) -> None:
    before = workspace.build_key(checkout, "environment")
    path = checkout / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("changed")
    assert (workspace.build_key(checkout, "environment") != before) == rebuilds


@pytest.mark.parametrize("file", ["locks/workspace.txt", "scripts/workspace.py", "scripts/site/dp_workspace.py"])
def test_a_new_lock_or_tool_calls_for_a_new_environment(checkout: Path, file: str) -> None:
    before = workspace.environment_key(checkout, "3.11.7 /usr/bin/python3.11")
    (checkout / file).write_text("changed")
    assert workspace.environment_key(checkout, "3.11.7 /usr/bin/python3.11") != before


def test_another_python_or_place_calls_for_a_new_environment(checkout: Path, tmp_path: Path) -> None:
    moved = tmp_path / "moved"
    shutil.copytree(checkout, moved)
    keys = {
        workspace.environment_key(checkout, "3.11.7 /usr/bin/python3.11"),
        workspace.environment_key(checkout, "3.12.1 /usr/bin/python3.12"),
        workspace.environment_key(moved, "3.11.7 /usr/bin/python3.11"),
    }
    assert len(keys) == 3


class _Recorder(workspace.Workspace):  # type: ignore[misc, name-defined, unused-ignore]
    """The real order of stages and stamps, with the slow stages noted instead of run."""

    def __init__(self, root: Path, fail_in: str = "") -> None:
        super().__init__(root, {"PATH": os.environ["PATH"]}, lambda line: None)
        self.stages: list[str] = []
        self.fail_in = fail_in

    def _stage(self, name: str) -> None:
        if name == self.fail_in:
            raise SetupError(f"{name} failed")
        self.stages.append(name)

    def _make_venv(self, python: str) -> None:
        if self.venv.exists():
            shutil.rmtree(self.venv)
        self.venv_python.parent.mkdir(parents=True)
        self.venv_python.touch()

    def _install_packages(self) -> None:
        self._stage("packages")

    def _install_bench_packages(self) -> None:
        self._stage("bench")

    def _fit_packages(self) -> None:
        self._stage("fit")

    def _run(self, command: list[str], failed: str, show: object = None) -> None:
        self._stage("build")
        (self.root / "install").mkdir(exist_ok=True)


def _stages(checkout: Path, *, bench: bool = False, fail_in: str = "") -> list[str]:
    recorder = _Recorder(checkout, fail_in)
    try:
        recorder.set_up(bench, lambda: recorder.stages.append("checks"))
    except SetupError:
        recorder.stages.append("error")
    return recorder.stages


def test_second_set_up_does_nothing(checkout: Path) -> None:
    assert _stages(checkout) == ["checks", "packages", "fit", "build"]
    assert _stages(checkout) == []


def test_a_changed_package_is_built_and_nothing_installed(checkout: Path) -> None:
    _stages(checkout)
    (checkout / "src/pilot/setup.py").write_text("setup(version=2)")
    assert _stages(checkout) == ["build"]


def test_bench_packages_come_on_top_and_stay(checkout: Path) -> None:
    _stages(checkout)
    assert _stages(checkout, bench=True) == ["checks", "bench"]
    assert _stages(checkout, bench=True) == []
    assert _stages(checkout) == []


@pytest.mark.parametrize(
    ("fail_in", "next_time"),
    [
        ("packages", ["checks", "packages", "fit", "build"]),
        ("fit", ["checks", "packages", "fit", "build"]),
        ("build", ["build"]),
    ],
)
def test_set_up_goes_on_after_a_failure(checkout: Path, fail_in: str, next_time: list[str]) -> None:
    assert _stages(checkout, fail_in=fail_in)[-1] == "error"
    assert _stages(checkout) == next_time
    assert _stages(checkout) == []


def test_failed_checks_leave_nothing_behind(checkout: Path) -> None:
    before = sorted(checkout.rglob("*"))

    def refuse() -> None:
        raise SetupError("no working C compiler")

    with pytest.raises(SetupError):
        _Recorder(checkout).set_up(False, refuse)
    assert sorted(checkout.rglob("*")) == before


def test_a_removed_package_leaves_no_build_products(checkout: Path) -> None:
    _stages(checkout)
    (checkout / "install/lib").mkdir()
    shutil.rmtree(checkout / "src/pilot")
    assert _stages(checkout) == ["build"]
    assert not (checkout / "install/lib").exists()


def test_damaged_stamp_counts_as_none(tmp_path: Path) -> None:
    stamp = tmp_path / "stamp.json"
    stamp.write_text('{"key": ')
    assert workspace.read_stamp(stamp) == {}


def test_foreign_ros_environment_is_kept_out_of_the_build(checkout: Path) -> None:
    environ = {
        "PATH": "/opt/ros/jazzy/bin:/usr/bin",
        "LD_LIBRARY_PATH": "/opt/ros/jazzy/lib:/usr/local/lib",
        "AMENT_PREFIX_PATH": "/opt/ros/jazzy",
        "PYTHONPATH": "/opt/ros/jazzy/lib/python3.12/site-packages",
        "ROS_DISTRO": "jazzy",
        "COLCON_LOG_LEVEL": "10",
        "HTTPS_PROXY": "http://proxy:3128",
    }
    clean = workspace.Workspace(checkout, environ, print).environ
    assert not [name for name, value in clean.items() if "/opt/ros" in value]
    assert clean["LD_LIBRARY_PATH"] == "/usr/local/lib"
    assert clean["HTTPS_PROXY"] == "http://proxy:3128"
    assert clean["PATH"].split(":")[1:] == ["/usr/bin"]


def test_caches_stay_in_the_checkout(checkout: Path) -> None:
    clean = workspace.Workspace(checkout, {"HOME": "/home/user", "PATH": "/usr/bin"}, print).environ
    for name in ("UV_CACHE_DIR", "COLCON_HOME", "COLCON_LOG_PATH"):
        assert Path(clean[name]).is_relative_to(checkout)


# The wheels and the lock


def test_cmake_files_get_this_machines_folders(tmp_path: Path) -> None:
    wheel = tmp_path / "cache.cmake"
    wheel.write_text(
        'INTERFACE_INCLUDE_DIRECTORIES "/opt/python/cp311-cp311/include/python3.11;'
        '/opt/python/cp311-cp311/lib/python3.11/site-packages/numpy/_core/include"\n'
    )
    share = tmp_path / "share" / "std_msgs" / "cmake"
    share.mkdir(parents=True)
    linked = share / "export.cmake"
    os.link(wheel, linked)
    assert workspace.patch_cmake_files(tmp_path / "share", "/usr/include/python3.11", r"/home/a\1/numpy/include") == 1
    assert linked.read_text() == 'INTERFACE_INCLUDE_DIRECTORIES "/usr/include/python3.11;/home/a\\1/numpy/include"\n'
    assert "/opt/python" in wheel.read_text(), "the installer's cache is left as it was"
    assert workspace.patch_cmake_files(tmp_path / "share", "/usr/include/python3.11", r"/home/a\1/numpy/include") == 0


def test_one_requirement_is_cut_out_of_the_lock() -> None:
    lock = "uvloop==2.0 \\\n    --hash=sha256:00\n"
    lock += "uv==1.0 \\\n    --hash=sha256:aa \\\n    --hash=sha256:bb\n    # via group\nwheel==3\n"
    assert (
        workspace.locked_requirement(lock, "uv")
        == "uv==1.0 \\\n    --hash=sha256:aa \\\n    --hash=sha256:bb\n    # via group\n"
    )
    with pytest.raises(SetupError, match="does not name cmake; run `make lock`"):
        workspace.locked_requirement(lock, "cmake")


# The choice of a Python (scripts/setup.sh)


def _fake_python(folder: Path, name: str, *, fits: bool = True, complete: bool = True, starts: bool = True) -> None:
    """A program that answers the probes like a Python would, and says its name when handed over to."""
    script = f"""#!/bin/sh
case "$*" in
*workspace.py*) echo "chosen: {name}" ;;
*version_info*) exit {0 if starts and fits else 1} ;;
*ensurepip*) exit {0 if starts and complete else 1} ;;
*) exit {0 if starts else 127} ;;
esac
"""
    file = folder / name
    file.write_text(script)
    file.chmod(0o755)


def _choose(tmp_path: Path, **environ: str) -> subprocess.CompletedProcess[str]:
    scripts = tmp_path / "checkout" / "scripts"
    scripts.mkdir(parents=True)
    shutil.copy(ROOT / "scripts" / "setup.sh", scripts)
    for tool in ("sh", "dirname"):
        found = shutil.which(tool)
        assert found
        (tmp_path / "bin" / tool).symlink_to(found)
    return subprocess.run(
        [shutil.which("sh") or "sh", str(scripts / "setup.sh"), "setup"],
        env={"PATH": str(tmp_path / "bin"), **environ},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def programs(tmp_path: Path) -> Path:
    folder = tmp_path / "bin"
    folder.mkdir()
    return folder


def test_a_shim_that_does_not_start_is_passed_over(programs: Path, tmp_path: Path) -> None:
    _fake_python(programs, "python3.12", starts=False)
    _fake_python(programs, "python3.11")
    assert _choose(tmp_path).stdout == "chosen: python3.11\n"


def test_an_incomplete_python_is_the_last_choice(programs: Path, tmp_path: Path) -> None:
    _fake_python(programs, "python3.12", complete=False)
    _fake_python(programs, "python3")
    assert _choose(tmp_path).stdout == "chosen: python3\n"


def test_the_only_python_is_handed_over_to_though_incomplete(programs: Path, tmp_path: Path) -> None:
    _fake_python(programs, "python3.11", complete=False)
    assert _choose(tmp_path).stdout == "chosen: python3.11\n"


def test_no_fitting_python_is_one_line(programs: Path, tmp_path: Path) -> None:
    _fake_python(programs, "python3", fits=False)
    result = _choose(tmp_path)
    assert result.returncode == 1
    assert result.stderr.count("\n") == 1
    assert "needs Python 3.11 or 3.12" in result.stderr
    assert "apt-get install" in result.stderr


def test_the_named_python_is_taken(programs: Path, tmp_path: Path) -> None:
    _fake_python(programs, "python3.12")
    _fake_python(programs, "my-python", fits=False)
    assert _choose(tmp_path, PYTHON="my-python").stdout == "chosen: my-python\n"


def test_a_named_python_that_does_not_run_is_one_line(programs: Path, tmp_path: Path) -> None:
    result = _choose(tmp_path, PYTHON="python9")
    assert result.returncode == 1
    assert result.stderr.startswith("setup: PYTHON=python9 does not run")
    assert result.stderr.count("\n") == 1


def test_the_tool_itself_refuses_in_one_line_and_touches_nothing(tmp_path: Path) -> None:
    checkout = tmp_path / "checkout"
    shutil.copytree(ROOT / "scripts", checkout / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "locks", checkout / "locks")
    shutil.copytree(ROOT / "msgs", checkout / "msgs")
    before = sorted(checkout.rglob("*"))
    python = getattr(sys, "_base_executable", sys.executable)
    result = subprocess.run(
        [python, "-I", "-S", "-B", str(checkout / "scripts" / "workspace.py"), "setup"],
        env={"PATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 1
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert "no working C and no working C++ compiler; install one" in result.stderr
    assert sorted(checkout.rglob("*")) == before
