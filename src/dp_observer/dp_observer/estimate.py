"""What goes into the observer and what comes out."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from marine_model.guards import FloatArray


class ObserverStatus(StrEnum):
    """How the last step came about; the words of ``ObserverState.status``."""

    UNINITIALISED = "uninitialised"  # no position fix yet: the estimate means nothing
    INITIALISED = "initialised"  # first fix: position set to it, at rest, no bias
    NOMINAL = "nominal"  # fix used
    DEAD_RECKONING = "dead_reckoning"  # no fix: model, thrust and bias carried the estimate on
    OUTLIER_REFUSED = "outlier_refused"  # fix too far from the prediction: carried on without it
    INVALID = "invalid"  # carried on without a fix for too long
    REINITIALISED = "reinitialised"  # position set to the fix: it was far off after a loss, or stayed far off


@dataclass(frozen=True, slots=True)
class ObserverInputs:
    """One sample.

    Attributes
    ----------
    position
        Measured north (m), east (m), heading (rad, any turn), shape (3,), in ``map_ned`` at the time of this step;
        None if there is no fix.
    tau
        Generalized force (N, N, N m), shape (3,), in the body frame, that acted since the last step.
    vertical
        Of a submerged vehicle: measured depth (m), roll, pitch (rad), shape (3,); None if there is no fix.
    vertical_tau
        Of a submerged vehicle: force along heave (N), moments about roll and pitch (N m), shape (3,), that acted since
        the last step; None for none.
    """

    position: FloatArray | None
    tau: FloatArray
    vertical: FloatArray | None = None
    vertical_tau: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class VerticalEstimate:
    """Estimate of depth, roll and pitch; every array has shape (3,).

    Attributes
    ----------
    position
        Depth (m), roll, pitch (rad, in [-pi, pi)).
    velocity
        Their rates, m/s, rad/s.
    bias
        Force along heave, moments about roll and pitch that the model does not know (N, N m, N m).
    innovation
        Fix minus the position predicted for it (m, rad, rad); zero without a fix.
    valid, status, time_since_measurement
        As in :class:`ObserverEstimate`, of these axes alone.
    """

    position: FloatArray
    velocity: FloatArray
    bias: FloatArray
    innovation: FloatArray
    valid: bool
    status: ObserverStatus
    time_since_measurement: float


@dataclass(frozen=True, slots=True)
class ObserverEstimate:
    """The estimate at the time of the step; every array has shape (3,).

    Attributes
    ----------
    position
        Low-frequency north (m), east (m), heading (rad, in [-pi, pi)) in ``map_ned``.
    velocity
        Low-frequency surge (m/s), sway (m/s), yaw rate (rad/s) in the body frame.
    wave_frequency_position
        Wave-frequency north (m), east (m), heading (rad).
    bias
        Slowly varying force (N, N, N m) in ``map_ned``.
    innovation
        Fix minus the position predicted for it before it was used (m, m, rad); zero without a fix.
    valid
        False before the first fix and once dead reckoning has lasted longer than its limit.
    status
        How this estimate came about.
    time_since_measurement
        Age (s) of the last fix used, or time since the first step if there was none.
    vertical
        Depth, roll and pitch of a submerged vehicle; None for a vessel on the surface. ``valid``, ``status`` and
        ``time_since_measurement`` are then the worse of both.
    """

    position: FloatArray
    velocity: FloatArray
    wave_frequency_position: FloatArray
    bias: FloatArray
    innovation: FloatArray
    valid: bool
    status: ObserverStatus
    time_since_measurement: float
    vertical: VerticalEstimate | None = None
