"""How much is measured: the whole, or little of everything to see that it works."""

from __future__ import annotations

from collections.abc import Callable
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
    allocation_blocks: int  # blocks of steps of the allocator and its peers, each
    allocation_steps: int  # steps of the allocator a block; slow peers get the first of them
    sector_blocks: int  # the same for the problem with sectors
    sector_steps: int
    accuracy_instances: int  # random problems
    propulsion_thrusters: int  # in one step of the propulsion plant
    propulsion_blocks: int  # steps of all of them, each in turn with calls for one
    progress: Callable[[int, int], None] = lambda done, total: None  # told how much is done, and of what


def whole(scratch: Path) -> Plan:
    """Return the plan of `make bench`: nothing is shortened."""
    scenario = load_scenario("run_a")
    return Plan(scenario, scenario.vessel, scratch, 3, 5, 20, 250, 3, 20, 200, 10, 40, 1_000_000, 10_000, 100)


def quick(scratch: Path) -> Plan:
    """Return a plan that takes seconds; its figures say nothing but that they can be had."""
    scenario = load_scenario("run_a")
    events = tuple(event for event in scenario.events if event.at == 0.0)
    shortened = scenario.model_copy(update={"duration": 10.0, "events": events})
    return Plan(shortened, scenario.vessel, scratch, 1, 1, 2, 20, 1, 2, 20, 2, 5, 2_000, 100, 5)
