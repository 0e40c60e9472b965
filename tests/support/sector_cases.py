"""Circles cut into sectors for hypothesis, in whole degrees so that counting gives the reference."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hypothesis import strategies as st

from marine_model.sector import Sector

CIRCLE = 720  # half degrees: what the cuts of intervals of whole degrees come out in
HALF_DEGREE = math.pi / 360.0


@dataclass(frozen=True)
class Circle:
    """A whole turn of arcs."""

    arcs: tuple[tuple[int, int, str, float], ...]  # start and width in degrees, kind or "plain", thrust factor

    @property
    def sectors(self) -> list[Sector]:
        found = []
        for start, width, kind, factor in self.arcs:
            if kind != "plain":
                ends = [math.radians((angle + 180) % 360 - 180) for angle in (start, start + width)]
                if width == 360:
                    ends = [-math.pi, math.pi]
                found.append(
                    Sector.model_validate({"start": ends[0], "end": ends[1], "kind": kind, "thrust_factor": factor})
                )
        return found

    def cells(self) -> list[tuple[str, float]]:
        """Kind and thrust factor of the half degrees from 0 to 360 deg."""
        cells = [("plain", 1.0)] * CIRCLE
        for start, width, kind, factor in self.arcs:
            for k in range(2 * start, 2 * (start + width)):
                cells[k % CIRCLE] = (kind, factor)
        return cells

    def mirrored(self) -> Circle:
        """Port for starboard."""
        return Circle(
            tuple(((-start - width + 180) % 360 - 180, width, kind, factor) for start, width, kind, factor in self.arcs)
        )


@st.composite
def circles(draw: st.DrawFn) -> Circle:
    """A circle of one to six arcs, plain, forbidden and reduced, that is not wholly forbidden."""
    cuts = sorted(draw(st.sets(st.integers(-180, 179), min_size=1, max_size=6)))
    arcs = []
    for start, following in zip(cuts, [*cuts[1:], cuts[0] + 360], strict=True):
        kind = draw(st.sampled_from(["plain", "forbidden", "reduced"]))
        factor = 1.0 if kind == "plain" else draw(st.sampled_from([0.0, 0.3, 0.5]))
        arcs.append((start, following - start, kind, factor))
    if all(kind == "forbidden" for _, _, kind, _ in arcs):
        start, width, _, _ = arcs[0]
        arcs[0] = (start, width, "plain", 1.0)
    return Circle(tuple(arcs))
