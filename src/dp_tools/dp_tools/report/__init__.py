"""The HTML report of one run."""

from __future__ import annotations

from pathlib import Path

from dp_tools.bag_reader import read_bag
from dp_tools.report.page import FIGURES_NAME, write_report
from dp_tools.report.picture import write_picture
from dp_tools.scenario import Scenario, free_run

__all__ = ["report_bag", "write_picture", "write_report"]


def report_bag(bag: Path, folder: Path, vessel: str = "", picture: Path | None = None) -> tuple[Path, Path]:
    """Write report.html and figures.json of a recording into ``folder`` and return their paths.

    Parameters
    ----------
    bag
        Folder of a bag, or its MCAP file.
    folder
        Where to write.
    vessel
        Name or path of the vessel, for a bag that holds none.
    picture
        Where to write a stand-alone PNG as well; None for none.

    Raises
    ------
    DpError
        If the bag cannot be read, or lacks what its scenario's figures need.
    """
    recorded = read_bag(bag, vessel)
    scenario: Scenario = recorded.scenario or free_run(recorded.vessel.name, recorded.run.duration)
    page = write_report(recorded.run, scenario, recorded.vessel, folder)
    if picture is not None:
        write_picture(recorded.run, scenario, recorded.vessel, picture)
    return page, folder / FIGURES_NAME
