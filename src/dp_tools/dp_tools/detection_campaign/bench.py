"""Drivers and propulsion plant of a vessel through one trial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dp_tools.detection_campaign.trials import Trial
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thruster_drivers import DriverInputs, Drivers, DriverSettings
from vessel_sim.noise import noise_streams
from vessel_sim.propulsion import PropulsionPlant, readings
from vessel_sim.propulsion.columns import SHAFT_SPEED, TORQUE_LOSS


@dataclass(frozen=True, slots=True)
class Record:
    """What a trial gave; arrays of shape (steps, n).

    Attributes
    ----------
    shaft_speed
        True, Hz.
    torque_loss
        True share of the propeller's torque that air leaves; 1: nothing ventilates.
    estimate
        beta_Q of the drivers, (B.40): it has what the advance speed takes in it as well.
    ventilating
        Flags of the drivers.
    """

    shaft_speed: FloatArray
    torque_loss: FloatArray
    estimate: FloatArray
    ventilating: NDArray[np.bool_]


def sail(vessel: Vessel, trial: Trial, settings: DriverSettings | None = None, seed: int = 0) -> Record:
    """Let drivers and propulsion of ``vessel`` go through ``trial``, from rest.

    Parameters
    ----------
    vessel
        With ``drivers.ventilation``, and with ``ventilation`` if the trial has a submergence.
    trial
        Commands and surroundings.
    settings
        Of the drivers: control laws, detection, anti-spin.
    seed
        Of the sensor noise.

    Raises
    ------
    InputError
        If the vessel lacks a section, or the settings do not fit it.
    """
    if vessel.drivers.ventilation is None:
        raise InputError(f"drivers.ventilation: expected this section in vessel '{vessel.name}', found none")
    if trial.submergence is not None and vessel.ventilation is None:
        raise InputError(f"ventilation: expected this section in vessel '{vessel.name}', found none")
    dt, data = vessel.simulation.time_step, vessel.measurement
    drivers, plant = Drivers(vessel, settings), PropulsionPlant(vessel)
    plant.ventilation = trial.submergence is not None
    radius = np.array([0.5 * model.diameter for model in vessel.propeller_models])
    # Without losses to air the depth makes no difference.
    depth = np.zeros(trial.thrust.shape) if trial.submergence is None else trial.submergence * radius
    azimuth = vessel.fixed_direction
    (stream,) = noise_streams(seed, 2 * len(vessel.thrusters))
    speed, loss, estimate = (np.empty(trial.thrust.shape) for _ in range(3))
    flag = np.empty(trial.thrust.shape, dtype=np.bool_)
    plant.flood(trial.advance_speed[0], depth[0])
    for k, thrust in enumerate(trial.thrust):
        noise, _ = stream.row()
        shown = readings.sensed(plant.parameters, plant.state, noise, data.shaft_speed_noise, data.azimuth_noise)
        output = drivers.step(
            DriverInputs(
                thrust,
                azimuth,
                0.0,
                shown[readings.SHAFT_SPEED_ROW],
                shown[readings.TORQUE_ROW],
                shown[readings.AZIMUTH_ROW],
                shown[readings.PITCH_ROW],
            ),
            dt,
        )
        speed[k], loss[k] = plant.state[:, SHAFT_SPEED], plant.state[:, TORQUE_LOSS]
        estimate[k], flag[k] = output.beta_q, output.ventilating
        # The water of a row is that at its beginning, the plant wants that at the end of the step.
        after = min(k + 1, len(depth) - 1)
        plant.step(output.torque, output.azimuth_rate, output.pitch_ratio, trial.advance_speed[after], depth[after], dt)
    return Record(speed, loss, estimate, flag)
