"""What a simulated vessel is asked and what it answers, on the surface and below it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from marine_model.errors import InputError
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel
from vessel_sim.noise import NoiseStream
from vessel_sim.propulsion import PropulsionPlant, columns
from vessel_sim.settings import SimulatorSettings, check_settings


@dataclass(frozen=True, slots=True)
class SimulatorInputs:
    """Set points of the motors, held over the step; arrays of shape (n,)."""

    torque: FloatArray  # N m; the motor limits it
    azimuth_rate: FloatArray  # rad/s; the servo limits it, a tunnel thruster has none
    pitch_ratio: FloatArray | None = None  # P/D; the actuator limits it. None: as they were last asked to be


@dataclass(frozen=True, slots=True)
class SimulatorOutput:
    """Thruster sensors, and the true low-frequency motion, at one instant."""

    time: float  # s since the start
    position: FloatArray  # (3,) true low-frequency north (m), east (m), heading (rad, not wrapped)
    velocity: FloatArray  # (3,) true low-frequency velocity over ground in the body frame
    shaft_speed: FloatArray  # (n,) Hz, measured
    torque: FloatArray  # (n,) N m, motor torque delivered during the step that ended now
    power: FloatArray  # (n,) W, developed power 2 pi n Q, [Ruth] (B.3)
    azimuth: FloatArray  # (n,) rad in [-pi, pi), measured
    azimuth_rate: FloatArray  # (n,) rad/s
    pitch_ratio: FloatArray  # (n,) P/D
    # (3,) true depth (m), roll, pitch (rad), and heave (m/s), roll rate, pitch rate (rad/s); None on the surface
    vertical_position: FloatArray | None = None
    vertical_velocity: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class SimulatorTruth:
    """What no sensor shows, at one instant; vectors of shape (3,) unless noted."""

    time: float
    position: FloatArray  # low-frequency, m, m, rad in NED
    velocity: FloatArray  # low-frequency, over ground, m/s, m/s, rad/s in the body frame
    wave_position: FloatArray  # first-order displacement, m, m, rad in NED
    wave_velocity: FloatArray  # its rate of change, m/s, m/s, rad/s in NED
    wave_force: FloatArray  # mean and slowly varying drift, N, N, N m in the body frame
    wave_elevation: float  # of the undisturbed sea at the low-frequency place of the origin, m, positive up
    current_force: FloatArray  # hydrodynamic force less what it would be without current, body frame
    wind_force: FloatArray  # N, N, N m in the body frame
    current: FloatArray  # (2,) m/s north, east
    thruster_force: FloatArray  # N, N, N m in the body frame
    thrust: FloatArray  # (n,) N, after losses
    azimuth: FloatArray  # (n,) rad in [-pi, pi)
    shaft_speed: FloatArray  # (n,) Hz
    pitch_ratio: FloatArray  # (n,) P/D
    thrust_loss: FloatArray  # (n,) beta_T, 1 without loss to air
    torque_loss: FloatArray  # (n,) beta_Q
    submergence: FloatArray  # (n,) m, depth of the shaft below the surface
    advance_speed: FloatArray  # (n,) m/s, through the water along the direction of positive thrust
    # What a vessel has below the surface, None on it: depth (m), roll, pitch (rad); heave (m/s), roll rate, pitch rate
    # (rad/s) in the body frame; forces in six degrees of freedom, shape (6,)
    vertical_position: FloatArray | None = None
    vertical_velocity: FloatArray | None = None
    current_force6: FloatArray | None = None
    thruster_force6: FloatArray | None = None


class VesselSimulator(ABC):
    """A simulated vessel, on the surface or below it."""

    _vessel: Vessel
    _settings: SimulatorSettings
    _plant: PropulsionPlant
    _pose_noise: NoiseStream
    _measured: tuple[float, FloatArray | None] | None = None
    _time: float = 0.0
    _output: SimulatorOutput

    @property
    def settings(self) -> SimulatorSettings:
        """Settings in force."""
        return self._settings

    @property
    def time(self) -> float:
        """Simulated time since the start, s."""
        return self._time

    @property
    def output(self) -> SimulatorOutput:
        """What the last step returned; before the first, the state at the start."""
        return self._output

    @abstractmethod
    def apply(self, settings: SimulatorSettings) -> None:
        """Take over ``settings`` from the next step on; waves ramp, the velocity over ground does not jump.

        Raises
        ------
        InputError
            If they differ in what is fixed at the start (seed, initial, waves.maker_distance), or do not fit the
            vessel; nothing is changed then.
        """

    @abstractmethod
    def step(self, inputs: SimulatorInputs, dt: float) -> SimulatorOutput:
        """Sail on by ``dt`` and return what the thruster sensors show then.

        Parameters
        ----------
        inputs
            Motor set points, held over the step.
        dt
            s, above 0 and at most the time step of the vessel.

        Raises
        ------
        InputError
            If a set point has the wrong shape or is not finite, a propeller of fixed pitch is asked for another
            than its own, or ``dt`` is out of range; nothing has moved then.
        """

    def check_pitch(self, pitch_ratio: FloatArray) -> None:
        """Refuse set points of pitch that :meth:`step` would refuse, before it is too late to ask for others.

        Raises
        ------
        InputError
            As :meth:`step`.
        """
        self._plant.check_pitch(pitch_ratio)

    def measure(self) -> FloatArray | None:
        """Return the measured pose now: north (m), east (m), heading (rad in [-pi, pi)), shape (3,).

        Of a vessel below the surface north, east, depth (m), roll, pitch, heading (rad), shape (6,). None if this
        measurement is lost. Asked again at the same instant, it gives the same answer.
        """
        if self._measured is not None and self._measured[0] == self._time:
            return self._measured[1]
        noise, chance = self._pose_noise.row()
        kept = (1.0 - self._vessel.measurement.dropout) * (1.0 - self._settings.pose_dropout)
        pose = self._pose(noise) if chance < kept else None
        self._measured = (self._time, pose)
        return pose

    @abstractmethod
    def measure_wind(self) -> FloatArray | None:
        """Return what the anemometer shows now, shape (2,): velocity of the air relative to the vessel, m/s.

        Ahead and to starboard in the body frame, so that head wind has a negative first number; at the height of the
        centroid of the lateral area. None if the vessel has no ``wind_forces``. Asked again at the same instant, it
        gives the same answer.
        """

    @abstractmethod
    def truth(self) -> SimulatorTruth:
        """Return the true state now."""

    @abstractmethod
    def _pose(self, noise: FloatArray) -> FloatArray:
        """Return what the sensors of the pose show now; ``noise`` is standard normal, one number for each."""

    @abstractmethod
    def _water_at_propellers(self) -> tuple[FloatArray, FloatArray]:
        """Return submergence (m) and advance speed (m/s) of all propellers now, shape (n,) each."""

    @abstractmethod
    def _observe(self) -> SimulatorOutput:
        """Read the thruster sensors."""

    def _begin(self) -> None:
        """Fill the water around the propellers, and read the sensors for the first time."""
        depth, flow = self._water_at_propellers()
        self._plant.flood(flow if self._settings.propulsion.inflow else np.zeros(len(flow)), depth)
        self._output = self._observe()

    def _take_over(self, settings: SimulatorSettings) -> None:
        """Let ``settings`` be in force, for the propulsion as well."""
        self._plant.ventilation = settings.propulsion.ventilation
        self._plant.fail(settings.propulsion.failed, settings.propulsion.azimuth_failed)
        self._settings = settings

    def _thruster_truth(self) -> dict[str, FloatArray]:
        """Return what :class:`SimulatorTruth` says of the thrusters one by one."""
        state = self._plant.state.T.copy()
        depth, flow = self._water_at_propellers()
        return {
            "thrust": state[columns.THRUST],
            "azimuth": wrap_angles(state[columns.AZIMUTH]),
            "shaft_speed": state[columns.SHAFT_SPEED],
            "pitch_ratio": state[columns.PITCH_RATIO],
            "thrust_loss": state[columns.THRUST_LOSS],
            "torque_loss": state[columns.TORQUE_LOSS],
            "submergence": depth,
            "advance_speed": flow,
        }

    def _check(self, settings: SimulatorSettings) -> None:
        """Refuse settings that do not fit the vessel, or differ in what is fixed at the start."""
        check_settings(settings, self._vessel)
        fixed: tuple[tuple[str, object, object], ...] = (
            ("seed", self._settings.seed, settings.seed),
            ("initial", self._settings.initial, settings.initial),
            ("waves.maker_distance", self._settings.waves.maker_distance, settings.waves.maker_distance),
        )
        for name, now, asked in fixed:
            if now != asked:
                raise InputError(f"{name}: cannot change during a run, expected {now}, found {asked}")

    def _check_step(self, dt: float) -> None:
        time_step = self._vessel.simulation.time_step
        if not 0.0 < dt <= time_step * (1.0 + 1e-9):  # a dt from stamps is off by rounding
            raise InputError(f"dt: expected above 0 and at most {time_step} s, found {dt}")
