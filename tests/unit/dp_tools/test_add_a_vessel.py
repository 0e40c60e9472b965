"""docs/add_a_vessel.md: its commands work, and its ship holds her station, also without one thruster."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from dp_tools.figures import compute_figures
from dp_tools.in_process import ClosedLoop
from dp_tools.scenario import load_scenario
from marine_model import load_vessel
from support.dp_here import Dp, dp_here
from support.repository import ROOT, SCENARIOS

__all__ = ["dp_here"]

PAGE = (ROOT / "docs" / "add_a_vessel.md").read_text(encoding="utf-8")


def commands() -> list[list[str]]:
    """Return the commands of the page in its order: lines of code, then those within sentences."""
    lines = re.findall(r"^ +((?:dp|cp) .*)$", PAGE, re.MULTILINE)
    within = [" ".join(text.split()) for text in re.findall(r"`(dp [^`]*)`", PAGE)]
    return [shlex.split(line) for line in lines + within]


def test_commands_of_the_page(dp_here: Dp, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All but `dp up`, which tests/system does; here its files are loaded, and its options known."""
    monkeypatch.chdir(tmp_path)
    done = set()
    for name, *words in commands():
        if name == "cp":
            shutil.copy(ROOT / words[0], tmp_path / words[1])
            continue
        done.add(words[0] if words[0] != "vessel" else f"vessel {words[1]}")
        if words[0] == "up":
            options = dict(re.findall(r"--(vessel|scenario) (\S+)", " ".join(words)))
            ship = load_vessel(options["vessel"])
            load_scenario(SCENARIOS / f"{options['scenario']}.yaml", ship)
            code, shown = dp_here("up", "--help")
            assert code == 0
            for word in words:
                assert not word.startswith("--") or word in shown, word
            continue
        if words[1:] == ["VESSEL"]:
            continue
        code, output = dp_here(*words)
        assert code == 0, output
    assert done == {"vessel check", "vessel list", "vessel scale", "design", "propeller", "up"}


def test_the_drillship_holds_her_station_and_loses_a_thruster() -> None:
    """Her scenario up to the first loss and 200 s beyond, with the bounds that it sets itself."""
    scenario = load_scenario(SCENARIOS / "drillship_station_keeping.yaml")
    short = scenario.model_copy(
        update={
            "duration": 800.0,
            "events": tuple(event for event in scenario.events if event.at < 800.0),
            "windows": scenario.windows | {"first_loss": (600.0, 800.0)},
            "figures": tuple(f for f in scenario.figures if f.name.endswith(("_all", "_first", "violations"))),
        }
    )
    ship = load_vessel(scenario.vessel)
    run = ClosedLoop(ship, short).run()
    figures = {figure.spec.name: figure for figure in compute_figures(run, short, ship)}
    assert len(figures) == 9
    for name, figure in figures.items():
        assert figure.held is not False, f"{name}: {figure.value}"
    # The lost thruster gives nothing, and the others give more.
    lost = ship.thruster_names.index("bow_starboard")
    thrust = run["thrust_command"].window(700.0, 800.0).values
    assert (thrust[:, lost] == 0.0).all()
    power_change = figures["power_change_first"].value
    assert power_change is not None
    assert power_change > 0.0
