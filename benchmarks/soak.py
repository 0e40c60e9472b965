"""A long voyage of the composed graph: whether memory grows, and whether a sample takes ever longer.

Memory and times are read whenever so much simulated time has passed, never by the wall clock. Trends are medians of the
slopes of all pairs of readings (Theil and Sen) with their 95 % interval, so that a garbage collection or a busy moment
of the machine does not make or hide one.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import psutil
from scipy.stats import theilslopes

from benchmarks.plan import Plan
from benchmarks.result import Aim, Result
from dp_bringup.processes import Child
from dp_tools.graph_run import GraphRun
from dp_tools.run_files import Pace
from dp_tools.run_folder import RunFolder
from dp_tools.scenario import Event, Scenario
from marine_model import load_vessel
from marine_model.errors import DpError
from marine_model.guards import FloatArray

_MEGABYTE = 1e6
_MILLISECOND = 1e3
# Every so often (s) the vessel moves and the thrusters change between held and rotating: all of the ring is used.
_LEG = 100.0
# What caches, allocator arenas and just-in-time compilation have taken by then, they keep: a tenth of the voyage.
_WARM_UP = 0.1
_FEWEST_READINGS = 10


@dataclass(frozen=True, slots=True)
class Reading:
    """What one process shows at one simulated time: bytes and s."""

    simulated: float
    wall: float
    processor: float
    unique: int  # USS: pages of its own
    proportional: int  # PSS
    resident: int  # RSS


@dataclass(frozen=True, slots=True)
class Trend:
    """A slope over the readings after warm-up, taken over all of that time."""

    growth: float
    low: float
    high: float
    span: float  # s


class Log:
    """Reads the process of the graph once in every ``interval`` s of simulated time."""

    def __init__(self, interval: float, told: Callable[[float], None]) -> None:
        self._interval = interval
        self._told = told
        self._next = 0.0
        self._process: psutil.Process | None = None
        self.readings: list[Reading] = []

    def look(self, simulated: float) -> None:
        """Take a reading if one is due at this simulated time (s)."""
        self._told(simulated)
        if simulated < self._next or simulated <= 0.0:
            return
        self._next = (simulated // self._interval + 1.0) * self._interval
        if self._process is None:
            self._process = _graph()
        spent = self._process.cpu_times()
        memory = self._process.memory_full_info()
        self.readings.append(
            Reading(simulated, time.perf_counter(), spent.user + spent.system, memory.uss, memory.pss, memory.rss)
        )


def voyage(scenario: Scenario, seconds: float) -> Scenario:
    """Return ``scenario`` made ``seconds`` long, with a new set point and azimuth mode on every leg."""
    corners = ((0.0, 0.0, 0.0), (0.5, 0.0, 0.2), (0.5, 0.5, -0.2), (0.0, 0.5, 0.1))
    modes = ("fixed", "rotating")
    events = tuple(
        Event.model_validate(
            {
                "at": leg * _LEG,
                "setpoint": corners[leg % len(corners)],
                "parameters": {"thrust_allocator": {"azimuth_mode": modes[leg % len(modes)]}},
            }
        )
        for leg in range(int(seconds // _LEG) or 1)
    )
    return scenario.model_copy(update={"duration": seconds, "events": events})


def sail(plan: Plan, seconds: float, interval: float) -> list[Reading]:
    """Sail ``seconds`` of simulated time composed, in lockstep and without a limit of rate; return the readings.

    Raises
    ------
    DpError
        If the run fails, or was over before there were enough readings.
    """
    folder = RunFolder(plan.scratch / "soak")
    folder.prepare(overwrite=True)
    log = Log(interval, lambda simulated: plan.progress(round(simulated), round(seconds)))

    def arrived(running: Sequence[Child]) -> None:
        log.look(seconds)

    run = GraphRun(folder, plan.vessel, voyage(plan.scenario, seconds), Pace(True, 0.0), record=False, composed=True)
    run.sail(lambda text: None, log.look, arrived)
    shutil.rmtree(folder.path, ignore_errors=True)
    if len(log.readings) < _FEWEST_READINGS:
        raise DpError(f"soak: expected at least {_FEWEST_READINGS} readings, found {len(log.readings)}")
    return log.readings


def trend(at: FloatArray, values: FloatArray) -> Trend:
    """Return the growth of ``values``, shape (n,), over the simulated times ``at`` (s)."""
    slope, _, low, high = theilslopes(values, at, 0.95)
    span = float(at[-1] - at[0])
    return Trend(float(slope) * span, float(low) * span, float(high) * span, span)


def rise(values: FloatArray) -> float:
    """Return the median of the last tenth of ``values``, shape (n,), less that of the first tenth.

    Growth that ends half way has a median slope of nearly nothing, and is growth all the same.
    """
    tenth = max(1, len(values) // 10)
    return float(np.median(values[-tenth:]) - np.median(values[:tenth]))


def after_warm_up(readings: Sequence[Reading], seconds: float) -> list[Reading]:
    """Return the readings of the time in which nothing may grow any more."""
    return [reading for reading in readings if reading.simulated >= _WARM_UP * seconds]


def measure_soak(plan: Plan) -> list[Result]:
    """Measure growth of memory and of the time a sample takes.

    Raises
    ------
    DpError
        If the run fails.
    """
    seconds = plan.soak_seconds
    readings = sail(plan, seconds, plan.soak_interval)
    kept = after_warm_up(readings, seconds)
    at = np.array([reading.simulated for reading in kept])
    sample = load_vessel(plan.vessel).measurement.sample_time
    rows = []
    for name, field, aim in (
        # RSS is the process's alone; USS and PSS change with who else has the same libraries in memory.
        ("soak_memory_growth_rss", "resident", Aim("value", "<=", 1.0)),
        ("soak_memory_growth_uss", "unique", None),
        ("soak_memory_growth_pss", "proportional", None),
    ):
        values = np.array([getattr(reading, field) for reading in kept]) / _MEGABYTE
        found = trend(at, values)
        rows.append(
            Result(
                name,
                rise(values),
                "MB",
                aim=aim,
                note=f"slope {found.growth:.2f} MB over {found.span:.0f} s after {at[0]:.0f} s of warm-up; 95 % "
                f"interval {found.low:.2f} to {found.high:.2f}; {values[0]:.1f} MB then, "
                f"{values[-1]:.1f} MB in the end, {values.max():.1f} MB at most; {len(kept)} readings",
            )
        )
    middle = (at[1:] + at[:-1]) / 2.0
    for name, field, aim in (
        ("soak_sample_processor_time_drift", "processor", Aim("value", "<=", 5.0)),
        ("soak_sample_wall_time_drift", "wall", None),
    ):
        spent = np.array([getattr(reading, field) for reading in kept])
        cost = np.diff(spent) / np.diff(at) * sample * _MILLISECOND
        found = trend(middle, cost)
        typical = float(np.median(cost))
        rows.append(
            Result(
                name,
                100.0 * found.growth / typical,
                "%",
                aim=aim,
                note=f"of {typical:.2f} ms a sample in the median, over {found.span:.0f} s; 95 % interval "
                f"{100.0 * found.low / typical:.1f} to {100.0 * found.high / typical:.1f} %; "
                f"{quotient(kept):.1f} x real time",
            )
        )
    return rows


def quotient(readings: Sequence[Reading]) -> float:
    """Return simulated over wall time from the first to the last reading."""
    return (readings[-1].simulated - readings[0].simulated) / (readings[-1].wall - readings[0].wall)


def _graph() -> psutil.Process:
    for process in psutil.Process().children(recursive=True):
        if any(part.endswith("/composed") for part in process.cmdline()):
            return process
    raise DpError("soak: expected a process named composed, found none")
