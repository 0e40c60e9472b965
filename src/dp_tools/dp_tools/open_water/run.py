"""A trial: controllers, plant, series; all cases side by side in one plant."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from dp_tools.open_water.record import QUANTITIES, CaseRecord, Record
from dp_tools.open_water.rig import controllers_of, held_thrust, rig_of
from dp_tools.open_water.trial import Trial
from marine_model.guards import FloatArray
from marine_model.propulsion import Propulsion
from thruster_drivers.shaft_model import shaft_models
from thruster_drivers.ventilation import AntiSpin, VentilationMonitor, VentilationState
from vessel_sim.propulsion import PlantTables, PropulsionPlant, columns

# Told of the progress this often, s of simulated time.
_REPORT_EVERY = 1.0

Progress = Callable[[float], None]


def run_trial(trial: Trial, progress: Progress | None = None) -> Record:
    """Return the series of all cases.

    The controllers see the shaft speed at the start of a step and their torque holds through it, as in the drivers.
    Losses to air lead their quasi-static values by the time shift of [Ruth] 2.3.2: the plant is given the submergence
    that comes then.

    Parameters
    ----------
    trial
        What is run. Every run of it gives the same numbers.
    progress
        Called with the simulated time (s) now and then.
    """
    rig = rig_of(trial)
    controllers = controllers_of(trial, rig)
    plant = PropulsionPlant.from_tables(PlantTables.of(rig))
    antispin = _LowLevel(trial, rig)
    t, dt, n = trial.instants, trial.time_step, len(trial.cases)
    steps = len(t) - 1
    demanded = _demanded(trial, rig, t)
    flow = trial.inflow.advance_speed(t)
    radius = 0.5 * rig.propeller_models[0].diameter
    shift = trial.ventilation.time_shift if trial.ventilation is not None else 0.0
    depth = np.zeros_like(t) if trial.submergence_ratio is None else radius * trial.submergence_ratio.at(t + shift)
    noise = np.random.default_rng(trial.seed).standard_normal((steps, n)) * trial.shaft_speed_noise

    still, here = np.zeros(n), np.ones(n)
    state = plant.state
    # A run begins with the shafts at speed, so that it is not the start-up that is measured.
    state[:, columns.SHAFT_SPEED] = _first_speed(trial, rig, demanded[0])
    plant.flood(flow[0] * here, depth[0] * here)
    torque, pitch = np.zeros(n), state[:, columns.PITCH_RATIO].copy()
    log = np.empty((steps, *state.shape))
    report = max(1, round(_REPORT_EVERY / dt))
    for k in range(steps):
        speed = state[:, columns.SHAFT_SPEED] + noise[k]
        measured_pitch = state[:, columns.PITCH_RATIO]
        seen = antispin.see(speed, torque, dt)
        for j, controller in enumerate(controllers):
            thrust = antispin.thrust(j, float(demanded[k, j]), seen, dt)
            output = controller.step(thrust, float(speed[j]), float(measured_pitch[j]), dt)
            torque[j] = antispin.torque(j, output.torque, seen)
            pitch[j] = output.pitch_ratio
        plant.step(torque, still, pitch, flow[k + 1] * here, depth[k + 1] * here, dt)
        log[k] = state
        torque = state[:, columns.MOTOR_TORQUE].copy()
        if progress is not None and k % report == 0:
            progress(t[k])
    if progress is not None:
        progress(trial.duration)
    submergence = None if trial.submergence_ratio is None else trial.submergence_ratio.at(t[1:])
    cases = {case.name: _case(log[:, j], demanded[1:, j]) for j, case in enumerate(trial.cases)}
    return Record(t[1:], flow[1:], submergence, cases)


def _demanded(trial: Trial, rig: Propulsion, t: FloatArray) -> FloatArray:
    """Return T_d, N, shape (k, cases)."""
    columns_of_cases = []
    for case, model in zip(trial.cases, shaft_models(rig), strict=True):
        held = held_thrust(case, model)
        if held is not None:
            columns_of_cases.append(np.full(t.shape, held))
        elif trial.thrust is not None:  # the trial makes sure of it
            columns_of_cases.append(trial.thrust.at(t))
    return np.column_stack(columns_of_cases)


def _first_speed(trial: Trial, rig: Propulsion, demanded: FloatArray) -> list[float]:
    """Return n, Hz, of every case at the demand that it starts with."""
    return [
        case.shaft_speed or model.shaft_speed(thrust)
        for case, model, thrust in zip(trial.cases, shaft_models(rig), demanded.tolist(), strict=True)
    ]


def _case(log: FloatArray, demanded: FloatArray) -> CaseRecord:
    speed, torque = log[:, columns.SHAFT_SPEED], log[:, columns.MOTOR_TORQUE]
    values = (
        demanded,
        log[:, columns.THRUST],
        speed,
        torque,
        2.0 * math.pi * speed * torque,
        log[:, columns.PITCH_RATIO],
        log[:, columns.THRUST_LOSS],
        log[:, columns.TORQUE_LOSS],
    )
    return CaseRecord(**{name: np.ascontiguousarray(value) for name, value in zip(QUANTITIES, values, strict=True)})


class _LowLevel:
    """Detection and anti-spin around the controllers of the cases that have it, as in the drivers."""

    def __init__(self, trial: Trial, rig: Propulsion) -> None:
        self._with = [case.anti_spin for case in trial.cases]
        self._monitor = VentilationMonitor(rig) if any(self._with) else None
        self._antispin = AntiSpin(rig, trial.anti_spin.model_copy(update={"enabled": True}))

    def see(self, speed: FloatArray, torque: FloatArray, dt: float) -> VentilationState | None:
        return None if self._monitor is None else self._monitor.step(speed, torque, dt)

    def thrust(self, j: int, demanded: float, seen: VentilationState | None, dt: float) -> float:
        if seen is None or not self._with[j]:
            return demanded
        return self._antispin.thrust(j, demanded, bool(seen.ventilating[j]), float(seen.beta_q[j]), dt)

    def torque(self, j: int, torque: float, seen: VentilationState | None) -> float:
        if seen is None or not self._with[j]:
            return torque
        return self._antispin.torque(j, torque, float(seen.torque[j]), float(seen.shaft_speed[j]))
