"""The table of all runs as a Markdown page, for documents and issues."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from dp_tools.campaign.index import Entry, index_facts, index_machines, index_versions

INDEX_TEXT_NAME = "index.md"
_HEAD = ("figure", "thesis", "ours", "95 % interval", "verdict", "remark")


def write_index_text(path: Path, entries: Sequence[Entry]) -> None:
    """Write index.md: who sailed what, and a table a run."""
    path.write_text("\n".join(_page(entries)) + "\n", encoding="utf-8")


def _page(entries: Sequence[Entry]) -> Iterator[str]:
    yield "# Runs beside the thesis"
    yield ""
    yield ", ".join(f"{name.lower()} {value}" for name, value in index_facts(entries)) + "."
    for told in (index_machines(entries), index_versions(entries)):
        if told:
            yield f"{told}."
    for entry in entries:
        yield ""
        yield f"## {_cell(entry.summary.title)}"
        yield ""
        yield f"{_cell(entry.facts)}." + (f" Graph and in process: {entry.apart}." if entry.apart else "")
        yield ""
        yield _row(_HEAD)
        yield _row(["---"] * len(_HEAD))
        for line in entry.lines():
            yield _row([line.title, line.thesis, line.ours, line.interval, line.verdict, line.remark])


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(_cell(cell) for cell in cells) + " |"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
