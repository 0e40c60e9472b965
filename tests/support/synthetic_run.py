"""A made-up run for tests of figures and report: plausible shapes, known statistics. Not a model of anything."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dp_tools.run_data import Labels, RunData, RunInfo, Series
from marine_model import Vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray

SAMPLE = 0.2
FEEDBACK = 0.02
POWER = {"fixed": 4.0, "rotating": 2.5}  # W a thruster, constant but for a known ripple
SWITCH = 206.0


def rows_at(t: FloatArray, tf: FloatArray) -> NDArray[np.intp]:
    """Return the row of the newest feedback at every sample."""
    return np.searchsorted(tf, t + 1e-9, side="right") - 1


def synthetic_run(vessel: Vessel, duration: float = 380.0, seed: int = 0) -> RunData:
    rng = np.random.default_rng(seed)
    n = len(vessel.thrusters)
    t = np.arange(round(duration / SAMPLE)) * SAMPLE
    tf = np.arange(round(duration / FEEDBACK)) * FEEDBACK
    slow = np.column_stack([np.sin(0.13 * t), np.sin(0.11 * t + 1.0), np.sin(0.07 * t + 2.0)])
    reference = np.zeros((len(t), 3))
    truth = reference + slow * [0.01, 0.008, math.radians(0.4)]
    waves = np.column_stack([0.02 * np.sin(7.85 * t), 0.002 * np.sin(7.85 * t), 0.004 * np.sin(7.85 * t)])
    estimate = truth + rng.normal(0.0, [0.001, 0.001, 0.0005], (len(t), 3))
    tau = slow * [1.5, 0.6, 0.3] + [2.0, 0.0, 0.0]
    ramp = np.clip((t - SWITCH) * 0.1, 0.0, 1.0)[:, None]
    fixed = vessel.fixed_direction
    # Turns slowly enough for the rate limit; the tunnel thruster stays.
    azimuth = wrap_angles(fixed + ramp * np.array(vessel.can_rotate) * np.array([0.0, 1.2, 3.0, -1.0]))
    thrust = (0.25 + 0.05 * slow[:, :1]) * vessel.thrust_max * np.where(ramp > 0.5, 0.6, 1.0)
    rows = np.searchsorted(t, tf + 1e-9, side="right") - 1
    speed = vessel.propellers.shaft_speed(thrust[rows]) + rng.normal(0.0, 0.1, (len(tf), n))
    level = np.where(tf < SWITCH, POWER["fixed"], POWER["rotating"])[:, None]
    power = level * (1.0 + 0.2 * np.sin(7.85 * tf)[:, None]) * np.ones(n)
    measured_azimuth = wrap_angles(azimuth[rows] + rng.normal(0.0, 0.005, (len(tf), n)))
    at_sample = {
        "pose": truth + waves,
        "truth_position": truth,
        "estimate_position": estimate,
        "estimate_velocity": np.zeros((len(t), 3)),
        "wave_position": waves,
        "bias": np.tile([-2.0, 0.1, 0.05], (len(t), 1)),
        "reference_position": reference,
        "reference_velocity": np.zeros((len(t), 3)),
        "proportional": -75.0 * slow * [0.01, 0.008, 0.007],
        "integral": np.tile([2.0, 0.0, 0.0], (len(t), 1)),
        "derivative": 0.2 * slow,
        "wind_feedforward": 0.1 * slow,
        "wind": np.tile([-2.5, 0.3], (len(t), 1)),
        "joystick": np.zeros((len(t), 3)),
        "transfer": np.zeros((len(t), 3)),
        "tau_desired": tau,
        "tau_achieved": tau * (1.0 - 0.3 * (np.abs(t - SWITCH - 2.0) < 2.0)[:, None]),
        "slack": np.zeros((len(t), 3)),
        "allocation_cost": np.ones((len(t), 1)),
        "minimum_gain": np.full((len(t), 1), 0.8),
        "minimum_gain_both_ways": np.full((len(t), 1), 1.1),
        "performance_measure": 1.5 + 0.3 * slow[:, :1],
        "sub_problem": np.zeros((len(t), 1)),
        "rotating": np.repeat((t >= SWITCH)[:, None], n, axis=1) * np.array([0.0, *[1.0] * (n - 1)]),
        "thrust_command": thrust,
        "azimuth_command": azimuth,
        "truth_thrust": 0.9 * thrust,
        "truth_thrust_loss": np.ones((len(t), n)),
        "truth_torque_loss": np.ones((len(t), n)),
        "truth_submergence": np.full((len(t), n), 0.1),
        "truth_advance_speed": np.zeros((len(t), n)),
    }
    at_feedback = {
        "shaft_speed": speed,
        "motor_torque": vessel.propellers.torque(speed),
        "power": power,
        "azimuth": measured_azimuth,
        "torque_setpoint": vessel.propellers.torque(speed),
        "azimuth_rate_setpoint": np.zeros((len(tf), n)),
        "pitch_ratio": np.ones((len(tf), n)),
        "pitch_ratio_setpoint": np.ones((len(tf), n)),
        "ventilating": np.zeros((len(tf), n)),
        "beta_q": np.ones((len(tf), n)),
        "beta_q2": np.ones((len(tf), n)),
    }
    # The third thruster ventilates for a second in every ten.
    flagged = tf % 10.0 < 1.0
    at_feedback["ventilating"][flagged, 2] = 1.0
    at_feedback["beta_q"][flagged, 2] = at_feedback["beta_q2"][flagged, 2] = 0.4
    at_sample["torque_loss"] = at_feedback["beta_q2"][rows_at(t, tf)]
    series = {name: Series(t, values) for name, values in at_sample.items()}
    series |= {name: Series(tf, values) for name, values in at_feedback.items()}
    return RunData(
        info=RunInfo(
            scenario="run_a",
            vessel=vessel.name,
            how="made up",
            seed=seed,
            versions={"dp_tools": "0.1.0"},
            simulated_time=duration,
            wall_time=2.0,
        ),
        thrusters=vessel.thruster_names,
        series=series,
        labels={
            "controller_mode": Labels(np.array([0.0]), ("setpoint",)),
            "azimuth_mode": Labels(np.array([0.0, SWITCH]), ("fixed", "rotating")),
            "observer_status": Labels(np.array([0.0, 0.2]), ("initialised", "nominal")),
            "allocation_status": Labels(np.array([0.0]), ("optimal",)),
        },
    )
