"""Confusion table of one method of detection."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dp_tools.detection_campaign.bench import Record
from dp_tools.signals import runs_of
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thruster_drivers import DriverSettings

EVENT_LENGTH = 0.5  # s; shorter ones are not asked for
SAMPLES = 2  # of the control system, within which an event is to be found
_ROUNDING = 1e-9  # s


@dataclass(frozen=True, slots=True)
class DetectionTable:
    """Confusion table of one method, all thrusters that it watches together.

    An event is a time longer than ``EVENT_LENGTH`` in which air leaves a share of the torque below the threshold ``on``
    while |n| > n_min.

    Attributes
    ----------
    method
        ``ventilation.method``.
    own_sample
        s between two decisions of the method: the simulator's step, or the control system's sample.
    hours
        Simulated time times the number of thrusters watched.
    events
        How many there were.
    found
        Of these: flagged before they ended.
    found_in_time
        Of these: flagged within ``SAMPLES`` samples of the control system.
    missed
        Events less ``found``.
    flags
        How often a flag went up.
    early
        Flags that went up while the true share was between ``on`` and ``off``: neither wet nor ventilating.
    false_alarms
        Flags that went up after the true share had been above ``off`` for ``SAMPLES`` samples.
    delays
        Shape (found,): s from the start of an event to its flag; 0 where the flag was up already.
    speeds
        Shape (events,): mean |n| of every event, Hz.
    depths
        Shape (events,): least true share of every event.
    in_time
        Shape (events,): whether it was found in time.
    """

    method: str
    own_sample: float
    hours: float
    events: int
    found: int
    found_in_time: int
    missed: int
    flags: int
    early: int
    false_alarms: int
    delays: FloatArray
    speeds: FloatArray
    depths: FloatArray
    in_time: NDArray[np.bool_]

    @property
    def delays_in_own_samples(self) -> FloatArray:
        """``delays`` in whole samples of the method itself, shape (found,)."""
        return np.asarray(np.ceil(self.delays / self.own_sample - _ROUNDING / self.own_sample))


def tabulate(vessel: Vessel, record: Record, settings: DriverSettings | None = None) -> DetectionTable:
    """Compare flags with the truth.

    Raises
    ------
    InputError
        If the vessel has no section ``drivers.ventilation``.
    """
    ventilation = (settings or DriverSettings()).ventilation
    on, off, speed_min, excluded = ventilation.resolved(vessel)
    dt, sample = vessel.simulation.time_step, vessel.measurement.sample_time
    allowed = SAMPLES * sample
    back = round(allowed / dt)
    # A thruster that cannot reach n_min is not watched.
    fastest = vessel.propellers.shaft_speed(np.maximum(vessel.thrust_max, -vessel.thrust_min))
    watched = [j for j, least in enumerate(speed_min) if fastest[j] > least and not excluded[j]]
    delays: list[float] = []
    speeds: list[float] = []
    depths: list[float] = []
    in_time: list[bool] = []
    flags = early = false_alarms = 0
    for j in watched:
        left, size, flag = record.torque_loss[:, j], np.abs(record.shaft_speed[:, j]), record.ventilating[:, j]
        for start, end in runs_of((left < on) & (size > speed_min[j])):
            if (end - start) * dt <= EVENT_LENGTH + _ROUNDING:
                continue
            up = np.flatnonzero(flag[start:end])
            if up.size:
                delays.append(float(up[0]) * dt)
            in_time.append(bool(up.size) and delays[-1] <= allowed + _ROUNDING)
            speeds.append(float(size[start:end].mean()))
            depths.append(float(left[start:end].min()))
        for start, _ in runs_of(flag):
            flags += 1
            past = left[max(0, start - back) : start + 1]
            if past.min() > off:
                false_alarms += 1
            elif past.min() >= on:
                early += 1
    return DetectionTable(
        method=ventilation.method,
        own_sample=dt if ventilation.method == "torque_rate" else sample,
        hours=len(record.torque_loss) * dt / 3600.0 * len(watched),
        events=len(in_time),
        found=len(delays),
        found_in_time=sum(in_time),
        missed=len(in_time) - len(delays),
        flags=flags,
        early=early,
        false_alarms=false_alarms,
        delays=np.array(delays),
        speeds=np.array(speeds),
        depths=np.array(depths),
        in_time=np.array(in_time, dtype=np.bool_),
    )


def merge(tables: Iterable[DetectionTable]) -> DetectionTable:
    """Return the sum of ``tables``, all of one method.

    Raises
    ------
    InputError
        If there is none, or they are of several methods.
    """
    parts = tuple(tables)
    methods = {(part.method, part.own_sample) for part in parts}
    if len(methods) != 1:
        raise InputError(f"tables: expected some, of one method, found {sorted(methods) or 'none'}")
    method, own_sample = methods.pop()
    return DetectionTable(
        method=method,
        own_sample=own_sample,
        hours=sum(part.hours for part in parts),
        events=sum(part.events for part in parts),
        found=sum(part.found for part in parts),
        found_in_time=sum(part.found_in_time for part in parts),
        missed=sum(part.missed for part in parts),
        flags=sum(part.flags for part in parts),
        early=sum(part.early for part in parts),
        false_alarms=sum(part.false_alarms for part in parts),
        delays=np.concatenate([part.delays for part in parts]),
        speeds=np.concatenate([part.speeds for part in parts]),
        depths=np.concatenate([part.depths for part in parts]),
        in_time=np.concatenate([part.in_time for part in parts]),
    )
