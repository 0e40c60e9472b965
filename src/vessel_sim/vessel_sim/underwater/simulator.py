"""The simulated underwater vehicle: from actuator set points to motion in six degrees of freedom and measurements."""

from __future__ import annotations

import numpy as np

from marine_model.axes import HORIZONTAL, VERTICAL, axis_indices
from marine_model.errors import InputError
from marine_model.frames import (
    attitude_rotation,
    attitude_to_quaternion,
    quaternion_to_attitude,
    wrap_angle,
)
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel
from vessel_sim.current import Current
from vessel_sim.interface import SimulatorInputs, SimulatorOutput, SimulatorTruth, VesselSimulator
from vessel_sim.noise import noise_streams
from vessel_sim.propulsion import PropulsionPlant, columns
from vessel_sim.propulsion.readings import sensed
from vessel_sim.propulsion.step import GOOD
from vessel_sim.settings import SimulatorSettings
from vessel_sim.underwater.body import SubmergedBody
from vessel_sim.underwater.columns import DEPTH, EAST, HEADING, MOTION, NORTH, QUATERNION, RIGID, THRUSTERS, VELOCITY
from vessel_sim.underwater.dive import dive, water_at

_HORIZONTAL = axis_indices(HORIZONTAL)
_VERTICAL = axis_indices(VERTICAL)


class UnderwaterSimulator(VesselSimulator):
    """An underwater vehicle, upright and at rest over ground at the start, with stopped shafts.

    The sea is calm and without end: a uniform current, no waves, no wind, no bottom. A vehicle that rises comes out of
    the surface at depth 0 as :class:`~vessel_sim.underwater.body.SubmergedBody` says. Set points, shafts, azimuth
    servos and sensors are those of a ship.

    Parameters
    ----------
    vessel
        The vehicle, with a section ``underwater``.
    settings
        Current, sensors, start; those of :meth:`SimulatorSettings.for_vessel` unless given.

    Raises
    ------
    InputError
        If the vessel is none that is submerged, its time step is too long for it, or the settings do not fit it.
    """

    def __init__(self, vessel: Vessel, settings: SimulatorSettings | None = None) -> None:
        settings = settings or SimulatorSettings.for_vessel(vessel)
        if vessel.underwater is None:
            raise InputError(f"vessel: expected one with a section underwater, found '{vessel.name}' without")
        self._vessel = vessel
        self._body = SubmergedBody(vessel.underwater, vessel.hull.mass, vessel.hull.draught)
        self._body.check_time_step(vessel.simulation.time_step, _largest_force(vessel))
        self._plant = PropulsionPlant(vessel)
        self._position: FloatArray = np.array([thruster.position for thruster in vessel.thrusters])
        self._wrench: FloatArray = np.array(vessel.columns6, order="C")
        n = len(vessel.thrusters)
        self._pose_noise, self._thruster_noise = noise_streams(settings.seed, 6, 2 * n)

        start = settings.initial
        motion: FloatArray = np.zeros(MOTION)
        motion[NORTH], motion[EAST], motion[DEPTH], motion[HEADING] = (
            start.north,
            start.east,
            start.depth,
            start.heading,
        )
        x, y, z, w = attitude_to_quaternion(0.0, 0.0, start.heading)
        motion[QUATERNION:VELOCITY] = w, x, y, z
        self._motion = motion
        self._current = (0.0, 0.0)
        self._current_source = Current(settings.current, settings.seed)
        self._settings = settings
        self.apply(settings)
        self._begin()

    def apply(self, settings: SimulatorSettings) -> None:
        """Take over ``settings`` from the next step on: see :class:`VesselSimulator`."""
        self._check(settings)
        self._current_source.settings = settings.current
        self._set_current()
        self._take_over(settings)

    def step(self, inputs: SimulatorInputs, dt: float) -> SimulatorOutput:
        """Sail on by ``dt``: see :class:`VesselSimulator`."""
        self._check_step(dt)
        plant = self._plant
        asked = plant.command(inputs.torque, inputs.azimuth_rate, inputs.pitch_ratio)
        bad = dive(
            self._body.coefficients,
            self._motion,
            self._current,
            self._position,
            self._wrench,
            *asked,
            plant.ventilation,
            self._settings.propulsion.inflow,
            dt,
        )
        if bad != GOOD:
            plant.refuse(bad)
        plant.accept()
        self._time += dt
        # The current of a step is that of its start.
        if self._current_source.advance(dt):
            self._set_current()
        self._output = self._observe()
        return self._output

    def measure_wind(self) -> FloatArray | None:
        """Return None: there is no wind below the surface."""
        return None

    def truth(self) -> SimulatorTruth:
        """Return the true state now."""
        velocity = self._velocity()
        body = self._body
        current_force = body.hydrodynamic_force(self._motion[VELOCITY:RIGID]) - body.hydrodynamic_force(velocity)
        thruster_force = self._motion[THRUSTERS:HEADING].copy()
        return SimulatorTruth(
            time=self._time,
            position=self._horizontal_position(),
            velocity=velocity[_HORIZONTAL],
            wave_position=np.zeros(3),
            wave_velocity=np.zeros(3),
            wave_force=np.zeros(3),
            wave_elevation=0.0,
            current_force=current_force[_HORIZONTAL],
            wind_force=np.zeros(3),
            current=np.array(self._current),
            thruster_force=thruster_force[_HORIZONTAL],
            **self._thruster_truth(),
            vertical_position=self._vertical_position(),
            vertical_velocity=velocity[_VERTICAL],
            current_force6=current_force,
            thruster_force6=thruster_force,
        )

    def energy(self) -> float:
        """Return kinetic energy in the frame of the water plus potential energy, J; see ``SubmergedBody.energy``."""
        return self._body.energy(self._motion)

    def _attitude(self) -> tuple[float, float, float]:
        w, x, y, z = self._motion[QUATERNION:VELOCITY].tolist()
        return quaternion_to_attitude(x, y, z, w)

    def _horizontal_position(self) -> FloatArray:
        return self._motion[[NORTH, EAST, HEADING]]

    def _vertical_position(self) -> FloatArray:
        roll, pitch, _ = self._attitude()
        return np.array([self._motion[DEPTH], roll, pitch])

    def _in_body(self, north: float, east: float) -> FloatArray:
        """Return a horizontal velocity of the map in the body frame, shape (3,)."""
        along: FloatArray = np.array([north, east, 0.0]) @ attitude_rotation(*self._attitude())
        return along

    def _velocity(self) -> FloatArray:
        """Return the velocity over ground in the body frame, shape (6,)."""
        velocity = self._motion[VELOCITY:RIGID].copy()
        velocity[:3] += self._in_body(*self._current)
        return velocity

    def _set_current(self) -> None:
        """Take over the current: the velocity over ground does not jump, that through the water does."""
        north, east = self._current_source.velocity
        before = self._current
        self._motion[VELOCITY : VELOCITY + 3] -= self._in_body(north - before[0], east - before[1])
        self._current = (north, east)

    def _water_at_propellers(self) -> tuple[FloatArray, FloatArray]:
        """Return submergence (m) and advance speed (m/s) of all propellers now, shape (n,) each."""
        azimuth = self._plant.state[:, columns.AZIMUTH].copy()
        return water_at(self._motion, self._position, self._wrench, azimuth)

    def _pose(self, noise: FloatArray) -> FloatArray:
        """Return what the sensors of the pose show now: see :class:`VesselSimulator`."""
        data = self._vessel.measurement
        north, east, heading = self._horizontal_position().tolist()
        pose: FloatArray = np.array([north, east, *self._vertical_position().tolist(), heading])
        if self._settings.sensor_noise:
            place, turn = data.position_noise, data.attitude_noise
            pose += noise * np.array([place, place, data.depth_noise, turn, turn, data.heading_noise])
        pose[5] = wrap_angle(pose[5])
        return pose

    def _observe(self) -> SimulatorOutput:
        """Read the thruster sensors."""
        noise, _ = self._thruster_noise.row()
        data = self._vessel.measurement
        on = self._settings.sensor_noise
        speed, torque, power, azimuth, azimuth_rate, pitch_ratio = sensed(
            self._plant.parameters,
            self._plant.state,
            noise,
            data.shaft_speed_noise if on else 0.0,
            data.azimuth_noise if on else 0.0,
        )
        velocity = self._velocity()
        return SimulatorOutput(
            self._time,
            self._horizontal_position(),
            velocity[_HORIZONTAL],
            speed,
            torque,
            power,
            azimuth,
            azimuth_rate,
            pitch_ratio,
            self._vertical_position(),
            velocity[_VERTICAL],
        )


def _largest_force(vessel: Vessel) -> FloatArray:
    """Return a bound of what the thrusters give along, or about, every axis, N and N m, shape (6,)."""
    thrust = np.array([max(-t.thrust.min, t.thrust.max) for t in vessel.thrusters])
    bound: FloatArray = thrust @ np.sqrt((vessel.columns6**2).sum(axis=2))
    return bound
