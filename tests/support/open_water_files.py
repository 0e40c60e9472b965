"""Trial files for tests: those that come with the project, and a small one to change."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import yaml

TRIALS = Path(__file__).parents[2] / "src" / "dp_bringup" / "open_water"

_SMALL: dict[str, Any] = {
    "name": "small",
    "title": "Small trial",
    "description": "Two controllers in a basin.",
    "density": 1000.0,
    "duration": 2.0,
    "time_step": 0.01,
    "series_step": 0.1,
    "propeller": {"model": "wageningen_b", "diameter": 0.25, "blades": 4, "area_ratio": 0.55, "pitch_ratio": 1.0},
    "shaft": {"inertia": 0.02, "torque_max": 32.0, "friction_static": 0.0, "friction_viscous": 0.0},
    "limits": {"min": 0.0, "max": 400.0, "rate": 1000.0},
    "gains": {"shaft_speed": {"bandwidth": 50.0, "integral_time": 0.08}},
    "inflow": {"current": 0.5},
    "thrust": {"mean": 200.0},
    "cases": [
        {"name": "speed", "title": "Shaft speed", "controller": "shaft_speed"},
        {"name": "power", "title": "Power", "controller": "power"},
    ],
    "windows": {"all": [1.0, 2.0]},
    "table": {"window": "all", "kinds": ["corrected_mean_power", "mean_thrust"]},
    "figures": [
        {"name": "ratio", "title": "Power", "kind": "mean_power", "case": "power", "over": "speed", "window": "all"}
    ],
}

VENTILATION: dict[str, float] = yaml.safe_load((TRIALS / "ventilation_fast.yaml").read_text(encoding="utf-8"))[
    "ventilation"
]
DETECTION = {
    "on": 0.5,
    "off": 0.8,
    "speed_min": 5.0,
    "torque_rate_limit": 0.5,
    "deceleration_limit": 10.0,
    "relax_rate": 0.0625,
    "false_alarm_interval": 3.6e6,
}


def small_trial() -> dict[str, Any]:
    """Return the small trial as a new document."""
    return deepcopy(_SMALL)


def write_trial(folder: Path, document: dict[str, Any]) -> Path:
    """Write a document and return its path."""
    path = folder / "trial.yaml"
    path.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")
    return path
