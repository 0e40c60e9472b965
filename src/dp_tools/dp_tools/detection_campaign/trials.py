"""What surrounds the drivers in a campaign: commanded thrust, submergence and advance speed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dp_tools.detection_campaign.moderate_sea import current_speed, moderate_sea
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray, positive_number
from vessel_sim.waves import IrregularSea

_BLOCK = 15.0  # s that thrust and water keep their character
_LADDER = 2.0  # s of every step of thrust in a row of steps


@dataclass(frozen=True, slots=True)
class Trial:
    """One row a step of the simulator; arrays of shape (steps, n).

    Attributes
    ----------
    thrust
        Commanded, N; a command holds for a sample of the control system, as the allocator's does.
    submergence
        h/R; None: nothing ventilates.
    advance_speed
        V_A, m/s.
    """

    thrust: FloatArray
    submergence: FloatArray | None
    advance_speed: FloatArray


def ventilation_trial(vessel: Vessel, duration: float, seed: int, speed_min: tuple[float, ...] | None = None) -> Trial:
    """Return thrust and submergence that vary from one quarter of a minute to the next.

    Thrust either way between that of 1.2 n_min and the largest; mean h/R from 0 to 2, its amplitude up to 1.5, its
    period from 0.8 s, that of the waves of [Ruth] Appendix C, to 10 s, that of (2.58). No advance speed.

    Parameters
    ----------
    vessel
        With ``drivers.ventilation``.
    duration
        s.
    seed
        Of the trial.
    speed_min
        n_min, Hz, one a thruster; the vessel file's if None.

    Raises
    ------
    InputError
        If the vessel has no section ``drivers.ventilation``, or ``duration`` is not above 0.
    """
    gains = vessel.drivers.ventilation
    if gains is None:
        raise InputError(f"drivers.ventilation: expected this section in vessel '{vessel.name}', found none")
    random = np.random.default_rng(seed)
    n, dt = len(vessel.thrusters), vessel.simulation.time_step
    steps, length = _steps(duration, dt), round(_BLOCK / dt)
    blocks = math.ceil(steps / length)
    least = vessel.propellers.thrust(1.2 * np.broadcast_to(speed_min or gains.speed_min, n))
    share, forward = random.uniform(0.0, 1.0, (blocks, n)), random.random((blocks, n)) < 0.6
    highest = np.where(forward, vessel.thrust_max, -vessel.thrust_min)
    thrust = np.where(forward, 1.0, -1.0) * np.minimum(highest, least + share * (highest - least).clip(0.0))
    mean, amplitude = random.uniform(0.0, 2.0, (blocks, n)), random.uniform(0.0, 1.5, (blocks, n))
    omega = 2.0 * np.pi / np.exp(random.uniform(math.log(0.8), math.log(10.0), (blocks, n)))
    block = np.arange(steps) // length
    # The phase goes on from block to block, so that the surface does not jump by more than a change of mean and height.
    phase = np.cumsum(omega[block] * dt, axis=0)
    submergence = mean[block] + amplitude[block] * np.sin(phase)
    return Trial(thrust[block], submergence, np.zeros((steps, n)))


def moderate_sea_trial(vessel: Vessel, duration: float, seed: int) -> Trial:
    """Return thrust and advance speed in a moderate sea, nothing ventilating.

    Advance speed: the current and the orbital velocity of ``moderate_sea`` at the depth of the shaft, either way of the
    propeller. Thrust: a quarter of a minute each of a mean and a sine of 3 s to 20 s; every fourth is a row of steps
    between full ahead, full astern and nothing, as fast as the drivers go.

    Parameters
    ----------
    vessel
        Scale, depths of the shafts and limits of thrust.
    duration
        s.
    seed
        Of the trial.

    Raises
    ------
    InputError
        If ``duration`` is not above 0.
    """
    random = np.random.default_rng(seed)
    n, dt = len(vessel.thrusters), vessel.simulation.time_step
    steps, length = _steps(duration, dt), round(_BLOCK / dt)
    time: FloatArray = np.arange(steps, dtype=np.float64) * dt
    sea = IrregularSea(moderate_sea(vessel), 0.0, int(random.integers(2**31)))
    ahead = np.where(random.random(n) < 0.5, 1.0, -1.0)
    advance_speed: FloatArray = np.empty((steps, n))
    for depth in np.unique(vessel.shaft_depth):
        alike = vessel.shaft_depth == depth
        orbital = sea.particle_velocity(0.0, 0.0, float(depth), time)[:, 0]
        advance_speed[:, alike] = (current_speed(vessel) + orbital)[:, None] * ahead[alike]

    blocks = math.ceil(steps / length)
    block = np.arange(steps) // length
    mean, swing = random.uniform(-0.8, 0.8, (blocks, n)), random.uniform(0.0, 0.6, (blocks, n))
    omega = 2.0 * np.pi / random.uniform(3.0, 20.0, (blocks, n))
    share = mean[block] + swing[block] * np.sin(omega[block] * time[:, None])
    rung = np.arange(steps) // round(_LADDER / dt)
    ladder = random.choice([-1.0, -0.5, 0.0, 0.5, 1.0], (int(rung[-1]) + 1, n))
    share = np.where((block % 4 == 3)[:, None], ladder[rung], share)
    thrust = np.where(share >= 0.0, share * vessel.thrust_max, -share * vessel.thrust_min)
    sample = round(vessel.measurement.sample_time / dt)
    held = np.arange(steps) // sample * sample
    return Trial(thrust[held].clip(vessel.thrust_min, vessel.thrust_max), None, advance_speed)


def _steps(duration: float, dt: float) -> int:
    return max(1, round(positive_number("duration", duration) / dt))
