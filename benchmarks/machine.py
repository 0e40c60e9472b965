"""What the figures were measured on."""

from __future__ import annotations

import json
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import psutil

_DISTRIBUTIONS = (
    "numpy",
    "numba",
    "daqp",
    "ros-jazzy-rclpy",
    "ros-fastrtps",
    "MCSimPython",
    "osqp",
    "qpsolvers",
    "scipy",
    "casadi",
    "quta",
)


def describe_machine() -> dict[str, Any]:
    """Return processor, memory, load and versions."""
    return {
        "cpu": _cpu_model(),
        "logical_cores": psutil.cpu_count(),
        "usable_cores": len(os.sched_getaffinity(0)),
        "memory_bytes": psutil.virtual_memory().total,
        "load_average_1_min_before": os.getloadavg()[0],
        "kernel": platform.release(),
        "python": platform.python_version(),
        "versions": {name: _version(name) for name in _DISTRIBUTIONS},
    }


def write_machine(path: Path, machine: dict[str, Any]) -> None:
    """Write machine.json."""
    path.write_text(json.dumps(machine, indent=2) + "\n", encoding="utf-8")


def _cpu_model() -> str:
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.processor() or "unknown"


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "not installed"
