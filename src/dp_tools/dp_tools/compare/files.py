"""What `dp compare` writes: the page, all numbers as JSON, pictures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from dp_tools.compare.azimuth_study import AzimuthStudy
from dp_tools.compare.group_study import GroupStudy
from dp_tools.compare.plots import Drawing
from dp_tools.compare.portion_study import PLANES, PortionStudy
from dp_tools.compare.speed_study import TRUTHS, SpeedStudy
from dp_tools.compare.study import Comparison
from dp_tools.run_folder import FolderError, make_writable
from thrust_allocator.methods.cross import AXES

PAGE_NAME, NUMBERS_NAME = "compare.html", "compare.json"
_DPI = 130


@dataclass(frozen=True)
class CompareFolder:
    """Where the files go."""

    path: Path

    def prepare(self) -> None:
        """Make the folder. Raises FolderError if it cannot be written."""
        make_writable(self.path)

    def write(self, comparison: Comparison, page: str, drawn: Sequence[Drawing]) -> None:
        """Write everything; inside ``style.plot_style()``. Raises FolderError."""
        text = json.dumps(numbers(comparison), indent=1, allow_nan=False) + "\n"
        try:
            (self.path / NUMBERS_NAME).write_text(text, encoding="utf-8")
            (self.path / PAGE_NAME).write_text(page, encoding="utf-8")
            for one in drawn:
                one.figure.savefig(self.path / f"{one.name}.png", dpi=_DPI)
        except OSError as error:
            raise FolderError(f"{self.path}: cannot be written: {error.strerror}") from error


def numbers(comparison: Comparison) -> dict[str, Any]:
    """Return all numbers as JSON knows them."""
    vessel = comparison.vessel
    return {
        "vessel": vessel.name,
        "thrusters": list(vessel.thruster_names),
        "demands": comparison.demands,
        "seed": comparison.seed,
        "groups": [_group(vessel.thruster_names, study) for study in comparison.groups],
        "azimuth": None if comparison.azimuth is None else _azimuth(comparison.azimuth),
        "portions": None if comparison.portions is None else _portions(comparison.portions),
        "drives": [_speed(study) for study in comparison.speeds],
    }


def _group(names: Sequence[str], study: GroupStudy) -> dict[str, Any]:
    group, refused = study.group, study.refused
    return {
        "axes": list(group.axes),
        "units": list(group.units),
        "thrusters": [names[j] for j in group.thrusters],
        "largest_as_printed": group.printed.tolist(),
        "largest_served": group.served.tolist(),
        "load_of_printed_corners": study.corner_loads.tolist(),
        "volumes": asdict(study.volumes),
        "shares": asdict(study.shares),
        "refused": None
        if refused is None
        else {
            "demand": refused.demand.tolist(),
            "load": refused.load,
            "times_attainable": refused.multiple,
            "pseudo_inverse": refused.by_pseudo_inverse.tolist(),
            "quadratic_program": refused.by_program.tolist(),
            "residual": refused.residual.tolist(),
        },
        "reductions": [
            {
                "source": one.source,
                "demand": one.demand.tolist(),
                "load": one.load,
                "ways": [{"method": way.method, "given": way.given.tolist(), "share": way.share} for way in one.ways],
            }
            for one in study.reductions
        ],
    }


def _azimuth(study: AzimuthStudy) -> dict[str, Any]:
    return {
        "moment": study.moment,
        "reserved_thrust": study.reserved,
        "force_limit": study.limit,
        "kept_angle_degrees": study.present,
        "areas": {
            "asteroid": study.asteroid_area,
            "together": study.together_area,
            "apart": study.apart_area,
        },
        "shares": asdict(study.shares),
        "cases": [asdict(case) for case in study.cases],
    }


def _portions(study: PortionStudy) -> dict[str, Any]:
    return {
        "axes": list(AXES),
        "planes": [list(plane) for plane in PLANES],
        "thrust_max": study.thrust_max,
        "attainable_limits": list(study.limits),
        "attainable_areas": [section.volume for section in study.sections],
        "attainable_share": study.attainable,
        "rows": [asdict(row) for row in study.rows],
    }


def _speed(study: SpeedStudy) -> dict[str, Any]:
    return {
        "thruster": study.thruster,
        "count": study.count,
        "truths": list(TRUTHS),
        "rows": [asdict(row) for row in study.rows],
        "speeds": study.speeds.tolist(),
        "demands": study.demands.tolist(),
        "achieved": {
            f"{truth}_{'with' if compensated else 'without'}_compensation": values.tolist()
            for (truth, compensated), values in study.over_speed.items()
        },
    }
