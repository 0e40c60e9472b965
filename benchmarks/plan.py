"""How much is measured: the whole, or little of everything to see that it works."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dp_tools.scenario import Scenario, load_scenario


@dataclass(frozen=True, slots=True)
class Plan:
    """Amounts, chosen in one place."""

    scenario: Scenario
    vessel: str
    scratch: Path  # run folders
    graph_runs: int  # repetitions of a lockstep run, each
    loop_runs: int  # repetitions of the in-process loop and of its peers, each
    hop_blocks: int  # blocks of requests, each
    hop_requests: int  # requests a block
    start_ups: int  # each


def whole(scratch: Path) -> Plan:
    """Return the plan of `make bench`: nothing is shortened."""
    scenario = load_scenario("run_a")
    return Plan(scenario, scenario.vessel, scratch, 3, 5, 20, 250, 3)


def quick(scratch: Path) -> Plan:
    """Return a plan that takes seconds; its figures say nothing but that they can be had."""
    scenario = load_scenario("run_a")
    events = tuple(event for event in scenario.events if event.at == 0.0)
    shortened = scenario.model_copy(update={"duration": 10.0, "events": events})
    return Plan(shortened, scenario.vessel, scratch, 1, 1, 2, 20, 1)
