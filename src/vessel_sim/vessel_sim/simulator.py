"""The simulated vessel: from actuator set points to motion and measurements."""

from __future__ import annotations

import math

import numpy as np

from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel
from vessel_sim.current import Current
from vessel_sim.hull import Hull, Triple
from vessel_sim.inflow import Inflow, inflow
from vessel_sim.interface import SimulatorInputs, SimulatorOutput, SimulatorTruth, VesselSimulator
from vessel_sim.noise import noise_streams, own_sequence, own_stream
from vessel_sim.propulsion import PropulsionPlant, columns
from vessel_sim.propulsion.step import GOOD, first_bad
from vessel_sim.sail import (
    CURRENT_EAST,
    CURRENT_NORTH,
    FORCE_N,
    FORCE_X,
    MOTION,
    OUTSIDE,
    SURGE,
    THRUSTER_X,
    low_frequency,
    sail,
    seen,
)
from vessel_sim.settings import SimulatorSettings
from vessel_sim.waves import Waves, hull_in_waves
from vessel_sim.waves.components import elevation
from vessel_sim.wind import Wind


class Simulator(VesselSimulator):
    """A vessel at rest over ground at the start, with stopped shafts and azimuths in their fixed directions.

    One step holds the set points. Shafts and azimuth servos are solved exactly; the hull is integrated with Heun's
    method (explicit trapezoidal rule) between the thruster and wave forces at both ends of the step: order 2. Current
    and wind force are held over the step, the gusts as they are in the middle of it.

    Parameters
    ----------
    vessel
        The vessel.
    settings
        Sea, wind, sensors, start.

    Raises
    ------
    InputError
        If the time step of the vessel is too long for its hull, or the settings do not fit the vessel.
    """

    def __init__(self, vessel: Vessel, settings: SimulatorSettings | None = None) -> None:
        settings = settings or SimulatorSettings()
        self._vessel = vessel
        self._hull = Hull(vessel)
        self._waves = Waves(hull_in_waves(vessel), settings.waves, own_sequence(settings.seed, "sea"))
        self._plant = PropulsionPlant(vessel)
        self._inflow = Inflow(vessel)
        self._measurement = vessel.measurement

        n = len(vessel.thrusters)
        self._pose_noise, self._thruster_noise = noise_streams(settings.seed, 3, 2 * n)
        self._wind_noise = own_stream(settings.seed, "wind_sensor", 2)
        self._wind_measured: tuple[float, FloatArray] | None = None

        start = settings.initial
        self._motion: FloatArray = np.zeros(MOTION)
        self._motion[:SURGE] = start.north, start.east, start.heading
        self._outside: FloatArray = np.zeros(OUTSIDE)
        self._current_source = Current(settings.current, settings.seed)
        self._wind = Wind(vessel, settings.wind, settings.seed)
        self._has_wind_sensor = vessel.wind_forces is not None
        self._meet_sea()
        self._settings = settings
        self.apply(settings)
        self._begin()

    def apply(self, settings: SimulatorSettings) -> None:
        """Take over ``settings`` from the next step on: see :class:`VesselSimulator`."""
        self._check(settings)
        if settings.wind != self._settings.wind:
            self._wind.apply(settings.wind)
            self._outside[FORCE_X : FORCE_N + 1] = 0.0  # until the next step
        self._current_source.settings = settings.current
        self._set_current()
        if settings.waves != self._settings.waves:
            self._waves.apply(settings.waves, self._time)
            self._meet_sea()
        self._take_over(settings)

    def step(self, inputs: SimulatorInputs, dt: float) -> SimulatorOutput:
        """Sail on by ``dt``: see :class:`VesselSimulator`."""
        self._check_step(dt)
        plant, waves = self._plant, self._waves
        asked = plant.command(inputs.torque, inputs.azimuth_rate, inputs.pitch_ratio)
        if self._current_source.varies or self._wind.blows:
            # Neither may go on if the step is refused.
            parameters, _, _, state, given, before = asked
            bad = first_bad(parameters, state, given, before, 0, columns.ADVANCE_SPEED_INPUT)
            if bad != GOOD:
                plant.refuse(bad)
            self._vary_current_and_wind(dt)
        bad = sail(
            self._hull.coefficients,
            self._motion,
            self._outside,
            waves.components,
            waves.response,
            self._decay,
            self._inflow.thrusters,
            *asked,
            plant.ventilation,
            self._settings.propulsion.inflow,
            self._time,
            dt,
        )
        if bad != GOOD:
            plant.refuse(bad)
        plant.accept()
        self._time += dt
        if self._time >= waves.next_look:
            north, east, _ = self._position
            waves.tidy(north, east, self._time)
            self._meet_sea()
        self._output = self._observe()
        return self._output

    def measure_wind(self) -> FloatArray | None:
        """Return what the anemometer shows now: see :class:`VesselSimulator`."""
        if not self._has_wind_sensor:
            return None
        if self._wind_measured is not None and self._wind_measured[0] == self._time:
            return self._wind_measured[1]
        (e_speed, e_angle), _ = self._wind_noise.row()
        north, east = self._wind.velocity(self._time)
        heading = self._position[2]
        c, s = math.cos(heading), math.sin(heading)
        u, v, _ = self._velocity()
        ahead, starboard = c * north + s * east - u, c * east - s * north - v
        data = self._measurement
        if self._settings.sensor_noise and (data.wind_speed_noise or data.wind_direction_noise):
            speed = math.hypot(ahead, starboard) + data.wind_speed_noise * e_speed
            angle = math.atan2(starboard, ahead) + data.wind_direction_noise * e_angle
            ahead, starboard = speed * math.cos(angle), speed * math.sin(angle)
        measured = np.array([ahead, starboard])
        self._wind_measured = (self._time, measured)
        return measured

    def truth(self) -> SimulatorTruth:
        """Return the true state now."""
        place = self._position
        position, rate = self._waves.motion(place, self._velocity_ned(), self._time)
        u, v, r = velocity = self._velocity()
        with_current = self._hull.hydrodynamic_force(*self._relative)
        without = self._hull.hydrodynamic_force(u, v, r)
        return SimulatorTruth(
            time=self._time,
            position=np.array(place),
            velocity=np.array(velocity),
            wave_position=np.array(position),
            wave_velocity=np.array(rate),
            wave_force=np.array(self._waves.drift_force(place, self._time)),
            wave_elevation=elevation(self._waves.components, place[0], place[1], self._time),
            current_force=np.array(with_current) - np.array(without),
            wind_force=np.array(self._wind.force(self._time, place[2], u, v)),
            current=np.array(self._current),
            thruster_force=self._motion[THRUSTER_X:].copy(),
            **self._thruster_truth(),
        )

    def elevation(self, north: float, east: float) -> float:
        """Return the undisturbed wave elevation (m, positive up) at a point of the map now."""
        return float(self._waves.elevation(north, east, self._time))

    def kinetic_energy(self) -> float:
        """Return the energy of hull and entrained water in the frame of the water, J."""
        return self._hull.kinetic_energy(*self._relative)

    @property
    def _position(self) -> Triple:
        """Low-frequency north (m), east (m), heading (rad)."""
        north, east, heading = self._motion[:SURGE].tolist()
        return north, east, heading

    @property
    def _relative(self) -> Triple:
        """Velocity through the water, body frame."""
        u, v, r = self._motion[SURGE:THRUSTER_X].tolist()
        return u, v, r

    @property
    def _current(self) -> tuple[float, float]:
        """North, east, m/s."""
        return float(self._outside[CURRENT_NORTH]), float(self._outside[CURRENT_EAST])

    def _set_current(self) -> None:
        """Take over the current: the velocity over ground does not jump, that through the water does."""
        north, east = self._current_source.velocity
        before = self._current
        more_north, more_east = north - before[0], east - before[1]
        u, v, r = self._relative
        heading = self._position[2]
        c, s = math.cos(heading), math.sin(heading)
        self._motion[SURGE:THRUSTER_X] = (
            u - c * more_north - s * more_east,
            v + s * more_north - c * more_east,
            r,
        )
        self._outside[CURRENT_NORTH], self._outside[CURRENT_EAST] = north, east

    def _vary_current_and_wind(self, dt: float) -> None:
        """Set the current and the wind force that hold over the step."""
        if self._current_source.advance(dt):
            self._set_current()
        self._wind.advance(dt)
        u, v, _ = self._velocity()
        self._outside[FORCE_X : FORCE_N + 1] = self._wind.force(self._time + 0.5 * dt, self._position[2], u, v)

    def _meet_sea(self) -> None:
        """Find what goes with the components of the sea, after they have changed."""
        self._decay: FloatArray = self._inflow.decay(self._waves.components)

    def _water_at_propellers(self) -> tuple[FloatArray, FloatArray]:
        """Return submergence (m) and advance speed (m/s) of all propellers now, shape (n,) each."""
        azimuth = self._plant.state[:, columns.AZIMUTH].copy()
        waves = self._waves
        return inflow(
            waves.components,
            waves.response,
            self._decay,
            self._inflow.thrusters,
            self._position,
            self._relative,
            self._current,
            azimuth,
            self._time,
        )

    def _velocity(self) -> Triple:
        """Velocity over ground in the body frame."""
        u, v, r = low_frequency(self._motion, self._outside)[3:].tolist()
        return u, v, r

    def _velocity_ned(self) -> tuple[float, float]:
        u, v, _ = self._relative
        heading = self._position[2]
        c, s = math.cos(heading), math.sin(heading)
        north, east = self._current
        return c * u - s * v + north, s * u + c * v + east

    def _pose(self, noise: FloatArray) -> FloatArray:
        """Return what the sensors of the pose show now: see :class:`VesselSimulator`."""
        data = self._measurement
        north, east, heading = place = self._position
        w_north, w_east, w_heading = self._waves.motion(place, self._velocity_ned(), self._time)[0]
        if self._settings.sensor_noise:
            e_north, e_east, e_heading = noise.tolist()
            w_north += data.position_noise * e_north
            w_east += data.position_noise * e_east
            w_heading += data.heading_noise * e_heading
        return np.array([north + w_north, east + w_east, wrap_angle(heading + w_heading)])

    def _observe(self) -> SimulatorOutput:
        """Read the thruster sensors."""
        noise, _ = self._thruster_noise.row()
        data = self._measurement
        on = self._settings.sensor_noise
        motion, rows = seen(
            self._motion,
            self._outside,
            self._plant.parameters,
            self._plant.state,
            noise,
            data.shaft_speed_noise if on else 0.0,
            data.azimuth_noise if on else 0.0,
        )
        return SimulatorOutput(self._time, motion[:3], motion[3:], *rows)
