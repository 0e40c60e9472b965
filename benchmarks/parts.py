"""Where the processor time of the in-process loop goes: by core, and within the simulator's step."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.plan import Plan
from benchmarks.result import Result
from benchmarks.sea import in_a_sea
from dp_controller import Controller
from dp_observer import Observer
from dp_tools.in_process import ClosedLoop
from dp_tools.scenario import Scenario
from marine_model import Vessel, load_vessel
from marine_model.compiled import compiled
from thrust_allocator import Allocator
from thruster_drivers import Drivers
from vessel_sim import Simulator, simulator
from vessel_sim.inflow import inflow
from vessel_sim.propulsion.step import advance_rows
from vessel_sim.sail import sail
from vessel_sim.waves.drift import drift_force

UNIT = "ms of processor time a simulated second"
_CORES: dict[str, list[tuple[type, str]]] = {
    "simulator_step": [(Simulator, "step")],
    "simulator_truth_and_pose": [(Simulator, "truth"), (Simulator, "measure")],
    "observer": [(Observer, "step")],
    "controller": [(Controller, "step")],
    "allocator": [(Allocator, "step")],
    "drivers": [(Drivers, "step")],
}
_KEEP_EVERY = 500  # steps between two whose arguments are kept
_REPEATS = 200  # of a function that takes less than a clock


class _Clock:
    """Processor time within functions, less that of looking at the clock."""

    def __init__(self) -> None:
        self._spent: dict[str, float] = {}
        self._calls: dict[str, int] = {}
        self.cost = _cost_of_a_look()

    def of(self, name: str) -> float:
        """Return the time within ``name``, s."""
        return self._spent.get(name, 0.0) - self.cost * self._calls.get(name, 0)

    @property
    def overhead(self) -> float:
        """What looking at the clock took, twice a call, s."""
        return 2.0 * self.cost * sum(self._calls.values())

    @contextmanager
    def watch(self, name: str, owner: type, attribute: str) -> Iterator[None]:
        """Count the time within ``owner.attribute`` as ``name``."""
        function = getattr(owner, attribute)

        def timed(*arguments: Any) -> Any:
            begin = time.thread_time()
            found = function(*arguments)
            self._spent[name] = self._spent.get(name, 0.0) + time.thread_time() - begin
            self._calls[name] = self._calls.get(name, 0) + 1
            return found

        with patch.object(owner, attribute, timed):
            yield


def _cost_of_a_look() -> float:
    begin = time.thread_time()
    for _ in range(10_000):
        time.thread_time()
    return (time.thread_time() - begin) / 10_000


@compiled
def _drifts(components: Any, response: Any, position: Any, time: float, count: int) -> float:
    total = 0.0
    for i in range(count):
        total += drift_force(components, response, position, time + 1e-3 * i)[0]
    return total


@compiled
def _inflows(
    components: Any, response: Any, decay: Any, thrusters: Any, position: Any, azimuth: Any, time: float, count: int
) -> float:
    total = 0.0
    still = (0.0, 0.0, 0.0)
    for i in range(count):
        depth, _ = inflow(components, response, decay, thrusters, position, still, (0.0, 0.0), azimuth, time + 1e-3 * i)
        total += depth[0]
    return total


@compiled
def _advances(
    parameters: Any, propellers: Any, ventilation: Any, state: Any, inputs: Any, ventilates: bool, dt: float, count: int
) -> None:
    for _ in range(count):
        advance_rows(parameters, propellers, ventilation, state, inputs, ventilates, dt, 0, state.shape[0])


def measure_parts(plan: Plan) -> list[Result]:
    """Sail the scenario as it is, and in a sea, and count the processor time of every part."""
    vessel = load_vessel(plan.vessel)
    results = []
    for suffix, scenario in (("", plan.scenario), ("_in_sea", in_a_sea(plan.scenario, plan.sea_components))):
        for name, value, note in _parts(scenario, vessel):
            results.append(Result(f"processor_time_{name}{suffix}", 1e3 * value / scenario.duration, UNIT, note=note))
    return results


def _parts(scenario: Scenario, vessel: Vessel) -> list[tuple[str, float, str]]:
    """Return name, processor time (s) and note of every part; the indented are shares of the simulator's step."""
    kept: list[tuple[Any, ...]] = []
    count = 0

    def keeping(*arguments: Any) -> int:
        nonlocal count
        if count % _KEEP_EVERY == 0:
            kept.append(tuple(np.copy(a) if isinstance(a, np.ndarray) else a for a in arguments))
        count += 1
        return sail(*arguments)

    # Once for what the steps are given; machine code is loaded then, too.
    with patch.object(simulator, "sail", keeping):
        ClosedLoop(vessel, scenario).run()
    loop, clock = ClosedLoop(vessel, scenario), _Clock()
    with ExitStack() as watched:
        for name, functions in _CORES.items():
            for owner, attribute in functions:
                watched.enter_context(clock.watch(name, owner, attribute))
        begin = time.thread_time()
        loop.run()
        total = time.thread_time() - begin
    waves, water, thrusters = (count * _mean(kept, once) for once in (_time_drift, _time_inflow, _time_thrusters))
    cores = {name: clock.of(name) for name in _CORES}
    rest = total - sum(cores.values()) - clock.overhead
    step = cores.pop("simulator_step")
    return [
        ("simulator_step", step, f"{count} steps, {1e6 * step / count:.1f} us each; of which:"),
        ("simulator_drift", waves, "drift force, twice a step"),
        ("simulator_water", water, "first-order motion, submergence and speed of advance"),
        ("simulator_thrusters", thrusters, "shafts, azimuths, propellers, ventilation"),
        ("simulator_hull_and_calls", step - waves - water - thrusters, "hull, set points, sensors, calls"),
        *((name, value, "") for name, value in cores.items()),
        ("loop_and_log", rest, "the loop itself and what it logs in memory"),
    ]


def _mean(kept: list[tuple[Any, ...]], once: Callable[[tuple[Any, ...]], float]) -> float:
    """Return the mean time of one step's part over the kept steps, s; the first is done once more, for the caches."""
    once(kept[0])
    return float(np.mean([once(arguments) for arguments in kept]))


def _seconds(function: Callable[[], Any]) -> float:
    begin = time.thread_time()
    function()
    return (time.thread_time() - begin) / _REPEATS


# Arguments of ``sail``: hull, motion, outside, components, response, decay, thrusters, parameters, propellers,
# ventilation, state, inputs, before, ventilates, flowing, time, dt.


def _time_drift(a: tuple[Any, ...]) -> float:
    place = tuple(a[1][:3].tolist())
    return 2.0 * _seconds(lambda: _drifts(a[3], a[4], place, a[15], _REPEATS))


def _time_inflow(a: tuple[Any, ...]) -> float:
    place, azimuth = tuple(a[1][:3].tolist()), np.zeros(len(a[6]))
    return _seconds(lambda: _inflows(a[3], a[4], a[5], a[6], place, azimuth, a[15], _REPEATS))


def _time_thrusters(a: tuple[Any, ...]) -> float:
    return _seconds(lambda: _advances(a[7], a[8], a[9], a[10], a[11], a[13], a[16], _REPEATS))
