"""Which scenarios are meant, and with which seeds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from dp_tools.run_folder import FolderError, RunFolder, make_writable
from dp_tools.scenario import Scenario, load_scenario, scenario_names, scenario_path
from marine_model import Vessel
from marine_model.errors import InputError

ALL = "all"
_RUN = re.compile(r"run_[a-z]")


@dataclass(frozen=True)
class RunPlan:
    """One scenario, the file it is loaded from, its seeds (bag and report of the first are kept), and its folder.

    For a vessel of another scale the scenario is a scaled one, which no file holds.
    """

    scenario: Scenario
    file: Path
    seeds: tuple[int, ...]
    folder: Path


def plan(
    names: Sequence[str],
    vessel: Vessel | None,
    seeds: Sequence[int],
    repeat: int,
    output: Path,
    overwrite: bool,
) -> tuple[RunPlan, ...]:
    """Return what to sail, and make the folders.

    Parameters
    ----------
    names
        Names or paths of scenarios; ``a`` for ``run_a``; ``all`` for every run of the thesis.
    vessel
        To sail instead of the scenarios' own; None for those.
    seeds
        Empty for the scenario's own and, with ``repeat``, those that follow it.
    repeat
        Number of seeds a scenario, where they are not given.
    output
        Folder with one folder a run.
    overwrite
        True to replace recordings that are there.

    Raises
    ------
    InputError
        If a scenario or seed is named twice.
    DpError
        If a scenario is unknown or not valid, or a folder cannot be written or holds a recording.
    """
    known = scenario_names() if ALL in names else ()
    files = [file for name in names for file in (_thesis(known) if name == ALL else [_long(name)])]
    plans = []
    for file in files:
        scenario = load_scenario(file, vessel)
        own = tuple(seeds) or tuple(range(scenario.seed, scenario.seed + repeat))
        plans.append(RunPlan(scenario, scenario_path(file).absolute(), own, output / scenario.name))
    for what, found in (("scenario", [one.scenario.name for one in plans]), ("seed", list(map(str, seeds)))):
        twice = sorted({one for one in found if found.count(one) > 1})
        if twice:
            raise InputError(f"{what}: expected every one once, found {', '.join(twice)} more than once")
    for one in plans:
        bag = RunFolder(one.folder).bag
        if bag.exists() and not overwrite:
            raise FolderError(f"{bag}: holds a recording; choose another --output, or --overwrite it")
        make_writable(one.folder)
    return tuple(plans)


def _thesis(known: Sequence[str]) -> list[str]:
    return [name for name in known if _RUN.fullmatch(name)]


def _long(name: str) -> str:
    return f"run_{name}" if len(name) == 1 and name.isalpha() else name
