"""All runs of a folder in one table: as text, as JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dp_tools.campaign.comparison import AGREEMENT
from dp_tools.campaign.order import Outcome
from dp_tools.campaign.over_seeds import Verdict
from dp_tools.campaign.summary import SUMMARY_NAME, JudgedFigure, RunSummary, read_summary
from dp_tools.quantities import bound, interval, number, printed, quantity, remark
from dp_tools.run_data import RunInfo
from dp_tools.run_folder import RunFolder
from dp_tools.scenario import free_run
from marine_model.errors import InputError

INDEX_NAME = "index.html"
INDEX_DATA_NAME = "index.json"
_REPORT_NAME = "report.html"


@dataclass(frozen=True)
class Line:
    """One figure as text."""

    title: str
    thesis: str
    ours: str
    interval: str
    extremes: str
    verdict: str
    good: bool | None  # None: neither
    remark: str


@dataclass(frozen=True)
class Entry:
    """One scenario in the table.

    Attributes
    ----------
    summary
        Its runs.
    report
        Its report, from the folder of the table; empty if there is none.
    """

    summary: RunSummary
    report: str

    def lines(self) -> tuple[Line, ...]:
        """Return its figures as text."""
        return tuple(_line(figure) for figure in self.summary.figures())

    @property
    def facts(self) -> str:
        """Who sailed it, in one line."""
        summary, factor = self.summary, self.summary.real_time_factor
        parts = [_seeds(summary.seeds), summary.how]
        if factor is not None:
            parts.append(f"{number(factor)} x real time")
        parts += [f"seed {seed}: {why}" for seed, why in summary.failures]
        return ", ".join(part for part in parts if part)

    @property
    def fingerprint(self) -> str:
        """Of the run of the first seed; empty without one."""
        return self.summary.outcomes[0].fingerprint if self.summary.outcomes else ""

    @property
    def apart(self) -> str:
        """How far graph and in process are apart; empty where that was not asked for."""
        found = self.summary.apart
        if found is None:
            return ""
        name, size = found
        return "equal to the bit" if not name else f"{size:.1e} ({name})".replace("-", "−")

    @property
    def agrees(self) -> bool:
        """Whether graph and in process agree, as far as they were compared."""
        found = self.summary.apart
        return found is None or found[1] <= AGREEMENT


def find_entries(paths: Sequence[Path], relative_to: Path) -> tuple[Entry, ...]:
    """Return what is in folders of runs, or in recordings.

    Parameters
    ----------
    paths
        Each a folder with one folder a run, the folder of a run, or a bag.
    relative_to
        Folder of the table, for links to reports.

    Raises
    ------
    InputError
        If there is no run, or one scenario is there twice.
    DpError
        If a bag or summary cannot be read.
    """
    entries = []
    for path in paths:
        inside = sorted(child for child in path.iterdir() if _is_run(child)) if path.is_dir() else []
        # A bag's folder holds files only; the folder of a run holds its bag.
        runs = [path] if _is_run(path) or not inside else inside
        entries += [_entry(run, relative_to) for run in runs]
    names = [entry.summary.name for entry in entries]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"runs: expected every scenario once, found {', '.join(twice)} more than once")
    if not entries:
        raise InputError(f"runs: expected folders of runs or recordings, found none in {', '.join(map(str, paths))}")
    return tuple(sorted(entries, key=lambda entry: entry.summary.name))


def write_index_data(path: Path, entries: Sequence[Entry]) -> None:
    """Write index.json."""
    document = {"runs": [_document(entry) for entry in entries]}
    path.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _is_run(path: Path) -> bool:
    return (path / SUMMARY_NAME).is_file() or RunFolder(path).bag.is_dir()


def _entry(path: Path, relative_to: Path) -> Entry:
    folder = path if path.is_dir() and _is_run(path) else path.absolute().parent
    summary = _newest(path)
    report = folder / _REPORT_NAME
    return Entry(summary, os.path.relpath(report, relative_to) if report.is_file() else "")


def _newest(path: Path) -> RunSummary:
    """Return the summary of a run; of its recording, if that is newer or all there is."""
    kept, bag = path / SUMMARY_NAME, RunFolder(path).bag
    files = sorted(bag.glob("*.mcap"))
    if kept.is_file() and not any(file.stat().st_mtime > kept.stat().st_mtime for file in files):
        return read_summary(kept)
    # It takes its time to load what reads bags; a folder with summaries needs none of it.
    from dp_tools.bag_reader import read_bag

    recorded = read_bag(bag if files else path)
    scenario = recorded.scenario or free_run(recorded.vessel.name, recorded.run.duration)
    outcome = Outcome.of(recorded.run, scenario, recorded.vessel)
    return RunSummary.of(scenario, "", [outcome])


def _seeds(seeds: Sequence[int]) -> str:
    if not seeds:
        return "no seed"
    if len(seeds) > 2 and list(seeds) == list(range(seeds[0], seeds[0] + len(seeds))):
        return f"seeds {seeds[0]} to {seeds[-1]}"
    return f"{'seed' if len(seeds) == 1 else 'seeds'} {', '.join(map(str, seeds))}"


def _line(figure: JudgedFigure) -> Line:
    spec, spread = figure.spec, figure.spread
    ours = "not reached" if spread.mean is None else quantity(spec, spread.mean)
    if spread.missing and spread.missing < spread.seeds:
        ours = f"not reached in {spread.missing} of {spread.seeds} seeds"
    between = extremes = ""
    if spread.low is not None and spread.high is not None:
        between = interval(spec, spread.low, spread.high)
    if spread.seeds > 1 and spread.least is not None and spread.most is not None:
        extremes = interval(spec, spread.least, spread.most)
    thesis = [] if spec.thesis is None else [printed(spec, spec.thesis)]
    thesis += [bound(spec)] if bound(spec) else []
    good: bool | None = None
    if Verdict.FAILS in figure.verdicts or figure.unexplained:
        good = False
    elif Verdict.DIFFERS not in figure.verdicts and Verdict.SHOWN not in figure.verdicts:
        good = True
    words = ", ".join(figure.verdicts) + (" (no reason given)" if figure.unexplained else "")
    return Line(spec.title, "; ".join(thesis), ours, between, extremes, words, good, remark(spec))


def _document(entry: Entry) -> dict[str, Any]:
    summary = entry.summary
    apart = summary.apart
    return {
        "run": summary.name.removeprefix("run_"),
        "title": summary.title,
        "report": entry.report or None,
        "sailed": summary.how,
        "seeds": list(summary.seeds),
        "failures": [{"seed": seed, "reason": why} for seed, why in summary.failures],
        "fingerprints": [outcome.fingerprint for outcome in summary.outcomes],
        "real_time_factor": summary.real_time_factor,
        "machine": summary.machine,
        "versions": dict(_first(summary).versions),
        "vessel": _first(summary).vessel,
        # Largest difference of graph and in process; null where it is infinite.
        "apart": None
        if apart is None
        else {"series": apart[0], "largest": apart[1] if math.isfinite(apart[1]) else None},
        "figures": [
            {
                "name": figure.spec.name,
                "title": figure.spec.title,
                "unit": figure.spec.unit,
                "thesis": figure.spec.thesis,
                "at_least": figure.spec.at_least,
                "at_most": figure.spec.at_most,
                "mean": figure.spread.mean,
                "low": figure.spread.low,
                "high": figure.spread.high,
                "least": figure.spread.least,
                "most": figure.spread.most,
                "missing": figure.spread.missing,
                "verdicts": [str(one) for one in figure.verdicts],
                "reason": figure.spec.reason,
                "source": figure.spec.source,
            }
            for figure in summary.figures()
        ],
    }


def _first(summary: RunSummary) -> RunInfo:
    return summary.outcomes[0].info if summary.outcomes else RunInfo("", "", "")


def index_facts(entries: Sequence[Entry]) -> list[tuple[str, str]]:
    """Return what is told at the head of the table."""
    figures = [figure for entry in entries for figure in entry.summary.figures()]
    found = [verdict for figure in figures for verdict in figure.verdicts]
    counts = [(verdict, found.count(verdict)) for verdict in Verdict]
    seeds = {len(entry.summary.seeds) for entry in entries}
    facts = [("Runs", str(len(entries))), ("Figures", str(len(figures)))]
    facts.append(("Seeds a run", " to ".join(dict.fromkeys((str(min(seeds)), str(max(seeds)))))))
    facts += [(str(verdict).capitalize(), str(count)) for verdict, count in counts if count]
    return facts


def index_machines(entries: Sequence[Entry]) -> str:
    """Return the machines that sailed them, as far as that is known."""
    return "; ".join(dict.fromkeys(entry.summary.machine for entry in entries if entry.summary.machine))


def index_versions(entries: Sequence[Entry]) -> str:
    """Return the versions that took part."""
    found: dict[str, dict[str, None]] = {}
    for entry in entries:
        for name, version in _first(entry.summary).versions.items():
            found.setdefault(name, {})[version] = None
    return " · ".join(f"{name} {' and '.join(versions)}" for name, versions in found.items())
