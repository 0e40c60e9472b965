"""Ventilation and a moderate sea in shards, in one process a core."""

from __future__ import annotations

import math
import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed

import numpy as np

from dp_tools.detection_campaign.bench import sail
from dp_tools.detection_campaign.table import DetectionTable, merge, tabulate
from dp_tools.detection_campaign.trials import moderate_sea_trial, ventilation_trial
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import positive_number
from thruster_drivers import DriverSettings

METHODS = ("torque_rate", "shaft_deceleration")
_SHARD = 900.0  # s, each from rest with a seed of its own, so that results do not depend on the number of processes
_VENTILATION, _SEA = range(2)


def campaign(
    vessel: Vessel,
    method: str,
    duration: float = 3600.0,
    seed: int = 0,
    *,
    settings: DriverSettings | None = None,
    processes: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[DetectionTable, DetectionTable]:
    """Return the tables of half of ``duration`` of ventilation and of ``duration`` of moderate sea without it.

    Parameters
    ----------
    vessel
        With ``drivers.ventilation`` and ``ventilation``.
    method
        ``ventilation.method``, one of ``METHODS``.
    duration
        s.
    seed
        Of everything random.
    settings
        Of the drivers; ``method`` takes the place of theirs.
    processes
        At most so many at once; 1 starts none. None: one a core, but no more than shards' worth of time, because to
        start one takes about as long as half a shard.
    progress
        Called with the shards done and the number of all, after each.

    Raises
    ------
    InputError
        If the vessel lacks a section that is needed, the settings do not fit it, ``method`` is none of the drivers',
        or a number is out of its range.
    """
    if method not in METHODS:
        raise InputError(f"method: expected {' or '.join(METHODS)}, found '{method}'")
    positive_number("duration", duration)
    base = settings or DriverSettings()
    chosen = base.model_copy(update={"ventilation": base.ventilation.model_copy(update={"method": method})})
    shards = [
        (vessel, chosen, trial, length, (seed, trial, i))
        for trial, total in ((_VENTILATION, 0.5 * duration), (_SEA, duration))
        for i, length in enumerate(_lengths(total))
    ]
    tables: dict[int, DetectionTable] = {}

    def take(which: int, table: DetectionTable) -> None:
        tables[which] = table
        if progress is not None:
            progress(len(tables), len(shards))

    worthwhile = min(len(os.sched_getaffinity(0)), math.ceil(1.5 * duration / _SHARD))
    workers = min(processes or worthwhile, len(shards))
    if workers == 1:
        for which, shard in enumerate(shards):
            take(which, _sail(*shard))
    else:
        # Processes started anew: a copy of this one would share its threads' locks.
        with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
            tasks = {pool.submit(_sail, *shard): which for which, shard in enumerate(shards)}
            for task in as_completed(tasks):
                take(tasks[task], task.result())
    ventilation, sea = (
        merge(tables[which] for which, shard in enumerate(shards) if shard[2] == trial)
        for trial in (_VENTILATION, _SEA)
    )
    return ventilation, sea


def _lengths(total: float) -> list[float]:
    """Cut ``total`` (s) into equal shards."""
    count = math.ceil(total / _SHARD)
    return [total / count] * count


def _sail(
    vessel: Vessel, settings: DriverSettings, trial: int, length: float, seed: tuple[int, int, int]
) -> DetectionTable:
    # Trial and noise draw from streams of their own.
    surroundings, noise = np.random.SeedSequence(seed).generate_state(2, np.uint64).tolist()
    if trial == _VENTILATION:
        _, _, speed_min, _ = settings.ventilation.resolved(vessel)
        water = ventilation_trial(vessel, length, surroundings, speed_min)
    else:
        water = moderate_sea_trial(vessel, length, surroundings)
    return tabulate(vessel, sail(vessel, water, settings, noise), settings)
