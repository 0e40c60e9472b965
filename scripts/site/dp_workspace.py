"""Makes every start of the workspace's Python ready for ROS 2 and the built packages, without sourcing a set-up file.

Set-up copies this module into the site-packages of `.venv` beside `dp_workspace.pth`, which imports it at interpreter
start, before `ros_wheels_bootstrapper.pth` (they are read in alphabetical order). It puts the workspace's packages on
`sys.path`, gives this process and all its children the variables a sourced ROS 2 workspace has, and, where the dynamic
loader needs a longer LD_LIBRARY_PATH than the process was started with, starts the same command once more: the loader
reads that variable only at start.
"""

import os
import site
import sys
from typing import Dict, List, Mapping

# Set by ros_wheels_bootstrapper when it has done its own restart. A child can inherit it while having lost
# LD_LIBRARY_PATH (a cleaned environment), so it is set here only together with a path that is known to be right.
_WHEELS_GUARD = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
# Holds the process id of the process that has already restarted itself. exec keeps the id and children have another
# one, so an inherited value never stops a child from repairing its own environment.
_RESTARTED_PID = "_DP_WORKSPACE_RESTARTED_PID"


def _site_packages(prefix: str) -> str:
    return os.path.join(prefix, "lib", "python%d.%d" % sys.version_info[:2], "site-packages")


def _in_front(wanted: List[str], present: str) -> str:
    """A search path with the folders of `wanted` that exist first, then what was `present`, each once."""
    kept = [entry for entry in wanted if os.path.isdir(entry)]
    kept += [entry for entry in present.split(os.pathsep) if entry and entry not in kept]
    return os.pathsep.join(kept)


def _library_folders(prefix: str, install: str) -> List[str]:
    packages = _site_packages(prefix)
    bundled = sorted(name for name in os.listdir(packages) if name.startswith("ros_") and name.endswith(".libs"))
    return [os.path.join(install, "lib"), os.path.join(prefix, "lib")] + [
        os.path.join(packages, name) for name in bundled
    ]


def workspace_variables(root: str, prefix: str, environ: Mapping[str, str]) -> Dict[str, str]:
    """The variables a process of the workspace at `root`, with its virtual environment at `prefix`, is to have."""
    install = os.path.join(root, "install")
    variables = {
        "AMENT_PREFIX_PATH": _in_front([install, prefix], environ.get("AMENT_PREFIX_PATH", "")),
        "LD_LIBRARY_PATH": _in_front(_library_folders(prefix, install), environ.get("LD_LIBRARY_PATH", "")),
        _WHEELS_GUARD: "1",
    }
    defaults = {
        # The wheels' DDS has no security: talk to this machine only unless the user asks for more.
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        # Keep what libraries write about a run inside the checkout.
        "ROS_LOG_DIR": os.path.join(root, "log", "ros"),
        "MPLCONFIGDIR": os.path.join(root, ".cache", "matplotlib"),
    }
    variables.update((name, value) for name, value in defaults.items() if not environ.get(name))
    return variables


def linked_folders(packages: str) -> List[str]:
    """The source folders that `colcon build --symlink-install` linked into `packages` by <name>.egg-link files."""
    folders = []
    for name in sorted(os.listdir(packages)) if os.path.isdir(packages) else []:
        if name.endswith(".egg-link"):
            with open(os.path.join(packages, name), encoding="utf-8") as link:
                folders.append(link.readline().strip())
    return folders


def needs_restart(before: Mapping[str, str], after: Mapping[str, str], pid: int) -> bool:
    """Whether the loader of process `pid`, started with `before`, lacks library folders that `after` names."""
    if before.get(_RESTARTED_PID) == str(pid):
        return False
    loaded = before.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    return any(folder not in loaded for folder in after["LD_LIBRARY_PATH"].split(os.pathsep))


def activate() -> None:
    """Prepares this process; restarts it once if its loader path was too short."""
    prefix = sys.prefix
    root = os.path.dirname(prefix)
    before = dict(os.environ)
    os.environ.update(workspace_variables(root, prefix, before))
    if needs_restart(before, os.environ, os.getpid()):
        os.environ[_RESTARTED_PID] = str(os.getpid())
        os.execve(sys.executable, [sys.executable] + sys.orig_argv[1:], os.environ)
    packages = _site_packages(os.path.join(root, "install"))
    site.addsitedir(packages)
    sys.path.extend(folder for folder in linked_folders(packages) if folder not in sys.path)


activate()
