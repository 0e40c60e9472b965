"""What goes into the controller at every sample, and what comes out."""

from __future__ import annotations

from dataclasses import dataclass

from dp_controller.settings import AxisModes, Mode
from dp_controller.vertical import VerticalInputs, VerticalOutput
from marine_model.guards import FloatArray


@dataclass(frozen=True, slots=True)
class ControllerInputs:
    """Estimate of the observer and answer of the allocator.

    Attributes
    ----------
    position
        Shape (3,): north (m), east (m), heading (rad), low-frequency.
    velocity
        Shape (3,): surge (m/s), sway (m/s), yaw rate (rad/s), body frame.
    tau_achieved
        Shape (3,): generalized force (N, N, N m; body frame) that answers the demand of the last step, or None if that
        answer is not known: then nothing is fed back to the integral.
    wind
        Shape (2,): velocity of the air relative to the vessel, ahead and to starboard (m/s, body frame), newly measured
        since the last step; None if there is no new measurement. Not looked at unless feed-forward is enabled.
    valid
        False if the observer has lost the vessel; position and velocity are not looked at then.
    vertical
        Depth, roll and pitch of a submerged vehicle; None for a vessel on the surface.
    """

    position: FloatArray
    velocity: FloatArray
    tau_achieved: FloatArray | None = None
    valid: bool = True
    wind: FloatArray | None = None
    vertical: VerticalInputs | None = None


@dataclass(frozen=True, slots=True)
class ControllerOutput:
    """Demand and how it came about. Forces are N, N, N m in the body frame, shape (3,).

    Before limits, ``tau_desired`` is the sum of ``proportional``, ``integral``, ``derivative``, ``wind_feedforward``,
    ``joystick`` and ``transfer``.

    Attributes
    ----------
    tau_desired
        Demanded generalized force.
    mode, axis_mode
        Operator mode, and mode of surge, sway, yaw.
    status
        ``nominal``, or the names of the safe states in force, separated by commas.
    message
        Answer to the last operator input: ``accepted: ...`` or ``refused: ...``.
    reference_position
        Shape (3,): north (m), east (m), heading (rad, wrapped); in a manual axis that of the vessel.
    reference_velocity
        Shape (3,): m/s, m/s, rad/s in the body frame of the reference heading; zero in a manual axis.
    error
        Shape (3,): reference minus estimate, body frame of the vessel (m, m, rad); zero in a manual axis.
    proportional, integral, derivative, wind_feedforward, joystick, transfer
        Parts of the demand.
    vertical
        Heave, roll and pitch of a submerged vehicle; None for a vessel on the surface.
    """

    tau_desired: FloatArray
    mode: Mode
    axis_mode: AxisModes
    status: str
    message: str
    reference_position: FloatArray
    reference_velocity: FloatArray
    error: FloatArray
    proportional: FloatArray
    integral: FloatArray
    derivative: FloatArray
    wind_feedforward: FloatArray
    joystick: FloatArray
    transfer: FloatArray
    vertical: VerticalOutput | None = None
