"""What `dp propeller` writes: tables as CSV, all else as JSON."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from dp_tools.propeller.study import Columns, Study
from dp_tools.run_folder import FolderError, make_writable
from thruster_drivers.sensitivity import Sensitivity


@dataclass(frozen=True)
class PropellerFolder:
    """Where the files go: a folder for every propeller."""

    path: Path

    def prepare(self, studies: Sequence[str]) -> None:
        """Make the folders. Raises FolderError if they cannot be written."""
        make_writable(self.path, *studies)

    def write(self, study: Study, pictures: Sequence[str]) -> None:
        """Write numbers of one propeller. Raises FolderError."""
        folder = self.path / study.subject.name
        tables = {**study.tables, **_sensitivity_tables(study), **_path_tables(study)}
        content = {
            "propeller": study.subject.name,
            "title": study.subject.title,
            "density": study.subject.density,
            "summary": asdict(study.summary),
            "last_tau": study.last_loading,
            "full_pitch_tau": study.full_pitch_loading,
            "torque_coefficients": study.torque_coefficients,
            "comparison": [asdict(row) for row in study.comparisons],
            "printed": None if study.subject.printed is None else study.subject.printed.model_dump(mode="json"),
            "not_defined": study.missing,
            "tables": {name: f"{name}.csv" for name in tables},
            "pictures": list(pictures),
        }
        try:
            text = json.dumps(_plain(content), indent=1, allow_nan=False) + "\n"
            (folder / "propeller.json").write_text(text, encoding="utf-8")
            for name, columns in tables.items():
                _write(folder / f"{name}.csv", columns)
        except OSError as error:
            raise FolderError(f"{folder}: cannot be written: {error.strerror}") from error


def _write(path: Path, columns: Columns) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        # repr: the very number again when it is read.
        writer.writerows(
            ["" if math.isnan(value) else repr(value) for value in row]
            for row in zip(*(np.asarray(values).tolist() for values in columns.values()), strict=True)
        )


def _sensitivity_tables(study: Study) -> dict[str, Columns]:
    return {
        f"sensitivity_{_file_name(name)}": {item.name: getattr(one, item.name) for item in fields(Sensitivity)}
        for name, one in study.sensitivities.items()
    }


def _path_tables(study: Study) -> dict[str, Columns]:
    return {
        f"path_{_file_name(name)}": {
            "tau": path.loading,
            "pitch_ratio": path.pitch_ratio,
            "efficiency": path.efficiency,
            "best_efficiency": path.best,
            "relative_error": path.relative_error,
        }
        for name, path in study.paths.items()
    }


def _file_name(name: str) -> str:
    return name.replace(", ", "_").replace("/", "_").replace(" ", "_")


def _plain(value: Any) -> Any:
    """Return ``value`` as JSON knows it: infinity, which means no limit, as null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value
