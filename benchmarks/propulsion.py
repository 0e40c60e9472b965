"""One step of the propulsion plant for a great many thrusters, beside calls for one thruster at a time."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from benchmarks.mixed_propellers import with_every_model
from benchmarks.plan import Plan
from benchmarks.result import Aim, Result
from benchmarks.statistics import Summary, summarize
from benchmarks.threads import Threads
from marine_model import load_vessel
from marine_model.guards import FloatArray
from vessel_sim.propulsion import PlantTables, PropulsionPlant, columns
from vessel_sim.propulsion.step import advance

_SEED = 31
_STEP = 0.02  # s
_DEPTHS = (-0.5, 2.0)  # of the shafts, in diameters: from out of the water to covered well
_FLOWS = (-0.3, 0.6)  # m/s
_SINGLE_CALLS = 50  # of one thruster after another, a block
_SCALAR_CALLS = 10
_COMPARED = 10  # steps, thruster by thruster
_OWN = "own"  # the thrusters of the vessel as they are: what the aim is for
_AIM = Aim("ratio", "<=", 1.0 / 50.0)
_Inputs = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
_SAME = Aim("value", "<=", 1e-12)


@dataclass(frozen=True, slots=True)
class _Sea:
    """Inputs of some steps of many thrusters: arrays of shape (steps, n)."""

    torque: FloatArray
    azimuth_rate: FloatArray
    pitch_ratio: FloatArray
    advance_speed: FloatArray
    submergence: FloatArray

    def at(self, step: int, rows: slice) -> _Inputs:
        """Return the inputs of one step, in the order in which a plant takes them."""
        return (
            self.torque[step, rows],
            self.azimuth_rate[step, rows],
            self.pitch_ratio[step, rows],
            self.advance_speed[step, rows],
            self.submergence[step, rows],
        )


def measure_propulsion(plan: Plan) -> list[Result]:
    """Measure the thrusters of the vessel, every propeller model by itself and all together, ventilation on."""
    vessel = load_vessel(plan.vessel)
    own, tables = PlantTables.of(vessel), PlantTables.of(with_every_model(vessel))
    kinds = len(tables.names)
    everyone = list(range(kinds))
    choices: list[tuple[str, PlantTables, list[int]]] = [(_OWN, own, everyone), ("mixed", tables, everyone)]
    models = ("bollard", "wageningen_b", "tabulated", "four_quadrant")
    choices += [(name, tables, everyone[k :: len(models)]) for k, name in enumerate(models)]
    results = []
    for done, (name, rows, members) in enumerate(choices):
        many = rows.rows(np.resize(members, plan.propulsion_thrusters))
        results += _measure(name, many, len(members), plan)
        plan.progress(done + 1, len(choices))
    return results


def _measure(name: str, tables: PlantTables, kinds: int, plan: Plan) -> list[Result]:
    count = len(tables.names)
    blocks = plan.propulsion_blocks
    sea = _random_sea(tables, blocks)
    everyone = slice(0, count)
    fleet, one_thread = PropulsionPlant.from_tables(tables), PropulsionPlant.from_tables(tables)
    threads = Threads()
    fleet.spread = threads
    singles = [PropulsionPlant.from_tables(tables.rows([i])) for i in range(kinds)]
    for plant in (fleet, one_thread):
        plant.step(*sea.at(0, everyone), _STEP)  # machine code is made or loaded
    for i, single in enumerate(singles):
        single.step(*sea.at(0, slice(i, i + 1)), _STEP)
        _from_python(tables, i, sea.at(0, slice(i, i + 1)))
    together: list[float] = []
    in_one_thread: list[float] = []
    alone, scalar = [], []
    for k in range(1, blocks):
        inputs = sea.at(k, everyone)
        for plant, times in ((fleet, together), (one_thread, in_one_thread)):
            begin = time.perf_counter()
            plant.step(*inputs, _STEP)
            times.append((time.perf_counter() - begin) / count)
        # In turn with the step of all: other work on the machine slows both down.
        for i, single in enumerate(singles):
            own = sea.at(k, slice(i, i + 1))
            begin = time.perf_counter()
            single.step(*own, _STEP)
            for _ in range(_SINGLE_CALLS):
                single.step(*own, _STEP)
            alone.append((time.perf_counter() - begin) / (_SINGLE_CALLS + 1))
            scalar.append(_from_python(tables, i, own))
    threads.close()
    one, other, functions = summarize(together), summarize(alone), summarize(scalar)
    by_itself = summarize(in_one_thread)
    return [
        Result(
            f"propulsion_step_{name}",
            1e9 * one.median,
            "ns a thruster",
            "the call for one thruster",
            1e9 * other.median,
            _AIM if name == _OWN else None,
            f"{count} thrusters in a step, {threads.count} threads, ventilation on; {_spread(one)}; "
            f"one thruster {_spread(other)}",
        ),
        Result(
            f"propulsion_step_{name}_in_one_thread",
            1e9 * by_itself.median,
            "ns a thruster",
            "the call for one thruster",
            1e9 * other.median,
            None,
            f"the same in the thread of the caller alone; {_spread(by_itself)}",
        ),
        Result(
            f"propulsion_step_{name}_against_functions",
            1e9 * one.median,
            "ns a thruster",
            "its scalar functions called one by one from Python",
            1e9 * functions.median,
            None,
            f"shaft, actuators, load, losses, thrust of one thruster; {_spread(functions)}",
        ),
        Result(
            f"propulsion_agreement_{name}",
            _difference(tables, sea, min(plan.propulsion_blocks, _COMPARED)),
            "relative",
            aim=_SAME,
            note="largest difference in the state between the step of all and a plant for one thruster alone",
        ),
    ]


def _from_python(tables: PlantTables, i: int, own: _Inputs) -> float:
    """Return the time (s) of a step of thruster ``i`` whose loop body is Python, and what it calls machine code."""
    row = slice(i, i + 1)
    state, inputs = tables.start[row].copy(), np.array(own)
    in_python = advance.py_func  # type: ignore[attr-defined]
    begin = time.perf_counter()
    for _ in range(_SCALAR_CALLS):
        in_python(tables.parameters[row], tables.propellers, tables.ventilation, state, inputs, inputs, 0, True, _STEP)
    return (time.perf_counter() - begin) / _SCALAR_CALLS


def _random_sea(tables: PlantTables, steps: int) -> _Sea:
    """Return inputs that go all the way: both directions, in and out of the water."""
    draw = np.random.default_rng(_SEED)
    shape = (steps, len(tables.names))
    parameters, own = tables.parameters, tables.start[:, columns.PITCH_RATIO]
    pitch = draw.uniform(0.6, 1.2, shape)
    return _Sea(
        draw.uniform(-1.0, 1.0, shape) * parameters[:, columns.TORQUE_MAX],
        draw.uniform(-1.0, 1.0, shape),
        np.where(parameters[:, columns.CONTROLLABLE] != 0.0, pitch, own),
        draw.uniform(*_FLOWS, shape),
        draw.uniform(*_DEPTHS, shape) * parameters[:, columns.DIAMETER],
    )


def _difference(tables: PlantTables, sea: _Sea, steps: int) -> float:
    """Return the largest difference over ``steps`` steps, relative to the largest value of its column."""
    count = len(tables.names)
    fleet = PropulsionPlant.from_tables(tables)
    for k in range(steps):
        fleet.step(*sea.at(k, slice(0, count)), _STEP)
    scale = np.maximum(np.abs(fleet.state).max(axis=0), 1.0)
    worst = 0.0
    for i in range(count):
        single = PropulsionPlant.from_tables(tables.rows([i]))
        for k in range(steps):
            single.step(*sea.at(k, slice(i, i + 1)), _STEP)
        worst = max(worst, float((np.abs(single.state[0] - fleet.state[i]) / scale).max()))
    return worst


def _spread(summary: Summary) -> str:
    return f"median {1e9 * summary.median:.0f} ns, p99 {1e9 * summary.p99:.0f} ns"
