"""Control of heave, roll and pitch of a submerged vehicle: every axis for itself.

Each axis that the vehicle has is off, manual or automatic as those of the horizontal plane are: a reference generator
of second order and a PID, (B.15)-(B.18) of [Ruth] without a rotation between the axes. Switches are bumpless and the
integral gives way to saturated thrusters in the same way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dp_controller.joystick import Joystick
from dp_controller.pid import NonlinearPid
from dp_controller.reference_generator import ReferenceGenerator
from dp_controller.settings import AxisModes, ControllerSettings
from dp_controller.switching import Switching, law
from dp_controller.vectors import ZERO, Mask, Triple, both, limited, masked, product
from marine_model.axes import VERTICAL
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.vertical import VerticalControllerGains

_ANGLES = (1, 2)  # roll and pitch among the axes


@dataclass(frozen=True, slots=True)
class VerticalInputs:
    """Estimate of depth, roll and pitch, and the allocator's answer; arrays have shape (3,).

    Attributes
    ----------
    position
        Depth (m), roll, pitch (rad).
    velocity
        Their rates.
    achieved
        Force along heave (N), moments about roll and pitch (N m) that answer the last demand; None if not known.
    """

    position: FloatArray
    velocity: FloatArray
    achieved: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class VerticalOutput:
    """Demand along heave (N), about roll and pitch (N m), and how it came about; arrays have shape (3,).

    Attributes
    ----------
    tau_desired
        The demand; zero in an axis that is off.
    axis_mode
        Mode of heave, roll, pitch.
    reference, error
        Depth (m), roll, pitch (rad); in a manual axis the reference is the vehicle, and the error zero.
    proportional, integral, derivative, joystick, transfer
        Parts of the demand.
    """

    tau_desired: FloatArray
    axis_mode: AxisModes
    reference: FloatArray
    error: FloatArray
    proportional: FloatArray
    integral: FloatArray
    derivative: FloatArray
    joystick: FloatArray
    transfer: FloatArray


class VerticalController:
    """Keeps depth, roll and pitch.

    Parameters
    ----------
    gains
        Of the vehicle.
    axes
        Its degrees of freedom.
    settings
        Operator's options.
    """

    def __init__(self, gains: VerticalControllerGains, axes: tuple[str, ...], settings: ControllerSettings) -> None:
        self._gains = gains
        self._has = tuple(axis in axes for axis in VERTICAL)
        reference = gains.reference
        # One for each axis, so that none waits for another; the second and third element of each stay zero.
        self._generators = [
            ReferenceGenerator(reference.frequency, reference.damping, (limit, 1.0, 1.0))
            for limit in reference.velocity_max
        ]
        self._pid = NonlinearPid(ZERO, ZERO, ZERO)
        self._joystick = Joystick()
        self._switching = Switching()
        self._target = [0.0, 0.0, 0.0]
        self._waiting: Triple | None = None
        self._demand: Triple = ZERO
        self._unlimited: Triple = ZERO
        self._live = False  # the reference is no older than one sample
        self._held: Mask = (False, False, False)  # which axes have a target
        self.apply(settings)
        self._switching.retuned = False

    def apply(self, settings: ControllerSettings) -> None:
        """Swap the settings; they hold from the next step on."""
        scale = settings.vertical
        gains = (
            product(self._gains.proportional, scale.proportional_scale),
            product(self._gains.integral, scale.integral_scale),
            product(self._gains.derivative, scale.derivative_scale),
        )
        self._switching.retuned = self._switching.retuned or (gains[0], gains[2]) != (
            self._pid.gains[0],
            self._pid.gains[2],
        )
        self._pid.gains = gains
        limits = zip(self._gains.reference.velocity_max, scale.velocity_scale, strict=True)
        for generator, (limit, share) in zip(self._generators, limits, strict=True):
            if generator.velocity_max[0] != limit * share:
                generator.velocity_max = (limit * share, 1.0, 1.0)
                self._switching.retuned = True
        self._settings = settings

    def modes(self) -> AxisModes:
        """Return the mode of heave, roll and pitch: off in an axis that the vehicle has not."""
        asked = self._settings.vertical_modes
        a, b, c = (mode if has else "off" for mode, has in zip(asked, self._has, strict=True))
        return a, b, c

    def set_setpoint(self, position: Triple) -> None:
        """Give a set point: depth (m), roll, pitch (rad). It waits until an axis is automatic, and is used once."""
        self._waiting = position

    def drop_setpoint(self) -> None:
        """Forget a set point that waits."""
        self._waiting = None

    def set_joystick(self, force: Triple, time: float) -> None:
        """Give a manual force (N, N m, N m) of ``time`` (s)."""
        self._joystick.set(force, time)

    def step(self, inputs: VerticalInputs | None, now: float, dt: float, elapsed: float) -> VerticalOutput:
        """Return the demand.

        Parameters
        ----------
        inputs
            None if the estimate is not valid: the integral stays, proportional and derivative terms rest.
        now, dt
            Time of the estimate and since the last one, s.
        elapsed
            What of ``dt`` counts for reference and integral, s.
        """
        settings, modes = self._settings, self.modes()
        valid = inputs is not None
        position = velocity = ZERO
        achieved: Triple | None = None
        if inputs is not None:
            position, velocity = _triple(inputs.position), _triple(inputs.velocity)
            achieved = None if inputs.achieved is None else _triple(inputs.achieved)
        automatic = modes[0] == "automatic", modes[1] == "automatic", modes[2] == "automatic"
        manual = modes[0] == "joystick", modes[1] == "joystick", modes[2] == "joystick"
        staying = self._switching.staying(automatic)
        error = proportional = derivative = ZERO
        follows = settings.velocity_feedback == "error"
        if valid:
            self._guide(position, velocity, automatic, elapsed)
            error = masked(_error(self._reference(), position), automatic)
            proportional = self._pid.proportional(error)
            derivative = masked(self._pid.derivative(velocity, self._rates() if follows else ZERO), automatic)
        else:
            # Where the axis is automatic throughout, the target stays.
            self._live, self._held = False, both(self._held, automatic)
        self._integrate(automatic, staying, error, achieved, elapsed, valid)
        stick = self._joystick.force(now, settings.joystick_timeout, settings.transfer_time)
        joystick = masked(stick, manual)
        integral = self._pid.force
        raw = _sum(proportional, integral, derivative, joystick)
        laws = [law(mode, valid, follows) for mode in modes]
        given = self._joystick.time is not None, self._joystick.is_fresh(now, settings.joystick_timeout)
        transfer = self._switching.step(laws, self._demand, raw, given, settings.transfer_time, dt)
        demand = _sum(raw, transfer)
        self._unlimited = demand
        self._demand = limited(demand, settings.vertical.tau_max)
        return VerticalOutput(
            np.array(self._demand),
            modes,
            _wrapped(self._reference()),
            *(np.array(part) for part in (error, proportional, integral, derivative, joystick, transfer)),
        )

    def _guide(self, position: Triple, velocity: Triple, automatic: Mask, dt: float) -> None:
        """Move the reference of every automatic axis; the others go along with the vehicle."""
        staying = both(self._held, automatic)
        for i, generator in enumerate(self._generators):
            here = (position[i], 0.0, 0.0)
            if not automatic[i]:
                generator.reset(here, ZERO)
                self._target[i] = position[i]
                continue
            if not (staying[i] and self._live):
                generator.reset(here, (velocity[i], 0.0, 0.0))
            if not staying[i]:
                self._target[i] = position[i]
            if self._waiting is not None:
                self._target[i] = self._waiting[i]
            if i in _ANGLES:
                # The shorter way: what was measured is wrapped, the reference is not.
                reference = generator.position[0]
                self._target[i] = reference + wrap_angle(self._target[i] - reference)
            if staying[i] and self._live:
                target = (self._target[i], 0.0, 0.0)
                count = generator.steps_in(dt)
                for _ in range(count):
                    generator.step(target, ZERO, target, ZERO, dt / count)
        self._live, self._held = True, automatic
        if any(automatic):
            self._waiting = None  # used once; what was for a manual axis is dropped

    def _reference(self) -> Triple:
        a, b, c = (generator.position[0] for generator in self._generators)
        return a, b, c

    def _rates(self) -> Triple:
        a, b, c = (generator.velocity[0] for generator in self._generators)
        return a, b, c

    def _integrate(
        self,
        automatic: Mask,
        staying: Mask,
        error: Triple,
        achieved: Triple | None,
        dt: float,
        valid: bool,
    ) -> None:
        """Advance, begin or clear the integral of every axis; one that becomes automatic takes over the demand."""
        force, demand = self._pid.force, self._demand
        a, b, c = (force[i] if staying[i] else demand[i] if automatic[i] else 0.0 for i in range(3))
        self._pid.force = (a, b, c)
        if not valid or staying == (False, False, False):
            return
        got, asked = demand if achieved is None else achieved, self._unlimited
        shortfall = masked((got[0] - asked[0], got[1] - asked[1], got[2] - asked[2]), staying)
        self._pid.integrate(masked(error, staying), shortfall, dt, self._settings.anti_windup_time)


def _wrapped(position: Triple) -> FloatArray:
    return np.array((position[0], wrap_angle(position[1]), wrap_angle(position[2])))


def _error(reference: Triple, position: Triple) -> Triple:
    return (
        reference[0] - position[0],
        wrap_angle(reference[1] - position[1]),
        wrap_angle(reference[2] - position[2]),
    )


def _triple(values: FloatArray) -> Triple:
    a, b, c = values.tolist()
    return a, b, c


def _sum(*parts: Triple) -> Triple:
    a, b, c = (math.fsum(values) for values in zip(*parts, strict=True))
    return a, b, c
