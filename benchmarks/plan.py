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
    sea_components: int  # of the irregular sea
    sea_runs: int  # repetitions in it, each
    sea_seconds: float  # of simulated time that the peer sails in it
    hop_blocks: int  # blocks of requests, each
    hop_requests: int  # requests a block
    record_seconds: float  # of messages for the recorder
    start_ups: int  # each
    allocation_blocks: int  # blocks of steps of the allocator and its peers, each
    allocation_steps: int  # steps of the allocator a block; slow peers get the first of them
    sector_blocks: int  # the same for the problem with sectors
    sector_steps: int
    accuracy_instances: int  # random problems
    load_seconds: float  # of real time in which the drivers' processor time is counted
    propulsion_thrusters: int  # in one step of the propulsion plant
    propulsion_blocks: int  # steps of all of them, each in turn with calls for one
    progress: Callable[[int, int], None] = lambda done, total: None  # told how much is done, and of what


def whole(scratch: Path) -> Plan:
    """Return the plan of `make bench`: nothing is shortened."""
    scenario = load_scenario("run_a")
    return Plan(
        scenario=scenario,
        vessel=scenario.vessel,
        scratch=scratch,
        graph_runs=3,
        loop_runs=5,
        sea_components=100,
        sea_runs=3,
        sea_seconds=2.0,
        hop_blocks=20,
        hop_requests=250,
        record_seconds=20.0,
        start_ups=3,
        allocation_blocks=20,
        allocation_steps=200,
        sector_blocks=10,
        sector_steps=40,
        accuracy_instances=1_000_000,
        load_seconds=30.0,
        propulsion_thrusters=10_000,
        propulsion_blocks=100,
    )


def quick(scratch: Path) -> Plan:
    """Return a plan that takes seconds; its figures say nothing but that they can be had."""
    scenario = load_scenario("run_a")
    events = tuple(event for event in scenario.events if event.at == 0.0)
    return Plan(
        scenario=scenario.model_copy(update={"duration": 10.0, "events": events}),
        vessel=scenario.vessel,
        scratch=scratch,
        graph_runs=1,
        loop_runs=1,
        sea_components=10,
        sea_runs=1,
        sea_seconds=0.2,
        hop_blocks=2,
        hop_requests=20,
        record_seconds=1.0,
        start_ups=1,
        allocation_blocks=2,
        allocation_steps=20,
        sector_blocks=2,
        sector_steps=5,
        accuracy_instances=2_000,
        load_seconds=4.0,
        propulsion_thrusters=100,
        propulsion_blocks=5,
    )
