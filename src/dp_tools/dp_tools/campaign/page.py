"""The page of all runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dp_tools.campaign.index import (
    INDEX_DATA_NAME,
    INDEX_NAME,
    Entry,
    index_facts,
    index_machines,
    index_versions,
    write_index_data,
)
from dp_tools.campaign.markdown import INDEX_TEXT_NAME, write_index_text
from dp_tools.report.template import fill_in


def write_index(folder: Path, entries: Sequence[Entry]) -> Path:
    """Write index.html, index.md and index.json into ``folder`` and return the path of the page.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_index_data(folder / INDEX_DATA_NAME, entries)
    write_index_text(folder / INDEX_TEXT_NAME, entries)
    path = folder / INDEX_NAME
    path.write_text(render(entries), encoding="utf-8")
    return path


def render(entries: Sequence[Entry]) -> str:
    """Return the page as HTML text; it refers to nothing but the reports of its runs."""
    return fill_in(
        "index.html",
        entries=entries,
        facts=index_facts(entries),
        machines=index_machines(entries),
        versions=index_versions(entries),
        compared=any(entry.summary.apart is not None for entry in entries),
    )
