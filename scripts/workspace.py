"""Sets the workspace up: virtual environment, pinned packages, ROS 2 wheels made usable, colcon build.

Run through scripts/setup.sh, which chooses the Python. Standard library only, and written for Python 3.8 upwards, so
that an old Python can say that it is old.

    setup           bring .venv and install/ up to date; does nothing if they are
    setup --bench   the same, with the packages that only `make bench` needs
    lock            write locks/ from the dependency groups in pyproject.toml
    clean           remove what the build made;  distclean: also .venv and the caches
"""

import argparse
import contextlib
import hashlib
import importlib.util
import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import time
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

ROOT = Path(__file__).resolve().parent.parent
DEFAULT_INDEX = "https://pypi.org/simple"
LOCKED_GROUPS = ("runtime", "ros", "build", "test", "lint")
OLDEST_PYTHON = (3, 11)
NEWEST_PYTHON = (3, 12)
# Packages with inner loops that are compiled, by `python -m dp_tools.machine_code`.
COMPILED = ("src/thrust_allocator/thrust_allocator", "src/vessel_sim/vessel_sim", "src/marine_model/marine_model")
INSTALL_FAILED = "could not install the pinned packages (network lost, or disk full?)"


class SetupError(Exception):
    """Set-up cannot go on. The message is one line that says what to install or do instead."""


# Checks before anything is written. Each takes what it judges as arguments, so that a test can play any machine.


def check_platform(system: str, machine: str, libc: str) -> None:
    """The ROS 2 wheels are compiled for x86-64 Linux with glibc."""
    if system != "Linux" or machine not in ("x86_64", "amd64", "AMD64"):
        raise SetupError(
            "the ROS 2 Jazzy wheels on PyPI are for x86-64 Linux, this machine is {} {}; use such a machine, "
            "or install ROS 2 Jazzy and run `colcon build`".format(
                machine or "an unknown CPU", system or "(unknown system)"
            )
        )
    if libc != "glibc":
        raise SetupError(
            "the ROS 2 Jazzy wheels on PyPI need glibc, this Linux has {}; use e.g. Debian or Ubuntu".format(
                libc or "another libc"
            )
        )


def check_python(implementation: str, version: Tuple[int, ...]) -> None:
    if implementation != "cpython" or not OLDEST_PYTHON <= tuple(version[:2]) <= NEWEST_PYTHON:
        raise SetupError(
            "needs CPython 3.11 or 3.12, this is {} {}; "
            "install one and name it: make PYTHON=/path/to/python3.12 setup".format(
                implementation, ".".join(map(str, version[:3]))
            )
        )


def check_python_is_complete(version: Tuple[int, ...], has_module: Callable[[str], bool], include: Path) -> None:
    """Distributions split Python up: the modules that make a virtual environment and the C headers may be missing."""
    name = "python{}.{}".format(*version[:2])
    missing = ["{}-venv".format(name)] if not (has_module("venv") and has_module("ensurepip")) else []
    if not (include / "Python.h").is_file():
        missing.append("{}-dev".format(name))
    if missing:
        raise SetupError(
            "this Python lacks parts that set-up needs; install them, e.g. apt-get install {}".format(" ".join(missing))
        )


def check_compilers(environ: Mapping[str, str], run: Callable[[List[str], str], bool]) -> None:
    """The message package is compiled: both compilers must be there and find their standard headers."""
    missing = []
    for variable, default, language, header in (
        ("CC", "cc gcc clang", "c", "stdio.h"),
        ("CXX", "c++ g++ clang++", "c++", "vector"),
    ):
        commands = [shlex.split(environ[variable])] if environ.get(variable) else [[name] for name in default.split()]
        source = "#include <{}>\n".format(header)
        if not any(run(command + ["-x", language, "-fsyntax-only", "-"], source) for command in commands):
            missing.append("C" if language == "c" else "C++")
    if missing:
        raise SetupError(
            "no working {} compiler; install one, e.g. apt-get install gcc g++".format(" and no working ".join(missing))
        )


def check_network(index: str, open_url: Callable[[str], Any]) -> None:
    """Any answer will do, also an error page or a certificate that only pip is configured to trust."""
    try:
        open_url(index)
    except urllib.error.HTTPError:
        return
    except (OSError, ValueError) as error:
        if "CERTIFICATE" in str(error).upper():
            return
        raise SetupError(
            "no connection to the package index {}; connect to a network (or set HTTPS_PROXY or PIP_INDEX_URL) "
            "and run the same command again".format(index)
        ) from error


# What set-up depends on, as a hash. Nothing changed means nothing to do.


def _digest(parts: Sequence[Tuple[str, bytes]]) -> str:
    digest = hashlib.sha256()
    for name, content in parts:
        digest.update("{}\0{}\0".format(name, len(content)).encode())
        digest.update(content)
    return digest.hexdigest()


def environment_key(root: Path, python: str) -> str:
    """Changes when .venv has to be made anew: lock, this tool, the Python, the place of the checkout."""
    files = [
        root / "locks" / "workspace.txt",
        root / "scripts" / "workspace.py",
        *sorted((root / "scripts" / "site").glob("dp_workspace.*")),
    ]
    parts = [(str(file.relative_to(root)), file.read_bytes()) for file in files]
    return _digest(parts + [("python", python.encode()), ("root", str(root).encode())])


def bench_key(root: Path, environment: str) -> str:
    """Changes when the benchmarks' own packages have to be installed."""
    return _digest([("environment", environment.encode()), ("bench", (root / "locks" / "bench.txt").read_bytes())])


def find_packages(root: Path) -> List[Path]:
    """The folders of the ROS packages of the workspace: msgs and those in src."""
    manifests = [root / "msgs" / "package.xml", *sorted((root / "src").glob("*/package.xml"))]
    return [manifest.parent for manifest in manifests if manifest.is_file()]


def _package_parts(root: Path, package: Path) -> Iterator[Tuple[str, bytes]]:
    """What of a package the build has to be told about.

    Python modules are not: installed packages link to the source. Other files are linked as well, but one by one, so
    their names count; build files and interface definitions count with their content.
    """
    for folder, folders, names in os.walk(str(package)):
        folders[:] = sorted(name for name in folders if name != "__pycache__" and not name.endswith(".egg-info"))
        here = Path(folder)
        in_module = package / package.name in (here, *here.parents)
        for name in sorted(names):
            file = here / name
            built = name in ("package.xml", "setup.py", "setup.cfg", "CMakeLists.txt") or file.suffix in (
                ".msg",
                ".srv",
                ".action",
            )
            if built:
                yield str(file.relative_to(root)), file.read_bytes()
            elif not (in_module and file.suffix in (".py", ".pyi", ".pyc")):
                yield str(file.relative_to(root)), b""


def build_key(root: Path, environment: str) -> str:
    """Changes when colcon has to run."""
    parts = [("environment", environment.encode())]
    if (root / "colcon.meta").is_file():
        parts.append(("colcon.meta", (root / "colcon.meta").read_bytes()))
    for package in find_packages(root):
        parts.extend(_package_parts(root, package))
    return _digest(parts)


def machine_code_key(root: Path, environment: str) -> str:
    """Changes when the inner loops have to be compiled anew; empty where there are none."""
    if not (root / COMPILED[0]).is_dir():
        return ""
    parts = [("environment", environment.encode())]
    for folder in COMPILED:
        parts.extend((str(file.relative_to(root)), file.read_bytes()) for file in sorted((root / folder).rglob("*.py")))
    return _digest(parts)


def read_stamp(path: Path) -> Dict[str, Any]:
    """What was written by `write_stamp`, or nothing if it is not there or not readable."""
    try:
        stamp = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def write_stamp(path: Path, stamp: Mapping[str, Any]) -> None:
    """Last act of a stage. Written beside and renamed, so that a stamp is whole or absent."""
    beside = path.with_name(path.name + ".new")
    beside.write_text(json.dumps(stamp, indent=1) + "\n", encoding="utf-8")
    os.replace(str(beside), str(path))


# The wheels' CMake files


def patch_cmake_text(text: str, python_include: str, numpy_include: str) -> str:
    """Puts this machine's include folders where the machine that built the wheels left its own."""
    text = re.sub(r'[^";\s]*/site-packages/numpy/_?core/include', lambda _: numpy_include, text)
    return re.sub(r"/opt/python/cp3\d+-cp3\d+/include/python3\.\d+", lambda _: python_include, text)


def patch_cmake_files(share: Path, python_include: str, numpy_include: str) -> int:
    """Patches every file below `share`; returns how many changed.

    A file is replaced, not written into: the installer may have hard-linked it to its cache.
    """
    changed = 0
    for file in sorted(share.rglob("*.cmake")):
        text = file.read_text(encoding="utf-8")
        patched = patch_cmake_text(text, python_include, numpy_include)
        if patched != text:
            beside = file.with_name(file.name + ".new")
            beside.write_text(patched, encoding="utf-8")
            os.replace(str(beside), str(file))
            changed += 1
    return changed


def count_locked(lock: str) -> int:
    """How many packages a lock file names."""
    return len(re.findall(r"^[a-z0-9][^=\n]*==", lock, re.MULTILINE))


def locked_requirement(lock: str, name: str) -> str:
    """The entry of one package in a lock file, with its hashes."""
    match = re.search(r"^{}==.*?(?=^\S|\Z)".format(re.escape(name)), lock, re.MULTILINE | re.DOTALL)
    if not match:
        raise SetupError("locks/workspace.txt does not name {}; run `make lock`".format(name))
    return match.group()


class Workspace:
    """The checkout at `root` and the steps that bring it up to date."""

    def __init__(self, root: Path, environ: Mapping[str, str], say: Callable[[str], None]) -> None:
        self.root = root
        self.venv = root / ".venv"
        self.venv_python = self.venv / "bin" / "python"
        self.cache = root / ".cache"
        self.log = root / "log" / "setup.log"
        self.say = say
        self.environ = self._clean_environment(environ)
        self.step_count = 0

    def _clean_environment(self, environ: Mapping[str, str]) -> Dict[str, str]:
        """The user's variables without those of another ROS or Python, and with every cache inside the checkout."""
        foreign = (
            "AMENT_",
            "COLCON_",
            "ROS_",
            "CMAKE_PREFIX_PATH",
            "PYTHON",
            "VIRTUAL_ENV",
            "_ROS_WHEELS_",
            "_DP_WORKSPACE_",
            "PIP_TARGET",
            "PIP_PREFIX",
        )
        cleaned = {name: value for name, value in environ.items() if not name.startswith(foreign)}
        prefixes = environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
        for name in ("LD_LIBRARY_PATH", "PATH"):
            kept = [
                e
                for e in cleaned.get(name, "").split(os.pathsep)
                if e and not any(p and e.startswith(p + os.sep) for p in prefixes)
            ]
            cleaned[name] = os.pathsep.join(kept)
        cleaned["PATH"] = os.pathsep.join([str(self.venv / "bin"), cleaned["PATH"]])
        cleaned.update(
            {
                "VIRTUAL_ENV": str(self.venv),
                "AMENT_PREFIX_PATH": str(self.venv),
                "CMAKE_PREFIX_PATH": str(self.venv),
                "CMAKE_GENERATOR": "Ninja",
                # Says nothing to Ninja; keeps colcon from passing it a load limit, which on a busy machine means one
                # job at a time.
                "MAKEFLAGS": "-j{}".format(os.cpu_count() or 1),
                "COLCON_HOME": str(self.cache / "colcon"),
                "COLCON_LOG_PATH": str(self.root / "log"),
                "PIP_DISABLE_PIP_VERSION_CHECK": "1",
                "PIP_USER": "0",
                "TMPDIR": str(self.cache / "tmp"),
                "UV_CACHE_DIR": str(self.cache / "uv"),
                "UV_PYTHON_DOWNLOADS": "never",
            }
        )
        return cleaned

    # Stages

    def set_up(self, bench: bool, preflight: Callable[[], None]) -> bool:
        """Brings the workspace up to date; returns whether there was anything to do.

        `preflight` is called before anything is written, and only if something is to be installed.
        """
        python = "{} {}".format(platform.python_version(), sys.executable)
        environment_stamp = self.venv / "workspace.json"
        bench_stamp = self.venv / "workspace-bench.json"
        build_stamp = self.root / "install" / "workspace.json"
        environment = environment_key(self.root, python)
        build = build_key(self.root, environment)
        extra = bench_key(self.root, environment)
        needs_environment = read_stamp(environment_stamp).get("key") != environment or not self.venv_python.exists()
        needs_bench = bench and (needs_environment or read_stamp(bench_stamp).get("key") != extra)
        needs_build = needs_environment or read_stamp(build_stamp).get("key") != build
        code_stamp = self.root / "install" / "machine_code.json"
        code = machine_code_key(self.root, environment)
        needs_code = bool(code) and (needs_build or read_stamp(code_stamp).get("key") != code)
        if not (needs_environment or needs_bench or needs_build or needs_code):
            return False

        if needs_environment or needs_bench:
            preflight()
        with self._locked():
            if needs_environment:
                self._make_venv(python)
                self._install_packages()
                self._fit_packages()
                write_stamp(environment_stamp, {"key": environment, "python": python})
            if needs_bench:
                self._install_bench_packages()
                write_stamp(bench_stamp, {"key": extra})
            if needs_build:
                self._build(environment, build, build_stamp)
            if needs_code:
                self._compile_inner_loops()
                write_stamp(code_stamp, {"key": code})
        return True

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        """One set-up at a time in a checkout. Starts the log."""
        import fcntl

        (self.cache / "tmp").mkdir(parents=True, exist_ok=True)
        self.log.parent.mkdir(exist_ok=True)
        with open(str(self.cache / "setup.lock"), "w", encoding="utf-8") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise SetupError(
                    "another set-up is running in this checkout; wait for it to end and run the same command again"
                ) from None
            self.log.write_text("", encoding="utf-8")
            yield
            shutil.rmtree(str(self.cache / "tmp"), ignore_errors=True)

    @contextlib.contextmanager
    def _step(self, title: str) -> Iterator[None]:
        self.step_count += 1
        self.say("[{}] {} ...".format(self.step_count, title))
        start = time.monotonic()
        yield
        self.say("    done in {:.1f} s".format(time.monotonic() - start))

    def _make_venv(self, python: str) -> None:
        """Makes .venv afresh: an installation that broke off, or of another lock, is not repaired.

        Bringing an old one up to date would not be safer (each ROS wheel carries the metadata of a second distribution,
        whose "removal" takes its files along) and hardly faster: what was downloaded is in the cache.
        """
        with self._step("virtual environment .venv, Python {}".format(python.split()[0])):
            if self.venv.exists():
                shutil.rmtree(str(self.venv))
            self._run([sys.executable, "-m", "venv", str(self.venv)], "could not make the virtual environment .venv")

    def _install_packages(self) -> None:
        lock_file = self.root / "locks" / "workspace.txt"
        lock = lock_file.read_text(encoding="utf-8")
        with self._step("installer uv"):
            requirement = self.cache / "uv-requirement.txt"
            requirement.write_text(locked_requirement(lock, "uv"), encoding="utf-8")
            pip = [
                str(self.venv_python),
                "-I",
                "-m",
                "pip",
                "install",
                "--quiet",
                "--no-cache-dir",
                "--require-hashes",
            ]
            self._run([*pip, "-r", str(requirement)], INSTALL_FAILED)
        with self._step("{} pinned packages, ROS 2 among them".format(count_locked(lock))):
            self._uv_install(lock_file)

    def _install_bench_packages(self) -> None:
        lock_file = self.root / "locks" / "bench.txt"
        with self._step("packages the benchmarks compare with"):
            self._uv_install(lock_file)

    def _uv_install(self, lock_file: Path) -> None:
        self._follow_pip_settings()
        uv = [str(self.venv / "bin" / "uv"), "pip", "install", "--quiet", "--python", str(self.venv_python)]
        # The one package without a wheel is built with the setuptools of the lock.
        constraints = ["--build-constraints", str(self.root / "locks" / "workspace.txt")]
        self._run([*uv, "--require-hashes", "--no-deps", *constraints, "-r", str(lock_file)], INSTALL_FAILED)

    def _fit_packages(self) -> None:
        with self._step("ROS 2 wheels fitted to this machine"):
            numpy_include = self._output(
                [str(self.venv_python), "-I", "-c", "import numpy; print(numpy.get_include())"]
            )
            patch_cmake_files(self.venv / "share", sysconfig.get_path("include"), numpy_include)
            self._install_start_files()

    def _follow_pip_settings(self) -> None:
        """Hands pip's package index and certificate on to uv, which does not read pip's configuration."""
        listed = self._output([str(self.venv_python), "-I", "-m", "pip", "config", "list"])
        settings = dict(
            (name.rsplit(".", 1)[1], value.strip("'\""))
            for name, separator, value in (line.partition("=") for line in listed.splitlines())
            if separator and "." in name
        )
        for setting, variable, others in (
            ("index-url", "UV_DEFAULT_INDEX", ("UV_INDEX_URL",)),
            ("cert", "SSL_CERT_FILE", ()),
        ):
            if settings.get(setting) and not any(self.environ.get(name) for name in (variable, *others)):
                self.environ[variable] = settings[setting]

    def _install_start_files(self) -> None:
        """What makes .venv/bin/python and .venv/bin/dp work from anywhere, unsourced."""
        # Not asked of the interpreter: without its site module it names the folder of the Python it was made from.
        packages = self.venv / "lib" / "python{}.{}".format(*sys.version_info[:2]) / "site-packages"
        for source in sorted((self.root / "scripts" / "site").glob("dp_workspace.*")):
            shutil.copyfile(str(source), str(packages / source.name))
        launcher = self.venv / "bin" / "dp"
        installed = self.root / "install" / "lib" / "dp_tools" / "dp"
        launcher.write_text(
            '#!/bin/sh\nexec {} {} "$@"\n'.format(shlex.quote(str(self.venv_python)), shlex.quote(str(installed))),
            encoding="utf-8",
        )
        launcher.chmod(0o755)

    def _build(self, environment: str, build: str, build_stamp: Path) -> None:
        packages = find_packages(self.root)
        names = [package.name for package in packages]
        install = self.root / "install"
        previous = read_stamp(build_stamp)
        # colcon never takes anything away, and it refuses another layout: start afresh where that would matter.
        if previous.get("environment") != environment or not set(previous.get("packages", [])) <= set(names):
            for folder in (self.root / "build", install):
                if folder.exists():
                    shutil.rmtree(str(folder))
        with self._step("build of {} packages".format(len(packages))):
            with contextlib.suppress(FileNotFoundError):
                build_stamp.unlink()
            colcon = [str(self.venv_python), "-m", "colcon", "build", "--merge-install", "--symlink-install"]
            handlers = [
                "--event-handlers",
                "console_direct-",
                "console_cohesion-",
                "desktop_notification-",
                "status-",
                "terminal_title-",
            ]
            base = ["--base-paths", *(str(package.relative_to(self.root)) for package in packages)]
            self._run(
                [*colcon, *handlers, *base],
                "the build failed",
                show=re.compile(r"^(Finished|Failed) +<<< .*"),
            )
            write_stamp(build_stamp, {"key": build, "environment": environment, "packages": names})

    def _compile_inner_loops(self) -> None:
        """Numba would do it at first use, which a running node has no time for."""
        with self._step("machine code of the inner loops"):
            self._run(
                [str(self.venv_python), "-m", "dp_tools.machine_code"],
                "could not compile the inner loops",
                show=re.compile(r"^compiled: "),
            )

    def lock(self) -> None:
        """Writes locks/ from pyproject.toml with the uv that set-up installed."""
        everywhere = "--universal --python-version 3.11 --fork-strategy fewest --generate-hashes"
        groups = " ".join("--group " + group for group in LOCKED_GROUPS)
        # ROS 2 Jazzy on Ubuntu 24.04 is compiled against its numpy 1.26: nothing newer may stand before that.
        ros_machine = self.cache / "ros-machine-constraint.txt"
        with self._locked():
            ros_machine.write_text("numpy==1.26.4\n", encoding="utf-8")
            self._resolve("workspace", "{} {}".format(everywhere, groups))
            self._resolve("bench", "{} --group bench --constraint locks/workspace.txt".format(everywhere))
            constraint = ros_machine.relative_to(self.root)
            self._resolve(
                "ros-machine", "--python-version 3.12 --no-annotate --group runtime --constraint {}".format(constraint)
            )

    def _resolve(self, name: str, options: str) -> None:
        uv = [str(self.venv / "bin" / "uv"), "pip", "compile", "--quiet", "--upgrade", "--no-config"]
        output = ["--custom-compile-command", "make lock", "--output-file", "locks/{}.txt".format(name)]
        with self._step("locks/{}.txt".format(name)):
            self._run([*uv, *options.split(), *output], "could not resolve the dependencies")

    def clean(self, everything: bool) -> None:
        names = ["build", "install", "log", ".mypy_cache", ".ruff_cache", ".pytest_cache", ".hypothesis"]
        for name in names + ([".venv", ".cache"] if everything else []):
            if (self.root / name).exists():
                shutil.rmtree(str(self.root / name))

    # Other programs

    def _run(self, command: List[str], failed: str, show: Optional["re.Pattern[str]"] = None) -> None:
        """Runs a program, output to the log; shows lines that match `show`, and on failure the end of the output."""
        tail: List[str] = []
        with open(str(self.log), "a", encoding="utf-8") as log:
            log.write("$ {}\n".format(" ".join(map(shlex.quote, command))))
            log.flush()
            process = subprocess.Popen(
                command,
                cwd=str(self.root),
                env=self.environ,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                encoding="utf-8",
                errors="replace",
            )
            with process:
                for line in process.stdout or ():
                    log.write(line)
                    tail = [*tail[-29:], line.rstrip()]
                    if show and show.match(line):
                        self.say("    " + line.rstrip())
        if process.returncode:
            for line in tail:
                self.say("    | " + line)
            raise SetupError(
                "{}; the whole output is in {}; run the same command again to go on from here".format(
                    failed, self.log.relative_to(self.root)
                )
            )

    def _output(self, command: List[str]) -> str:
        done = subprocess.run(
            command,
            cwd=str(self.root),
            env=self.environ,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            encoding="utf-8",
        )
        if done.returncode:
            raise SetupError("{} failed; remove .venv and run the same command again".format(" ".join(command[:5])))
        return done.stdout.strip()


def _compiles(command: List[str], source: str) -> bool:
    try:
        done = subprocess.run(command, input=source.encode(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except OSError:
        return False
    return done.returncode == 0


def _open_url(url: str) -> None:
    request = urllib.request.Request(url.rstrip("/") + "/uv/", method="HEAD")
    with urllib.request.urlopen(request, timeout=15):
        pass


def preflight() -> None:
    """All checks of this machine, cheapest first."""
    check_compilers(os.environ, _compiles)
    index = (
        os.environ.get("UV_DEFAULT_INDEX")
        or os.environ.get("UV_INDEX_URL")
        or os.environ.get("PIP_INDEX_URL")
        or DEFAULT_INDEX
    )
    check_network(index, _open_url)


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="setup", description="Set-up of the workspace.")
    parser.add_argument("command", choices=["setup", "lock", "clean", "distclean"])
    parser.add_argument("--bench", action="store_true", help="also install what only the benchmarks need")
    chosen = parser.parse_args(arguments)
    start = time.monotonic()
    workspace = Workspace(ROOT, os.environ, lambda line: print(line, flush=True))
    try:
        if chosen.command in ("clean", "distclean"):
            workspace.clean(everything=chosen.command == "distclean")
            return 0
        check_platform(platform.system(), platform.machine(), platform.libc_ver()[0])
        check_python(sys.implementation.name, sys.version_info[:3])
        check_python_is_complete(
            sys.version_info[:3],
            lambda name: importlib.util.find_spec(name) is not None,
            Path(sysconfig.get_path("include")),
        )
        if workspace.set_up(chosen.bench, preflight):
            print("Set up in {:.0f} s.".format(time.monotonic() - start))
        if chosen.command == "lock":
            workspace.lock()
    except SetupError as error:
        print("setup: {}".format(error), file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\nsetup: interrupted; run the same command again to go on", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
