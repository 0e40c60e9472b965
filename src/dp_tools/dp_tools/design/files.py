"""What `dp design` writes: tables as CSV, all numbers as JSON, maps as CSV, figures."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dp_tools.design.tables import buses, numbers
from dp_tools.run_folder import FolderError, make_writable
from marine_model import Vessel
from thrust_allocator.design.loop import Study, bus_losses
from thrust_allocator.design.maps import GainMap, MapCase


@dataclass(frozen=True)
class DesignFolder:
    """Where the files go."""

    path: Path

    def prepare(self) -> None:
        """Make the folder. Raises FolderError if it cannot be written."""
        make_writable(self.path)

    def map_file(self, number: int, case: MapCase) -> Path:
        """Return the path of a map's picture."""
        return self.path / f"map_{number:02d}{'_' + case.method if case.method != 'svd' else ''}.png"

    def write(self, vessel: Vessel, turning: Study, fixed: Study, maps: Sequence[GainMap]) -> None:
        """Write all but the pictures. Raises FolderError."""
        content = {
            "vessel": vessel.name,
            "thrusters": list(vessel.thruster_names),
            "freely_rotating": _study(turning),
            "fixed": _study(fixed),
            "bus_losses": [
                {"bus": loss.bus, "left": [] if loss.left is None else [j + 1 for j in loss.left.thrusters]}
                for loss in bus_losses(vessel, turning)
            ],
            "maps": [_map(vessel, one, self.map_file(i, one.case).name) for i, one in enumerate(maps, start=1)],
        }
        try:
            text = json.dumps(content, indent=1, allow_nan=False) + "\n"
            (self.path / "design.json").write_text(text, encoding="utf-8")
            for name, found in (("freely_rotating", turning), ("fixed", fixed)):
                self._table(
                    f"{name}.csv",
                    ("working", "lost", "rank", "gain", "equal_gain", "scaled_ball", "ball"),
                    (
                        (
                            numbers(row.thrusters),
                            "" if row.lost is None else vessel.thruster_names[row.lost],
                            row.rank,
                            row.gain,
                            row.equal_gain,
                            row.scaled_ball,
                            row.ball,
                        )
                        for row in found.combinations
                    ),
                )
            self._table(
                "splits.csv",
                ("buses", "gain", "equal_gain"),
                ((buses(split), split.gain, split.equal_gain) for split in turning.splits),
            )
            for i, one in enumerate(maps, start=1):
                self._table(
                    self.map_file(i, one.case).with_suffix(".csv").name,
                    (
                        f"{vessel.thruster_names[one.case.axes[0]]}_rad",
                        f"{vessel.thruster_names[one.case.axes[1]]}_rad",
                        "gain",
                    ),
                    (
                        (f"{one.angles[a]:.6f}", f"{one.angles[b]:.6f}", f"{one.gain[a, b]:.6f}")
                        for a in range(len(one.angles))
                        for b in range(len(one.angles))
                    ),
                )
        except OSError as error:
            raise FolderError(f"{self.path}: cannot be written: {error.strerror}") from error

    def _table(self, name: str, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
        with (self.path / name).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(head)
            writer.writerows(rows)


def _study(found: Study) -> dict[str, Any]:
    ball = found.ball
    content: dict[str, Any] = {
        "azimuth": None if found.azimuth is None else found.azimuth.tolist(),
        "combinations": [
            {
                "working": [j + 1 for j in row.thrusters],
                "single_failure": None if row.lost is None else row.lost + 1,
                "rank": row.rank,
                "gain": row.gain,
                "equal_gain": row.equal_gain,
                "scaled_ball": row.scaled_ball,
                "ball": row.ball,
            }
            for row in found.combinations
        ],
        "ball": {
            "printed_bound": ball.printed,
            "bound_without_root": ball.without_root,
            "exact_reversible": ball.reversible,
            "exact": ball.exact,
        },
    }
    if found.azimuth is None:
        own, equal = found.best_splits(equal_thrust=False), found.best_splits(equal_thrust=True)
        content["splits"] = [
            {
                "buses": [[j + 1 for j in bus] for bus in split.buses],
                "gain": split.gain,
                "equal_gain": split.equal_gain,
                "best": split in own,
                "equal_best": split in equal,
            }
            for split in found.splits
        ]
    return content


def _map(vessel: Vessel, one: GainMap, file: str) -> dict[str, Any]:
    best, x, y = one.best
    case = one.case
    return {
        "file": file,
        "axes": [vessel.thruster_names[j] for j in case.axes],
        "held": case.held,
        "lost": None if case.lost is None else vessel.thruster_names[case.lost],
        "equal_thrust": case.equal_thrust,
        "method": case.method,
        "thesis_figure": case.source,
        "largest_gain": best,
        "largest_gain_at": [x, y],
        "smallest_gain": float(one.gain.min()),
        "share_above_half": math.fsum((one.gain > 0.5).ravel()) / one.gain.size,
    }
