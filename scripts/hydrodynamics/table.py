"""Data file: comments, names of columns, a line for every heading of every frequency."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hydrodynamics.response import Response
from marine_model.wave_response.columns import HEADER


def write(path: Path, comments: list[str], response: Response) -> None:
    """Write ``response`` under ``comments``."""
    lines = [f"# {comment}".rstrip() for comment in comments] + [HEADER]
    for i, frequency in enumerate(response.frequency):
        for j, heading in enumerate(response.heading):
            parts = response.motion[i, j].view(np.float64)
            cells = [f"{frequency:.6g}", f"{heading:.10f}", *map(_number, parts), *map(_number, response.drift[i, j])]
            lines.append(",".join(cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _number(value: float) -> str:
    """Five decimals are finer than the panels resolve, and what symmetry makes zero comes out as zero."""
    text = f"{value:.5f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
