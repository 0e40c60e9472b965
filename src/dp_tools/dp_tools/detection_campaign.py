"""How well the drivers find ventilation: simulated events, and a sea without any.

The drivers' own detection runs, compiled with everything around it: thrust reference and shaft-speed law as in the
drivers (a test compares them), the vessel's sensor noise, and shafts whose load is

    Q_p = beta (K_Q0 rho D^5 n|n| + a_Q rho D^4 |n| V_A),

[Ruth] (3.7) times the loss factor of the ventilation model; the hull is left out. Truth is
beta_Q = Q_p / (K_Q0 rho D^5 n|n|), with what the advance speed takes. An event is a time longer than half a second in
which it is below the threshold `on` while |n| > n_min.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from marine_model import Vessel
from marine_model.compiled import compiled
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.ventilation.dynamic import limited_rise
from marine_model.ventilation.static import loss_factors
from marine_model.ventilation.table import TORQUE_RISE_RATE
from thruster_drivers import DriverSettings
from thruster_drivers.ventilation import VentilationMonitor
from thruster_drivers.ventilation.detection import detect
from thruster_drivers.ventilation.tables import FLAG, STATE

EVENT_LENGTH = 0.5  # s; shorter ones are not asked for
SAMPLES = 2  # of the control system, within which an event is to be found
# a_Q / K_Q0: tangent at J = 0 of the Wageningen B4-70 at P/D = 1. A vessel file with bollard propellers has none.
TORQUE_SLOPE = -0.56
_SUBSTEPS = 4  # of Runge-Kutta's method a step: error below 1e-6 Hz at the fastest shaft of CyberShip III


@dataclass(frozen=True, slots=True)
class DetectionTable:
    """Confusion table of one method, all thrusters that it watches together.

    Attributes
    ----------
    method
        ``ventilation.method``.
    hours
        Simulated time times the number of thrusters watched.
    events
        Events longer than ``EVENT_LENGTH``.
    found
        Of these: flagged before they ended.
    found_in_time
        Of these: flagged within ``SAMPLES`` samples of the control system.
    missed
        Events less ``found``.
    flags
        How often a flag went up.
    early
        Flags that went up while the true beta_Q was between ``on`` and ``off``: neither wet nor ventilating.
    false_alarms
        Flags that went up after the true beta_Q had been above ``off`` for ``SAMPLES`` samples.
    delays
        Shape (found,): s from the start of an event to its flag; 0 where the flag was up already.
    speeds
        Shape (events,): mean |n| of every event, Hz.
    depths
        Shape (events,): least true beta_Q of every event.
    in_time
        Shape (events,): whether it was found in time.
    """

    method: str
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


@dataclass(frozen=True, slots=True)
class Trial:
    """What surrounds the drivers, one row a step of the simulator; arrays of shape (steps, n).

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


@dataclass(frozen=True, slots=True)
class Record:
    """What a trial gave; arrays of shape (steps, n)."""

    shaft_speed: FloatArray  # true, Hz
    beta_q: FloatArray  # true
    estimate: FloatArray  # beta_Q of the drivers
    ventilating: NDArray[np.bool_]


# Columns of the table of thrusters.
_LOAD, _SLOPE, _INERTIA, _DIAMETER, _PITCH, _THRUST_FACTOR, _TORQUE_MAX, _RATE, _SPEED = range(9)
_LOSS, _BETA, _TORQUE, _REFERENCE, _INTEGRAL = range(9, 14)
_COLUMNS = 14


@compiled
def _motor(
    row: FloatArray, demanded: float, measured: float, bandwidth: float, integral_time: float, dt: float
) -> None:
    """Thrust reference and shaft-speed PI of one thruster, as in ``thruster_drivers``; leaves its torque."""
    move = row[_RATE] * dt
    row[_REFERENCE] += max(-move, min(move, demanded - row[_REFERENCE]))
    desired = math.copysign(math.sqrt(abs(row[_REFERENCE]) / row[_THRUST_FACTOR]), row[_REFERENCE])
    gain = row[_INERTIA] * bandwidth
    increment = gain / integral_time * (desired - measured) * dt
    torque = row[_LOAD] * desired * abs(desired) + gain * (desired - measured) + row[_INTEGRAL] + increment
    limit = row[_TORQUE_MAX]
    row[_TORQUE] = max(-limit, min(limit, torque))
    if abs(torque) <= limit or increment * torque < 0.0:  # at the limit the integral only moves back from it
        row[_INTEGRAL] += increment


@compiled
def _turn(row: FloatArray, submergence: float, advance_speed: float, losses: FloatArray, dt: float) -> None:
    """Advance one shaft by ``dt``; no ``losses``, no ventilation."""
    factor, n = 1.0, row[_SPEED]
    if losses.size:
        area, _, wetted = loss_factors(losses, n, row[_DIAMETER], row[_PITCH], submergence)
        row[_LOSS] = limited_rise(wetted, row[_LOSS], losses[TORQUE_RISE_RATE], dt)
        factor = area * row[_LOSS]
    c, a, q, inertia = factor * row[_LOAD], factor * row[_SLOPE] * advance_speed, row[_TORQUE], row[_INERTIA]
    h = dt / _SUBSTEPS
    for _ in range(_SUBSTEPS):
        k1 = (q - c * n * abs(n) - a * abs(n)) / inertia
        m = n + 0.5 * h * k1
        k2 = (q - c * m * abs(m) - a * abs(m)) / inertia
        m = n + 0.5 * h * k2
        k3 = (q - c * m * abs(m) - a * abs(m)) / inertia
        m = n + h * k3
        k4 = (q - c * m * abs(m) - a * abs(m)) / inertia
        n += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    row[_SPEED] = n
    # Near rest there is no nominal torque to compare with.
    row[_BETA] = factor + (a / (row[_LOAD] * n) if abs(n) > 1e-3 else 0.0)


@compiled
def _sail(
    thrusters: FloatArray,
    thrust: FloatArray,
    submergence: FloatArray,
    advance_speed: FloatArray,
    noise: FloatArray,
    losses: FloatArray,
    parameters: FloatArray,
    state: FloatArray,
    bandwidth: float,
    integral_time: float,
    dt: float,
    sample_time: float,
    method: int,
    column: int,
    on: float,
    off: float,
) -> FloatArray:
    """Return shaft speed, true beta_Q, estimate and flag, shape (4, steps, n)."""
    steps, n = thrust.shape
    record = np.empty((4, steps, n))
    load = thrusters[:, _LOAD].copy()
    for k in range(steps):
        measured = thrusters[:, _SPEED] + noise[k]
        torque = thrusters[:, _TORQUE].copy()
        detect(parameters, state, load, measured, torque, dt, sample_time, method, on, off)
        for j in range(n):
            row = thrusters[j]
            record[0, k, j], record[1, k, j] = row[_SPEED], row[_BETA]
            record[2, k, j], record[3, k, j] = state[j, column], state[j, FLAG]
            _motor(row, thrust[k, j], measured[j], bandwidth, integral_time, dt)
            _turn(row, submergence[k, j], advance_speed[k, j], losses, dt)
    return record


def sail(
    vessel: Vessel,
    trial: Trial,
    settings: DriverSettings | None = None,
    seed: int = 0,
    torque_slope: float = 0.0,
    pitch_ratio: float = 1.0,
) -> Record:
    """Let the detection of ``vessel`` go through ``trial``.

    Parameters
    ----------
    vessel
        With ``drivers.ventilation``, and with ``ventilation`` if the trial has a submergence.
    trial
        Commands and surroundings.
    settings
        Of the drivers; of these, ``ventilation``.
    seed
        Of the sensor noise.
    torque_slope
        a_Q / K_Q0 of [Ruth] (3.7): relative change of K_Q with the advance number, at most 0.
    pitch_ratio
        P/D of all propellers, for the ventilation.

    Raises
    ------
    InputError
        If the vessel lacks a section, or has friction, which this bench leaves out.
    """
    if trial.submergence is not None and vessel.ventilation is None:
        raise InputError(f"ventilation: expected this section in vessel '{vessel.name}', found none")
    if any(t.shaft.friction_static or t.shaft.friction_viscous for t in vessel.thrusters):
        raise InputError(f"thrusters.shaft: expected no friction, found some in vessel '{vessel.name}'")
    ventilation = (settings or DriverSettings()).ventilation
    monitor = VentilationMonitor(vessel, ventilation)
    on, off, _, _ = ventilation.resolved(vessel)
    n, gains = len(vessel.thrusters), vessel.drivers.shaft_speed
    thrusters = np.zeros((n, _COLUMNS))
    thrusters[:, _LOAD] = vessel.propellers.torque_per_speed_squared
    thrusters[:, _DIAMETER] = [t.propeller.diameter for t in vessel.thrusters]
    thrusters[:, _SLOPE] = torque_slope * thrusters[:, _LOAD] / thrusters[:, _DIAMETER]  # a_Q rho D^4
    thrusters[:, _INERTIA] = [2.0 * math.pi * t.shaft.inertia for t in vessel.thrusters]
    thrusters[:, _PITCH] = pitch_ratio
    thrusters[:, _THRUST_FACTOR] = vessel.propellers.thrust_per_speed_squared
    thrusters[:, _TORQUE_MAX] = [t.shaft.torque_max for t in vessel.thrusters]
    thrusters[:, _RATE] = vessel.thrust_rate
    thrusters[:, _LOSS] = thrusters[:, _BETA] = 1.0
    state = np.zeros((n, STATE))
    row = None if vessel.ventilation is None or trial.submergence is None else vessel.ventilation.row()
    found = _sail(
        thrusters,
        np.array(trial.thrust.clip(vessel.thrust_min, vessel.thrust_max)),
        np.zeros(trial.thrust.shape) if trial.submergence is None else np.array(trial.submergence),
        np.array(trial.advance_speed),
        sensor_noise(vessel, len(trial.thrust), seed),
        np.zeros(0) if row is None else np.array(row),
        monitor.parameters,
        state,
        gains.bandwidth,
        gains.integral_time,
        vessel.simulation.time_step,
        vessel.measurement.sample_time,
        monitor.method,
        monitor.beta_column,
        on,
        off,
    )
    return Record(found[0], found[1], found[2], found[3] != 0.0)


def sensor_noise(vessel: Vessel, steps: int, seed: int) -> FloatArray:
    """Return the noise of the shaft speeds, Hz, shape (steps, n); none in the first row: shafts at rest are known."""
    normal = np.random.default_rng(seed).standard_normal((steps, len(vessel.thrusters)))
    normal[0] = 0.0
    return np.asarray(normal * vessel.measurement.shaft_speed_noise)


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
        beta, size, flag = record.beta_q[:, j], np.abs(record.shaft_speed[:, j]), record.ventilating[:, j]
        for start, end in _runs((beta < on) & (size > speed_min[j])):
            if (end - start) * dt <= EVENT_LENGTH + 1e-9:
                continue
            up = np.flatnonzero(flag[start:end])
            if up.size:
                delays.append(float(up[0]) * dt)
            in_time.append(bool(up.size) and delays[-1] <= allowed + 1e-9)
            speeds.append(float(size[start:end].mean()))
            depths.append(float(beta[start:end].min()))
        for start, _ in _runs(flag):
            flags += 1
            past = beta[max(0, start - back) : start + 1]
            if past.min() > off:
                false_alarms += 1
            elif past.min() >= on:
                early += 1
    return DetectionTable(
        method=ventilation.method,
        hours=record.beta_q.shape[0] * dt / 3600.0 * len(watched),
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


def _runs(truth: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first and one past the last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], truth, [False])).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def ventilation_trial(vessel: Vessel, duration: float, seed: int) -> Trial:
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

    Raises
    ------
    InputError
        If the vessel has no section ``drivers.ventilation``.
    """
    gains = vessel.drivers.ventilation
    if gains is None:
        raise InputError(f"drivers.ventilation: expected this section in vessel '{vessel.name}', found none")
    random = np.random.default_rng(seed)
    n, dt = len(vessel.thrusters), vessel.simulation.time_step
    length = round(15.0 / dt)
    blocks = math.ceil(duration / dt / length)
    least = vessel.propellers.thrust(1.2 * np.array(gains.speed_min))
    share, forward = random.uniform(0.0, 1.0, (blocks, n)), random.random((blocks, n)) < 0.6
    highest = np.where(forward, vessel.thrust_max, -vessel.thrust_min)
    thrust = np.where(forward, 1.0, -1.0) * np.minimum(highest, least + share * (highest - least).clip(0.0))
    mean, amplitude = random.uniform(0.0, 2.0, (blocks, n)), random.uniform(0.0, 1.5, (blocks, n))
    omega = 2.0 * np.pi / np.exp(random.uniform(math.log(0.8), math.log(10.0), (blocks, n)))
    steps = round(duration / dt)
    block = np.arange(steps) // length
    # The phase goes on from block to block, so that the surface does not jump by more than a change of mean and height.
    phase = np.cumsum(omega[block] * dt, axis=0)
    submergence = mean[block] + amplitude[block] * np.sin(phase)
    return Trial(np.ascontiguousarray(thrust[block]), submergence, np.zeros((steps, n)))


def moderate_sea_trial(vessel: Vessel, duration: float, seed: int, depth: float = 0.1) -> Trial:
    """Return thrust and advance speed in a moderate sea, nothing ventilating.

    The sea of [Ruth] 3.7, H_s = 2 m and T_p = 5.9 s with gamma = 3.3 at full scale, in the middle of what the WMO calls
    moderate (1.25 m to 2.5 m), brought to the vessel's scale. Advance speed: the current of 3.7, 1 m/s, and the orbital
    velocity at ``depth``, either way of the propeller. Thrust: a quarter of a minute each of a mean and a sine of 3 s
    to 20 s; every fourth is a row of steps between full ahead, full astern and nothing, as fast as the drivers go.

    Parameters
    ----------
    vessel
        Scale and limits of thrust.
    duration
        s.
    seed
        Of the trial.
    depth
        m, of the shafts.
    """
    random = np.random.default_rng(seed)
    n, dt, scale = len(vessel.thrusters), vessel.simulation.time_step, vessel.scale
    steps = round(duration / dt)
    time: FloatArray = np.arange(steps, dtype=np.float64) * dt
    height, period, current = 2.0 / scale, 5.9 / math.sqrt(scale), 1.0 / math.sqrt(scale)
    advance = current + _orbital_velocity(height, period, depth, time, random)
    advance_speed = advance[:, None] * np.where(random.random(n) < 0.5, 1.0, -1.0)[None, :]

    length = round(15.0 / dt)
    blocks = math.ceil(steps / length)
    block = np.arange(steps) // length
    mean, swing = random.uniform(-0.8, 0.8, (blocks, n)), random.uniform(0.0, 0.6, (blocks, n))
    omega = 2.0 * np.pi / random.uniform(3.0, 20.0, (blocks, n))
    share = mean[block] + swing[block] * np.sin(omega[block] * time[:, None])
    ladder = random.choice([-1.0, -0.5, 0.0, 0.5, 1.0], (steps // round(2.0 / dt) + 1, n))
    stepped = ladder[np.arange(steps) // round(2.0 / dt)]
    share = np.where((block % 4 == 3)[:, None], stepped, share)
    thrust = np.where(share >= 0.0, share * vessel.thrust_max, -share * vessel.thrust_min)
    sample = round(vessel.measurement.sample_time / dt)
    held = np.arange(steps) // sample * sample
    limited = thrust[held].clip(vessel.thrust_min, vessel.thrust_max)
    return Trial(np.ascontiguousarray(limited), None, np.ascontiguousarray(advance_speed))


def _orbital_velocity(
    height: float, period: float, depth: float, time: FloatArray, random: np.random.Generator
) -> FloatArray:
    """Return the horizontal orbital velocity of a JONSWAP sea (gamma 3.3), m/s, by inverse FFT over ``time``."""
    dt = float(time[1] - time[0])
    frequency = np.fft.rfftfreq(time.size, dt)[1:]
    omega, peak = 2.0 * np.pi * frequency, 2.0 * np.pi / period
    width = np.where(omega <= peak, 0.07, 0.09)
    shape = omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4.0)
    shape *= 3.3 ** np.exp(-((omega - peak) ** 2) / (2.0 * (width * peak) ** 2))
    step = omega[1] - omega[0]
    spectrum = shape * (height / 4.0) ** 2 / (shape.sum() * step)  # m_0 = (H_s / 4)^2
    # Deep water: the velocity's amplitude is omega exp(-k z) times that of the elevation.
    amplitude = np.sqrt(2.0 * spectrum * step) * omega * np.exp(-(omega**2) / GRAVITY * depth)
    coefficients = np.zeros(time.size // 2 + 1, dtype=np.complex128)
    coefficients[1:] = amplitude * np.exp(2j * np.pi * random.random(frequency.size))
    return np.asarray(np.fft.irfft(coefficients, time.size) * time.size / 2.0)


def campaign(
    vessel: Vessel,
    method: str,
    duration: float = 3600.0,
    seed: int = 0,
    torque_slope: float = TORQUE_SLOPE,
    pitch_ratio: float = 1.0,
) -> tuple[DetectionTable, DetectionTable]:
    """Return the tables of ``duration`` (s) of ventilation and of as much moderate sea without it, for one method.

    ``torque_slope`` and ``pitch_ratio`` are those of :func:`sail`.

    Raises
    ------
    InputError
        If the vessel lacks a section that is needed, or ``method`` is none of the drivers'.
    """
    base = DriverSettings().ventilation
    if method not in ("torque_rate", "shaft_deceleration"):
        raise InputError(f"method: expected torque_rate or shaft_deceleration, found '{method}'")
    settings = DriverSettings(ventilation=type(base).model_validate({**base.model_dump(), "method": method}))
    tables = []
    for trial in (ventilation_trial(vessel, duration, seed), moderate_sea_trial(vessel, duration, seed)):
        record = sail(vessel, trial, settings, seed, torque_slope, pitch_ratio)
        tables.append(tabulate(vessel, record, settings))
    return tables[0], tables[1]
