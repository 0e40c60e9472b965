"""The page of a comparison: one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from dp_tools.compare.plots import Drawing
from dp_tools.compare.sheet import Sheet
from dp_tools.compare.sheets import azimuth_sheets, group_sheets, portion_sheets, speed_sheets
from dp_tools.compare.study import Comparison
from dp_tools.report.panels import svg_uri
from dp_tools.report.scene import Picture
from dp_tools.report.template import fill_in


@dataclass(frozen=True)
class Part:
    """A section of the page.

    Attributes
    ----------
    name, title
        Anchor and heading.
    sheets
        Its tables.
    drawings
        Names of its pictures.
    """

    name: str
    title: str
    sheets: tuple[Sheet, ...]
    drawings: tuple[str, ...]


def parts(comparison: Comparison) -> Iterator[Part]:
    """Yield the sections of a comparison."""
    turning = " (azimuth thrusters along their fixed directions)" if any(comparison.vessel.can_rotate) else ""
    for i, study in enumerate(comparison.groups, start=1):
        title = f"{study.group.name.capitalize()}{turning}"
        sheets = tuple(group_sheets(comparison.vessel, study))
        yield Part(f"group-{i}", title, sheets, (f"sets_{i}", f"sections_{i}"))
    if comparison.azimuth is not None:
        sheets = tuple(azimuth_sheets(comparison.azimuth))
        yield Part("azimuth", "Four azimuth propellers that turn together", sheets, ("asteroid",))
    if comparison.portions is not None:
        yield Part("portions", "Portions", tuple(portion_sheets(comparison.portions)), ("portions",))
    for i, speed in enumerate(comparison.speeds, start=1):
        yield Part(f"speed-{i}", "Thrust over speed", tuple(speed_sheets(speed)), (f"speed_{i}",))


def render(comparison: Comparison, drawn: Sequence[Drawing]) -> str:
    """Return the page as HTML text; it refers to nothing outside itself. Inside ``style.plot_style()``."""
    pictures = {
        one.name: Picture(one.title, one.text, svg_uri(one.figure), one.alt, narrow=one.narrow) for one in drawn
    }
    sections = list(parts(comparison))
    return fill_in(
        "compare.html",
        vessel=comparison.vessel,
        parts=[(part, [pictures[name] for name in part.drawings if name in pictures]) for part in sections],
        facts=[
            ("Vessel", comparison.vessel.name),
            ("Axes", ", ".join(comparison.vessel.degrees_of_freedom)),
            ("Thrusters", str(len(comparison.vessel.thrusters))),
            ("Random demands", f"{comparison.demands} for each part"),
            ("Seed", str(comparison.seed)),
        ],
    )
