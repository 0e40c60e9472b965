"""The built workspace: where executables and shared files are, by the ament index."""

from __future__ import annotations

from pathlib import Path

from ament_index_python.packages import (
    PackageNotFoundError,
    get_package_prefix,
    get_package_share_directory,
)

from marine_model.errors import DpError

RING_PACKAGES = ("dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers")
SIMULATOR_PACKAGE = "vessel_sim"


class WorkspaceError(DpError):
    """The workspace is not built, or not on AMENT_PREFIX_PATH."""


def executable(package: str, name: str) -> Path:
    """Return the path of an executable, found as `ros2 run` finds it.

    Raises
    ------
    WorkspaceError
        If the package or the executable is not there.
    """
    try:
        path = Path(get_package_prefix(package)) / "lib" / package / name
    except PackageNotFoundError as error:
        raise WorkspaceError(
            f"package {package}: not in the ament index; build the workspace first (make setup, or colcon build)"
        ) from error
    if not path.is_file():
        raise WorkspaceError(f"package {package}: expected an executable {name}, found none at {path}")
    return path


def share(package: str) -> Path:
    """Return the share folder of a package. Raises WorkspaceError."""
    try:
        return Path(get_package_share_directory(package))
    except PackageNotFoundError as error:
        raise WorkspaceError(
            f"package {package}: not in the ament index; build the workspace first (make setup, or colcon build)"
        ) from error
