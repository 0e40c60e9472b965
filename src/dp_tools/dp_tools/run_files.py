"""The parameter file that a run of the graph starts with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dp_bringup.parameter_file import to_parameter_file
from dp_bringup.workspace import RING_PACKAGES, SIMULATOR_PACKAGE
from dp_tools.run_folder import RunFolder
from dp_tools.scenario import Scenario


@dataclass(frozen=True)
class Pace:
    """How simulated time goes: lockstep waits for the ring; rate is simulated over wall seconds, 0 for no limit."""

    lockstep: bool
    rate: float


def start_parameters(vessel: str, scenario: Scenario | None, pace: Pace, hold: bool) -> dict[str, dict[str, Any]]:
    """Return parameters by node: vessel, pace, and what the scenario says."""
    values: dict[str, dict[str, Any]] = {package: {"vessel": vessel} for package in (*RING_PACKAGES, SIMULATOR_PACKAGE)}
    for package in RING_PACKAGES:
        values[package]["synchronous"] = pace.lockstep
    values[SIMULATOR_PACKAGE] |= {"lockstep": pace.lockstep, "rate": float(pace.rate), "hold": hold}
    if scenario is not None:
        for node, own in scenario.start_parameters.items():
            values[node] |= own
    return values


def write_start_parameters(folder: RunFolder, values: dict[str, dict[str, Any]]) -> None:
    """Write the parameter file of a run."""
    folder.parameters.write_text(to_parameter_file(values), encoding="utf-8")
