"""The motion controller: operator modes around reference generator and nonlinear PID."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from dp_controller.guidance import Guidance
from dp_controller.joystick import Joystick
from dp_controller.pid import NonlinearPid
from dp_controller.reference_generator import ReferenceGenerator
from dp_controller.settings import AxisMode, AxisModes, ControllerSettings, check_settings
from dp_controller.signals import ControllerInputs, ControllerOutput
from dp_controller.switching import Switching, law
from dp_controller.timed_path import TimedPath
from dp_controller.vectors import ZERO, Mask, Triple, limited, masked, product
from dp_controller.vertical import VerticalController, VerticalInputs
from dp_controller.wind_feedforward import WindFeedforward
from marine_model import Vessel
from marine_model.axes import VERTICAL
from marine_model.errors import InputError
from marine_model.frames import wrap_angle
from marine_model.guards import finite_number, finite_vector, positive_number

AXES = ("surge", "sway", "yaw")

OBSERVER_INVALID: Final = "observer_invalid"
JOYSTICK_STALE: Final = "joystick_stale"
PATH_MISSING: Final = "path_missing"
ESTIMATE_LATE: Final = "estimate_late"
WIND_STALE: Final = "wind_stale"
NOMINAL: Final = "nominal"

# A sample that comes later than this many sample times counts as this many: nothing is known about the time between.
_LONGEST_GAP = 10.0


class Controller:
    """Asks for a generalized force that brings the vessel where the operator wants it.

    Each of surge, sway and yaw is off, manual (joystick) or automatic: reference generator, [Ruth] B.3.2, and
    nonlinear PID, (B.15)-(B.18). Every switch is bumpless: the demand of the first sample after it equals that of the
    last sample before it, and the difference fades in ``settings.transfer_time``. An axis that becomes automatic takes
    the demand in force as its integral.

    With ``settings.wind_feedforward`` automatic axes ask for the opposite of the estimated wind force as well. When it
    is switched on or off, or no wind is measured, the integral of an automatic axis takes over the difference, so that
    the demand stays as it is.

    Of a submerged vehicle heave, roll and pitch are controlled in the same way, :class:`VerticalController`. A mode for
    all axes is for those that the vehicle has; in the others the demand is zero.

    The clock of the controller reads 0 at the first step, and ``dt`` more at each later one.

    Parameters
    ----------
    vessel
        Gains and limits come from ``vessel.controller``.
    settings
        What the operator may change; defaults that fit the vessel if None.

    Raises
    ------
    InputError
        If feed-forward is enabled and the vessel has no ``wind_forces``, or an axis is to be controlled that is not
        among its degrees of freedom.
    """

    def __init__(self, vessel: Vessel, settings: ControllerSettings | None = None) -> None:
        gains = vessel.controller
        self._vessel_gains = (gains.proportional, gains.integral, gains.derivative)
        self._velocity_max = gains.reference.velocity_max
        self._gap_max = _LONGEST_GAP * vessel.measurement.sample_time
        self._vessel = vessel
        self._settings = settings if settings is not None else ControllerSettings.for_vessel(vessel)
        check_settings(self._settings, vessel)
        self._feedforward = WindFeedforward(vessel)
        self._pid = NonlinearPid(*self._scaled_gains())
        self._guidance = Guidance(
            ReferenceGenerator(gains.reference.frequency, gains.reference.damping, self._scaled_velocity())
        )
        self._joystick = Joystick()
        self._switching = Switching()
        self._time: float | None = None
        self._demand: Triple = ZERO
        self._demand_unlimited: Triple = ZERO
        self._message = ""
        self._vertical: VerticalController | None = None
        if vessel.vertical is not None:
            self._vertical = VerticalController(vessel.vertical.controller, vessel.degrees_of_freedom, self._settings)

    # Operator -------------------------------------------------------------------------------------------------------

    @property
    def settings(self) -> ControllerSettings:
        """The settings in force from the next step on."""
        return self._settings

    @property
    def time(self) -> float:
        """Clock at the last step, s; 0 before the first."""
        return self._time if self._time is not None else 0.0

    @property
    def message(self) -> str:
        """Answer to the last operator input: ``accepted: ...`` or ``refused: ...``."""
        return self._message

    def answer(self, text: str) -> None:
        """Record the answer to an operator input that did not get as far as this class."""
        self._message = text

    def apply(self, settings: ControllerSettings) -> None:
        """Swap the settings whole; they hold from the next step on.

        Raises
        ------
        InputError
            As at the start; the settings before stay.
        """
        check_settings(settings, self._vessel)
        before, self._settings = self._settings, settings
        if self._vertical is not None:
            self._vertical.apply(settings)
        self._pid.gains = self._scaled_gains()
        self._guidance.generator.velocity_max = self._scaled_velocity()
        self._switching.retuned = self._switching.retuned or any(
            getattr(before, name) != getattr(settings, name)
            for name in ("proportional_scale", "derivative_scale", "velocity_scale")
        )
        modes = self._modes(settings)
        if self._modes(before) == modes and before.mode == settings.mode:
            self._message = "accepted: settings"
        else:
            axes = ", ".join(f"{axis} {mode}" for axis, mode in modes.items())
            self._message = f"accepted: mode {settings.mode}: {axes}"

    @property
    def axis_modes(self) -> AxisModes:
        """Modes of surge, sway and yaw in force: off in an axis that the vessel has not."""
        return self._axis_modes(self._settings)

    @property
    def vertical_modes(self) -> AxisModes | None:
        """Modes of heave, roll and pitch in force, likewise; None for a vessel on the surface."""
        return None if self._vertical is None else self._vertical.modes()

    def _modes(self, settings: ControllerSettings) -> dict[str, AxisMode]:
        """Return the mode of every axis that the operator has a say in."""
        modes = dict(zip(AXES, self._axis_modes(settings), strict=True))
        if self._vertical is not None:
            modes |= dict(zip(VERTICAL, settings.vertical_modes, strict=True))
            return {axis: mode for axis, mode in modes.items() if axis in self._vessel.degrees_of_freedom}
        return modes

    def _axis_modes(self, settings: ControllerSettings) -> AxisModes:
        if self._vertical is None:
            return settings.axis_modes
        axes = self._vessel.degrees_of_freedom
        a, b, c = (mode if axis in axes else "off" for axis, mode in zip(AXES, settings.axis_modes, strict=True))
        return a, b, c

    def set_setpoint(self, position: ArrayLike) -> None:
        """Give a set point for the automatic axes.

        Where no axis can follow it (none is automatic, or the vessel tracks a path), it waits until one can. A path
        does not lead depth, roll and pitch: they follow a set point in mode tracking too.

        Parameters
        ----------
        position
            Shape (3,): north (m), east (m), heading (rad; reached by the shorter way from the reference heading). Of a
            submerged vehicle shape (6,): north, east, depth (m), roll, pitch, heading (rad).

        Raises
        ------
        InputError
            If the shape is wrong or a number is not finite; the set point before stays.
        """
        with self._answering():
            setpoint, below = self._split("set point", position)
        self._guidance.set_setpoint(setpoint)
        modes = self._modes(self._settings)
        automatic = [axis for axis, mode in modes.items() if mode == "automatic"]
        text = f"accepted: set point {setpoint[0]:.3f} m, {setpoint[1]:.3f} m, {setpoint[2]:.4f} rad"
        if below is not None and self._vertical is not None:
            self._vertical.set_setpoint(below)
            text += f", depth {below[0]:.3f} m, roll {below[1]:.4f} rad, pitch {below[2]:.4f} rad"
        if self._settings.mode == "tracking":
            follows = ", ".join(axis for axis in automatic if axis in VERTICAL)
            text += f"; for {follows}; the rest waits" if follows else "; waits"
            text += " for the end of mode tracking"
        elif not automatic:
            text += "; waits for an automatic axis"
        elif len(automatic) < len(modes):
            text += f"; for {', '.join(automatic)} only"
        self._message = text

    def set_joystick(self, tau: ArrayLike, time: float | None = None) -> None:
        """Give a manual generalized force.

        Parameters
        ----------
        tau
            Shape (3,): N, N, N m, body frame. Of a submerged vehicle shape (6,): surge, sway, heave (N), roll, pitch,
            yaw (N m).
        time
            When it was given, on the clock of the controller (s); now if None.

        Raises
        ------
        InputError
            If the shape is wrong, a number is not finite, or the time lies before that of the last one or further
            ahead than the joystick timeout; the force before stays.
        """
        with self._answering():
            force, below = self._split("joystick", tau)
            given = self.time if time is None else finite_number("joystick time", time)
            last, timeout = self._joystick.time, self._settings.joystick_timeout
            if last is not None and given < last:
                raise InputError(f"joystick time: expected at least {last:.3f} s, found {given:.3f} s")
            # A clock that runs ahead would keep a dead joystick alive.
            if timeout > 0.0 and given > self.time + timeout:
                raise InputError(
                    f"joystick time: expected at most {timeout:.3f} s after the last estimate, "
                    f"found {given - self.time:.3f} s"
                )
        self._joystick.set(force, given)
        if below is not None and self._vertical is not None:
            self._vertical.set_joystick(below, given)
        self._message = "accepted: joystick"

    def set_path(self, times: ArrayLike, positions: ArrayLike) -> None:
        """Give a timed path for mode tracking, in place of the one before.

        Parameters
        ----------
        times
            Shape (k,): on the clock of the controller (s), increasing, k >= 1.
        positions
            Shape (k, 3): north (m), east (m), heading (rad; the shorter way from pose to pose).

        Raises
        ------
        InputError
            If a shape is wrong, a number is not finite, or times do not increase; the path before stays.
        """
        with self._answering():
            path = TimedPath(times, positions)
        self._guidance.set_path(path)
        text = f"accepted: path of {len(path)} poses from {path.start:.1f} s to {path.end:.1f} s"
        fast = [
            f"{axis} ({speed:.3g} of {limit:.3g})"
            for axis, speed, limit in zip(
                AXES, path.body_speeds().tolist(), self._guidance.generator.velocity_max, strict=True
            )
            if speed > limit
        ]
        if fast:
            text += f"; faster than the velocity limit in {', '.join(fast)}: the reference will lag"
        if self._settings.mode != "tracking":
            text += "; waits for mode tracking"
        self._message = text

    # Control --------------------------------------------------------------------------------------------------------

    def step(self, inputs: ControllerInputs, dt: float) -> ControllerOutput:
        """Return the demand for one estimate.

        Parameters
        ----------
        inputs
            Estimate and the allocator's answer to the last demand.
        dt
            Time since the last step, s.

        Raises
        ------
        InputError
            If a shape is wrong or a number is not finite; the controller stays as it was.
        """
        dt = positive_number("dt", dt)
        position = _triple("position", inputs.position) if inputs.valid else ZERO
        velocity = _triple("velocity", inputs.velocity) if inputs.valid else ZERO
        achieved = None if inputs.tau_achieved is None else _triple("tau_achieved", inputs.tau_achieved)
        below = _checked(inputs.vertical) if self._vertical is not None and inputs.valid else None
        settings = self._settings
        wind = _pair("wind", inputs.wind) if settings.wind_feedforward.enabled and inputs.wind is not None else None
        now = 0.0 if self._time is None else self._time + dt
        self._time = now
        elapsed = min(dt, self._gap_max)
        modes = self._axis_modes(settings)
        automatic = _mask(modes, "automatic")
        manual = _mask(modes, "joystick")
        track = settings.mode == "tracking"

        if inputs.valid:
            if self._vertical is not None:
                self._use_setpoint_once(self._vertical, any(automatic))
            self._guidance.step(position, velocity, automatic, track, now, elapsed)
            error = self._guidance.error(position, automatic)
            proportional = self._pid.proportional(error)
            follows = track or settings.velocity_feedback == "error"
            reference_velocity = self._guidance.velocity(position[2]) if follows else ZERO
            derivative = masked(self._pid.derivative(velocity, reference_velocity), automatic)
        else:
            self._guidance.lose(automatic)
            error = proportional = derivative = ZERO
            follows = False
        staying = self._switching.staying(automatic)
        feedforward = masked(self._feedforward.step(wind, dt, settings.wind_feedforward, any(staying)), automatic)
        self._integrate(automatic, staying, feedforward, error, achieved, elapsed, inputs.valid)
        integral = self._pid.force
        stick = self._joystick.force(now, settings.joystick_timeout, settings.transfer_time)
        joystick = masked(stick, manual)

        raw = (
            proportional[0] + integral[0] + derivative[0] + feedforward[0] + joystick[0],
            proportional[1] + integral[1] + derivative[1] + feedforward[1] + joystick[1],
            proportional[2] + integral[2] + derivative[2] + feedforward[2] + joystick[2],
        )
        stick_is_fresh = self._joystick.is_fresh(now, settings.joystick_timeout)
        laws = [law(mode, inputs.valid, follows) for mode in modes]
        given = self._joystick.time is not None, stick_is_fresh
        transfer = self._switching.step(laws, self._demand, raw, given, settings.transfer_time, dt)
        demand = (raw[0] + transfer[0], raw[1] + transfer[1], raw[2] + transfer[2])
        self._demand_unlimited = demand
        self._demand = limited(demand, settings.tau_max)

        vertical = None if self._vertical is None else self._vertical.step(below, now, dt, elapsed)
        by_hand = any(manual) or (vertical is not None and "joystick" in vertical.axis_mode)
        generator = self._guidance.generator
        reference = generator.position
        # One flat tuple: an array of it costs a third of one of nested tuples.
        table = np.array(
            (
                *self._demand,
                reference[0],
                reference[1],
                wrap_angle(reference[2]),
                *masked(generator.body_velocity(), automatic),
                *error,
                *proportional,
                *integral,
                *derivative,
                *feedforward,
                *joystick,
                *transfer,
            )
        ).reshape(10, 3)
        return ControllerOutput(
            tau_desired=table[0],
            mode=settings.mode,
            axis_mode=modes,
            status=self._status(inputs.valid, track, by_hand, stick_is_fresh, dt),
            message=self._message,
            reference_position=table[1],
            reference_velocity=table[2],
            error=table[3],
            proportional=table[4],
            integral=table[5],
            derivative=table[6],
            wind_feedforward=table[7],
            joystick=table[8],
            transfer=table[9],
            vertical=vertical,
        )

    def _use_setpoint_once(self, vertical: VerticalController, plane_follows: bool) -> None:
        """Drop what a waiting set point has for axes that are all manual, once others follow it."""
        below_follows = "automatic" in vertical.modes()
        if plane_follows and not below_follows and self._settings.mode != "tracking":
            vertical.drop_setpoint()
        elif below_follows and not plane_follows:
            self._guidance.drop_setpoint()

    def _split(self, name: str, values: ArrayLike) -> tuple[Triple, Triple | None]:
        """Return the numbers of the horizontal plane, and those of heave, roll and pitch of a submerged vehicle."""
        if self._vertical is None:
            return _triple(name, values), None
        x, y, z, roll, pitch, yaw = finite_vector(name, values, 6).tolist()
        return (x, y, yaw), (z, roll, pitch)

    def _integrate(
        self,
        automatic: Mask,
        staying: Mask,
        feedforward: Triple,
        error: Triple,
        achieved: Triple | None,
        dt: float,
        valid: bool,
    ) -> None:
        """Advance, hold, begin or clear the integral of every axis."""
        before = self._switching.laws
        force, demand = self._pid.force, self._demand
        wind, switched = self._feedforward.force, self._feedforward.switched
        begun = [0.0, 0.0, 0.0]  # a manual axis keeps none
        for i in range(3):
            if staying[i]:
                begun[i] = force[i] - switched * wind[i]
            elif automatic[i]:
                # An axis that becomes automatic takes over what the vessel is pushed with now. A joystick has balanced
                # the wind, as far as it is; an axis that was off has not.
                by_hand = before is not None and before[i] == "joystick"
                begun[i] = demand[i] - feedforward[i] if by_hand else demand[i]
        self._pid.force = (begun[0], begun[1], begun[2])
        if not valid or staying == (False, False, False):
            return
        got, asked = demand if achieved is None else achieved, self._demand_unlimited
        shortfall = masked((got[0] - asked[0], got[1] - asked[1], got[2] - asked[2]), staying)
        self._pid.integrate(masked(error, staying), shortfall, dt, self._settings.anti_windup_time)

    def _status(self, valid: bool, track: bool, by_hand: bool, stick_is_fresh: bool, dt: float) -> str:
        states = []
        if not valid:
            states.append(OBSERVER_INVALID)
        if dt > self._gap_max * (1.0 + 1e-9):
            states.append(ESTIMATE_LATE)
        if not stick_is_fresh and by_hand:
            states.append(JOYSTICK_STALE)
        if track and not self._guidance.has_path:
            states.append(PATH_MISSING)
        if self._feedforward.stale:
            states.append(WIND_STALE)
        return ",".join(states) if states else NOMINAL

    def _scaled_gains(self) -> tuple[Triple, Triple, Triple]:
        settings = self._settings
        proportional, integral, derivative = self._vessel_gains
        return (
            product(proportional, settings.proportional_scale),
            product(integral, settings.integral_scale),
            product(derivative, settings.derivative_scale),
        )

    def _scaled_velocity(self) -> Triple:
        return product(self._velocity_max, self._settings.velocity_scale)

    @contextmanager
    def _answering(self) -> Iterator[None]:
        """Make a refusal the answer to the operator."""
        try:
            yield
        except InputError as error:
            self._message = f"refused: {error}"
            raise


def _triple(name: str, value: ArrayLike) -> Triple:
    # The common case first, in a fifth of the time that the guard takes.
    if type(value) is np.ndarray and value.shape == (3,) and value.dtype == np.float64:
        x, y, z = value.tolist()
        if math.isfinite(x) and math.isfinite(y) and math.isfinite(z):
            return x, y, z
    x, y, z = finite_vector(name, value, 3).tolist()
    return x, y, z


def _checked(inputs: VerticalInputs | None) -> VerticalInputs:
    """Return the estimate of depth, roll and pitch, checked. Raises InputError."""
    if inputs is None:
        raise InputError("depth, roll and pitch: expected an estimate for a submerged vehicle, found none")
    return VerticalInputs(
        finite_vector("depth, roll and pitch", inputs.position, 3),
        finite_vector("velocity of heave, roll and pitch", inputs.velocity, 3),
        None if inputs.achieved is None else finite_vector("tau_achieved of heave, roll, pitch", inputs.achieved, 3),
    )


def _pair(name: str, value: ArrayLike) -> tuple[float, float]:
    x, y = finite_vector(name, value, 2).tolist()
    return x, y


def _mask(modes: tuple[AxisMode, AxisMode, AxisMode], mode: AxisMode) -> Mask:
    return modes[0] == mode, modes[1] == mode, modes[2] == mode
