"""The drivers of all thrusters: newest command and measurements in, motor torque and azimuth rate out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector, positive_number
from marine_model.propellers.kernel import thrust_torque
from marine_model.propellers.optimal import optimal_maps
from marine_model.thruster import AzimuthThruster
from marine_model.vessel import Vessel
from thruster_drivers.azimuth import AzimuthController
from thruster_drivers.code_maps import CodeMaps
from thruster_drivers.controllers import ThrusterController, make_controller, needs_drive, needs_pitch, tuning_of
from thruster_drivers.settings import DriverSettings
from thruster_drivers.shaft_model import shaft_models
from thruster_drivers.ventilation import AntiSpin, VentilationMonitor, VentilationState

NOMINAL = "nominal"
NO_COMMAND = "no_command"
COMMAND_STALE = "command_stale"
SENSOR_LOST = "sensor_lost"
SPEED_LOST = "speed_lost"


@dataclass(frozen=True, slots=True)
class DriverInputs:
    """What one step needs; arrays have shape (n,) in the order of the vessel file.

    Attributes
    ----------
    thrust_command, azimuth_command
        Newest command, N and rad. Not looked at while ``command_age`` is beyond the limit.
    command_age
        Time of the measurements minus time of the command, s; infinite before the first command. A command from
        further in the future than the limit is as stale as an old one.
    shaft_speed, torque, azimuth
        Measured: Hz, N m, rad. NaN or infinite: that sensor is lost.
    pitch_ratio
        Measured P/D, looked at where the pitch is controllable; None where no thruster has one, or none is measured.
    surge_speed
        Speed of the vessel ahead, m/s, looked at where a law is compensated for it; None or not finite: not known.
    """

    thrust_command: FloatArray
    azimuth_command: FloatArray
    command_age: float
    shaft_speed: FloatArray
    torque: FloatArray
    azimuth: FloatArray
    pitch_ratio: FloatArray | None = None
    surge_speed: float | None = None


@dataclass(frozen=True, slots=True)
class DriverOutput:
    """What one step asks of the motors; arrays have shape (n,).

    Attributes
    ----------
    torque
        Motor torque, N m, within the limits of torque, power and shaft speed.
    azimuth_rate
        rad/s, within the azimuth motor's limit; 0 for a tunnel thruster.
    command_stale
        True while thrust is at, or on its way to, zero for want of a command.
    pitch_ratio
        Set point of P/D, within range and rate of the pitch actuator; the propeller's own where the pitch is fixed.
    shaft_speed_reference
        n_d, Hz: what a law controls the shaft to, or the speed at which a law of torque or power expects to meet the
        thrust reference.
    thrust_reference
        The thrust being realised, N: the command, reached within the vessel's thrust rate; less while anti-spin
        reduces it.
    status
        ``nominal``, or the name of the safe state in force: ``no_command`` (none has come yet), ``command_stale``,
        ``sensor_lost`` (a thruster runs open loop), ``speed_lost`` (codes are those at rest).
    ventilating, beta_q, beta_q2
        Ventilation flag, torque loss factor and its memory, see
        :class:`~thruster_drivers.ventilation.VentilationState`; False, 1 and 1 where nothing is detected.
    code
        Integer code of a drive that takes codes, 0 of another; shape (0,) where no law in force sends codes.
    speed_beyond
        m/s, how far the surge speed was outside the tables of a drive that looks at it, and was clamped: below 0 by
        the least, above 0 by the largest; 0 inside.
    """

    torque: FloatArray
    azimuth_rate: FloatArray
    pitch_ratio: FloatArray
    command_stale: bool
    shaft_speed_reference: FloatArray
    thrust_reference: FloatArray
    status: str
    ventilating: NDArray[np.bool_]
    beta_q: FloatArray
    beta_q2: FloatArray
    code: NDArray[np.int16]
    speed_beyond: float = 0.0


class Drivers:
    """Local control of all thrusters of a vessel, [Ruth] 3.4 and B.3.5-B.3.6.

    The thrust reference starts where the shafts are found turning, and from there never moves faster than the vessel's
    thrust rate: neither when commands stop, nor when they come back, nor when they jump. A change of control law goes
    on from the torque and the pitch that it finds.

    Parameters
    ----------
    vessel
        Limits, propellers, shafts and gains.
    settings
        Operator's options.

    Raises
    ------
    InputError
        If the settings ask a thruster of fixed pitch for a law that needs a controllable one, or one without a drive
        for codes.
    """

    def __init__(self, vessel: Vessel, settings: DriverSettings | None = None) -> None:
        self._vessel = vessel
        self._gains = vessel.drivers
        self._models = shaft_models(vessel)
        self._n = len(self._models)
        self._thrust_limits: list[tuple[float, float, float]] = [
            (thruster.thrust.min, thruster.thrust.max, thruster.thrust.rate) for thruster in vessel.thrusters
        ]
        self._azimuth_controllers: list[AzimuthController | None] = [
            AzimuthController(vessel.drivers.azimuth, thruster.azimuth_drive.rate_max)
            if isinstance(thruster, AzimuthThruster)
            else None
            for thruster in vessel.thrusters
        ]
        for model in self._models:
            if model.propeller is not None and model.pitch is not None:
                # Now, and not while measurements wait for the first step of a law that looks them up.
                optimal_maps(model.propeller, (model.pitch.min, model.pitch.max))
        self._own_pitch: list[float] = vessel.pitch_ratio.tolist()
        self._design_load: FloatArray = np.array(vessel.propellers.torque_per_speed_squared)
        self._propeller_table: FloatArray = np.array(vessel.propeller_table)
        self._diameter = [thruster.propeller.diameter for thruster in vessel.thrusters]
        self._has_pitch = [model.pitch is not None for model in self._models]
        self._any_pitch = any(self._has_pitch)
        self._controllers: list[ThrusterController] = []
        self._laws: list[tuple[str, float, bool]] = []
        self._taking_over: set[int] = set()  # thrusters whose law has changed since the last step
        self._last_torque = [0.0] * self._n
        self._last_pitch = list(self._own_pitch)
        self._stepped = False
        self._timeout = 0.0
        self._thrust_reference: list[float] | None = None
        self._monitor: VentilationMonitor | None = None
        self._antispin = AntiSpin(vessel)
        self._no_flags: NDArray[np.bool_] = np.zeros(self._n, dtype=np.bool_)
        self._no_loss: FloatArray = np.ones(self._n)
        self._no_code: NDArray[np.int16] = np.zeros(0, dtype=np.int16)
        for constant in (self._no_flags, self._no_loss, self._no_code):
            constant.setflags(write=False)
        self.apply(settings if settings is not None else DriverSettings())

    def apply(self, settings: DriverSettings) -> None:
        """Swap the settings as a whole; they hold from the next step on.

        Raises
        ------
        InputError
            If they do not fit the vessel; nothing has changed then.
        """
        settings.antispin.check(self._vessel)
        compensated = settings.code_map.compensated
        # Name, and of the options what the law looks at: with another it is another law.
        laws = [
            (name, settings.advance_speed if needs_pitch(name) else 0.0, needs_drive(name) and compensated)
            for name in settings.controllers(self._vessel)
        ]
        changed = [j for j, law in enumerate(laws) if not self._laws or law != self._laws[j]]
        made = {j: make_controller(laws[j][0], self._models[j], tuning_of(self._gains, j, laws[j][1])) for j in changed}
        self._apply_ventilation(settings)  # the last that may refuse
        self._antispin.apply(settings.antispin)
        self._controllers = [made.get(j) or self._controllers[j] for j in range(self._n)]
        self._laws = laws
        self._code_maps = CodeMaps(self._vessel, self._controllers, compensated)
        if self._stepped:
            self._taking_over.update(changed)
        self._timeout = settings.command_timeout or self._gains.command_timeout

    @property
    def sends_codes(self) -> bool:
        """Whether a law in force sends integer codes."""
        return self._code_maps.any

    @property
    def ventilation_events(self) -> NDArray[np.int64] | None:
        """Shape (n,): how often each flag has gone up; None while nothing is detected."""
        return None if self._monitor is None else self._monitor.events.copy()

    def _apply_ventilation(self, settings: DriverSettings) -> None:
        if self._gains.ventilation is None or not settings.ventilation.enabled:
            self._monitor = None
        elif self._monitor is None:
            self._monitor = VentilationMonitor(self._vessel, settings.ventilation)
        else:
            self._monitor.apply(settings.ventilation)

    def step(self, inputs: DriverInputs, dt: float) -> DriverOutput:
        """Advance all thrusters by ``dt`` (s).

        Raises
        ------
        InputError
            If ``dt`` is not above 0, an array has the wrong length, a command in force is not finite, or the command's
            age is NaN. Nothing has changed then.
        """
        if not 0.0 < dt < math.inf:
            positive_number("dt", dt)
        age = inputs.command_age
        if age != age:
            raise InputError("command_age: expected a number, found nan")
        n = self._n
        stale = not -self._timeout <= age <= self._timeout
        if stale:
            thrust_command = [0.0] * n
            azimuth_command = thrust_command
        else:
            thrust_command = _finite("thrust_command", inputs.thrust_command, n)
            azimuth_command = _finite("azimuth_command", inputs.azimuth_command, n)
        shaft_speed = _measured("shaft_speed", inputs.shaft_speed, n)
        azimuth = _measured("azimuth", inputs.azimuth, n)
        pitch = self._own_pitch
        if self._any_pitch and inputs.pitch_ratio is not None:
            pitch = _measured("pitch_ratio", inputs.pitch_ratio, n)
        # Last of what may refuse its input: it moves on.
        seen = None
        if self._monitor is not None:
            seen = self._monitor.step(inputs.shaft_speed, inputs.torque, dt, self._nominal_load(pitch))
        antispin = self._antispin if self._antispin.active else None
        coded = self._code_maps if self._code_maps.any else None
        if coded is not None:
            coded.tell(inputs.surge_speed, azimuth)

        reference = self._thrust_reference
        if reference is None:
            reference = self._thrust_reference = self._nominal_thrust(shaft_speed)
        if self._taking_over:
            self._take_over(reference, shaft_speed, pitch)
        last_torque, last_pitch = self._last_torque, self._last_pitch
        realised = reference if antispin is None else [0.0] * n
        azimuth_rate = [0.0] * n
        shaft_speed_reference = [0.0] * n
        for j in range(n):
            lowest, highest, rate = self._thrust_limits[j]
            target = thrust_command[j]
            target = lowest if target < lowest else highest if target > highest else target
            move = rate * dt
            thrust = reference[j]
            change = target - thrust
            if change > move:
                thrust += move
            elif change < -move:
                thrust -= move
            else:
                thrust = target
            reference[j] = thrust
            if antispin is not None:
                thrust = realised[j] = self._reduced(antispin, j, thrust, seen, dt)
            controller = self._controllers[j]
            last_torque[j], last_pitch[j] = controller.step(thrust, shaft_speed[j], pitch[j], dt)
            if antispin is not None and seen is not None:
                last_torque[j] = antispin.torque(j, last_torque[j], float(seen.torque[j]), float(seen.shaft_speed[j]))
            shaft_speed_reference[j] = controller.shaft_speed_reference
            azimuth_controller = self._azimuth_controllers[j]
            if azimuth_controller is not None and not stale:
                azimuth_rate[j] = azimuth_controller.rate(azimuth_command[j], azimuth[j])

        if stale:
            status = NO_COMMAND if age == math.inf else COMMAND_STALE
        else:
            status = SENSOR_LOST if self._sensor_lost(shaft_speed, azimuth, pitch) else NOMINAL
            if status == NOMINAL and coded is not None and coded.lost:
                status = SPEED_LOST
        self._stepped = True
        return DriverOutput(
            np.array(last_torque),
            np.array(azimuth_rate),
            np.array(last_pitch) if self._any_pitch else self._vessel.pitch_ratio,
            stale,
            np.array(shaft_speed_reference),
            np.array(realised),
            status,
            self._no_flags if seen is None else seen.ventilating,
            self._no_loss if seen is None else seen.beta_q,
            self._no_loss if seen is None else seen.beta_q2,
            self._no_code if coded is None else np.array([one.code for one in self._controllers], dtype=np.int16),
            0.0 if coded is None else coded.beyond,
        )

    @staticmethod
    def _reduced(antispin: AntiSpin, j: int, thrust: float, seen: VentilationState | None, dt: float) -> float:
        """Return what anti-spin leaves of ``thrust`` (N); after a switch-off of the detection it comes back."""
        if seen is None:
            return antispin.thrust(j, thrust, False, 1.0, dt)
        return antispin.thrust(j, thrust, bool(seen.ventilating[j]), float(seen.beta_q[j]), dt)

    def _nominal_load(self, pitch: list[float]) -> FloatArray | None:
        """Return K_Q0(P/D) rho D^5, N m/Hz^2, of every thruster at its pitch now; None where every pitch is fixed."""
        if not self._any_pitch:
            return None
        load = self._design_load.copy()
        for j, model in enumerate(self._models):
            if self._has_pitch[j] and math.isfinite(pitch[j]):
                row, diameter = self._propeller_table[j], self._diameter[j]
                load[j] = thrust_torque(row, diameter, model.density, 1.0, 0.0, pitch[j])[1]  # at 1 Hz
        return load

    def _take_over(self, reference: list[float], shaft_speed: list[float], pitch: list[float]) -> None:
        """Let the laws that are new begin where the last step ended."""
        for j in self._taking_over:
            measured = pitch[j] if math.isfinite(pitch[j]) else self._last_pitch[j]
            self._controllers[j].take_over(reference[j], shaft_speed[j], measured, self._last_torque[j])
        self._taking_over.clear()

    def _sensor_lost(self, shaft_speed: list[float], azimuth: list[float], pitch: list[float]) -> bool:
        if math.isfinite(sum(shaft_speed) + sum(azimuth) + sum(pitch)):
            return False  # the common case, at the cost of one addition
        return (
            not all(map(math.isfinite, shaft_speed))
            or any(
                controller is not None and not math.isfinite(angle)
                for controller, angle in zip(self._azimuth_controllers, azimuth, strict=True)
            )
            or any(has and not math.isfinite(ratio) for has, ratio in zip(self._has_pitch, pitch, strict=True))
        )

    def _nominal_thrust(self, shaft_speed: list[float]) -> list[float]:
        """Thrust the shafts now give, so that a driver that starts under way does not jerk."""
        found = []
        for model, speed, (lowest, highest, _) in zip(self._models, shaft_speed, self._thrust_limits, strict=True):
            thrust = model.thrust(speed) if math.isfinite(speed) else 0.0
            found.append(max(lowest, min(highest, thrust)))
        return found


def _finite(name: str, value: FloatArray, n: int) -> list[float]:
    """Return ``value`` as a list; the quick test for the common case, the shared guard for the rest."""
    try:
        values: list[float] = value.tolist()
        if len(values) == n and math.isfinite(sum(values)):
            return values
    except (AttributeError, TypeError):
        pass
    checked: list[float] = finite_vector(name, value, n).tolist()
    return checked


def _measured(name: str, value: FloatArray, n: int) -> list[float]:
    """Return ``value`` as a list of ``n`` floats, NaN allowed. Raises InputError."""
    array = np.asarray(value, dtype=np.float64)
    if array.shape != (n,):
        raise InputError(f"{name}: expected shape ({n},), found {array.shape}")
    values: list[float] = array.tolist()
    return values
