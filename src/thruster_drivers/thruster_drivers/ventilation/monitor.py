"""Ventilation detection of all thrusters of a vessel: tables, settings and the memory of losses."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from marine_model.errors import InputError
from marine_model.gains import VentilationGains
from marine_model.guards import FloatArray, positive_number
from marine_model.propulsion import Propulsion
from thruster_drivers.ventilation import tables
from thruster_drivers.ventilation.detection import SHAFT_DECELERATION, TORQUE_RATE
from thruster_drivers.ventilation.loss_factor import allowed_noise
from thruster_drivers.ventilation.settings import VentilationSettings
from thruster_drivers.ventilation.watch import watch

# A wrong answer of a rate costs a delay, no alarm: two standard deviations of noise, a wrong answer in 44, are enough.
_DEVIATIONS = 2.0


class VentilationState(NamedTuple):
    """What is known after a feedback; arrays of shape (n,) in the order of the vessel file.

    Attributes
    ----------
    ventilating
        Flag of (5.14)-(5.15).
    beta_q
        Torque loss factor (B.40) within [0, 2]; 1 near n = 0 and where a sensor is lost.
    beta_q2
        Its memory, (5.16)-(5.17).
    torque
        Observed propeller torque, N m: 0 where a sensor is lost.
    shaft_speed
        Observed shaft speed, Hz; NaN where a sensor is lost.
    lost
        True where shaft speed or motor torque is not finite.
    """

    ventilating: NDArray[np.bool_]
    beta_q: FloatArray
    beta_q2: FloatArray
    torque: FloatArray
    shaft_speed: FloatArray
    lost: NDArray[np.bool_]


class VentilationMonitor:
    """Torque observer, loss factor and flag of every thruster.

    Parameters
    ----------
    vessel
        With a section ``drivers.ventilation``.
    settings
        Operator's options.

    Raises
    ------
    InputError
        If the vessel has no such section or the settings do not fit it.
    """

    def __init__(self, vessel: Propulsion, settings: VentilationSettings | None = None) -> None:
        gains = vessel.drivers.ventilation
        if gains is None:
            raise InputError(f"drivers.ventilation: expected this section in vessel '{vessel.name}', found none")
        self._vessel = vessel
        self._gains = gains
        self._n = len(vessel.thrusters)
        self._noise = vessel.measurement.shaft_speed_noise
        self._sample_time = vessel.measurement.sample_time
        self._time_step = vessel.simulation.time_step
        self._load: FloatArray = np.array(vessel.propellers.torque_per_speed_squared)
        self._given: FloatArray = np.zeros((3, self._n))
        self._parameters = _parameters(vessel, gains)
        self._state: FloatArray = np.zeros((self._n, tables.STATE))
        self._state[:, (tables.BETA, tables.BETA_SAMPLED, tables.REMEMBERED)] = 1.0
        self._beta_column = tables.BETA
        self._method = TORQUE_RATE
        self._on = self._off = math.nan
        self.events: NDArray[np.int64] = np.zeros(self._n, dtype=np.int64)
        """Shape (n,): how often each flag has gone up."""
        self.apply(settings if settings is not None else VentilationSettings())
        self._watch(self._state[:0], self._given[:, :0].copy(), np.zeros((tables.TOLD, 0)), 1.0)  # machine code, now

    @property
    def parameters(self) -> FloatArray:
        """Table of parameters, columns of :mod:`thruster_drivers.ventilation.tables`. A copy."""
        return self._parameters.copy()

    @property
    def method(self) -> int:
        """``TORQUE_RATE`` or ``SHAFT_DECELERATION``."""
        return self._method

    @property
    def beta_column(self) -> int:
        """Column of the state that holds beta_Q of the method in force."""
        return self._beta_column

    def apply(self, settings: VentilationSettings) -> None:
        """Swap the settings as a whole; they hold from the next step on, observers and flags go on.

        Raises
        ------
        InputError
            As :meth:`VentilationSettings.resolved` does. Nothing has changed then.
        """
        on, off, speed_min, excluded = settings.resolved(self._vessel)
        self._on, self._off = on, off
        self._parameters[:, tables.SPEED_MIN] = speed_min
        self._parameters[:, tables.EXCLUDED] = excluded
        interval = self._gains.false_alarm_interval
        self._parameters[:, tables.NOISE] = self._noise / allowed_noise(on, off, interval, self._time_step)
        self._parameters[:, tables.NOISE_SAMPLED] = self._noise / allowed_noise(on, off, interval, self._sample_time)
        self._method = TORQUE_RATE if settings.method == "torque_rate" else SHAFT_DECELERATION
        self._beta_column = tables.BETA if settings.method == "torque_rate" else tables.BETA_SAMPLED

    def step(
        self, shaft_speed: FloatArray, torque: FloatArray, dt: float, load: FloatArray | None = None
    ) -> VentilationState:
        """Take in one feedback.

        Parameters
        ----------
        shaft_speed
            Shape (n,), Hz, measured now. NaN or infinite: that sensor is lost.
        torque
            Shape (n,), N m, motor torque of the step that ended now. NaN or infinite: that sensor is lost.
        dt
            s since the last feedback, above 0.
        load
            Shape (n,): K_Q0(P/D) rho D^5 at the pitch now, N m/Hz^2; the design pitch's if left out.

        Raises
        ------
        InputError
            If a shape is wrong or ``dt`` is not above 0; nothing has changed then.
        """
        elapsed = positive_number("dt", dt)
        for name, value in (("shaft_speed", shaft_speed), ("torque", torque), ("load", load)):
            if value is not None and getattr(value, "shape", None) != (self._n,):
                raise InputError(f"{name}: expected shape ({self._n},), found {getattr(value, 'shape', value)}")
        given = self._given
        given[0] = self._load if load is None else load
        given[1] = shaft_speed
        given[2] = torque
        told: FloatArray = np.empty((tables.TOLD, self._n))
        self._watch(self._state, given, told, elapsed)
        return VentilationState(
            ventilating=told[tables.TOLD_FLAG] != 0.0,
            beta_q=told[tables.TOLD_BETA],
            beta_q2=told[tables.TOLD_REMEMBERED],
            torque=told[tables.TOLD_TORQUE],
            shaft_speed=told[tables.TOLD_SPEED],
            lost=told[tables.TOLD_LOST] != 0.0,
        )

    def _watch(self, state: FloatArray, given: FloatArray, told: FloatArray, dt: float) -> None:
        watch(
            self._parameters[: state.shape[0]],
            state,
            given,
            dt,
            self._sample_time,
            self._method,
            self._beta_column,
            self._on,
            self._off,
            self._gains.relax_rate,
            self.events,
            told,
        )


def _parameters(vessel: Propulsion, gains: VentilationGains) -> FloatArray:
    table: FloatArray = np.zeros((len(vessel.thrusters), tables.PARAMETERS))
    noise = vessel.measurement.shaft_speed_noise
    bandwidth = vessel.drivers.shaft_speed.bandwidth
    # Thrust that grows at its largest rate asks for torque at this rate, from T = K_T rho D^4 n^2, Q = K_Q rho D^5 n^2.
    rates = vessel.propellers.torque_per_speed_squared / vessel.propellers.thrust_per_speed_squared * vessel.thrust_rate
    for row, thruster, rate in zip(table, vessel.thrusters, rates.tolist(), strict=True):
        shaft = thruster.shaft
        row[tables.INERTIA] = inertia = 2.0 * math.pi * shaft.inertia
        row[tables.STATIC] = shaft.friction_static
        row[tables.VISCOUS] = shaft.friction_viscous
        row[tables.TORQUE_RATE_LIMIT] = limit = gains.torque_rate_limit * rate
        # Shaft-speed control turns noise of the shaft speed into a ripple of the motor torque, 2 pi J omega_b sigma.
        window = _DEVIATIONS * inertia * bandwidth * noise / limit
        row[tables.TORQUE_RATE_TIME] = max(window, vessel.simulation.time_step)
        row[tables.DECELERATION_LIMIT] = gains.deceleration_limit
    return table
