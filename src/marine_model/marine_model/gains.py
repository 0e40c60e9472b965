"""Tuning of observer, controller, allocator and drivers that belongs to a vessel."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from marine_model.hull import DampingMatrix, MassMatrix
from marine_model.matrix_checks import require_positive_definite, require_symmetric
from marine_model.schema import (
    Fraction,
    NonNegative,
    NonNegativeVector3,
    Positive,
    PositiveByThruster,
    PositiveVector3,
    Section,
)
from marine_model.units import Unit


class ObserverGains(Section):
    """Passive nonlinear observer with wave filter, [Ruth] (B.6)-(B.14)."""

    mass: MassMatrix  # M
    damping: DampingMatrix  # D
    bias_time_constant: Annotated[PositiveVector3, Unit("s")]  # T_b
    wave_frequency: Annotated[PositiveVector3, Unit("rad/s")]  # omega_0
    wave_damping: Annotated[PositiveVector3, Unit("1")]  # lambda
    notch_damping: Annotated[PositiveVector3, Unit("1")]  # zeta_n, 1 in (B.11)
    cutoff_ratio: Annotated[PositiveVector3, Unit("1")]  # omega_c / omega_0
    bias_gain: Annotated[PositiveVector3, Unit("N/(m s), N/(m s), N m/(rad s)")]  # K_3
    velocity_gain: Annotated[PositiveVector3, Unit("N/m, N/m, N m/rad")]  # K_4

    @model_validator(mode="after")
    def _filter_is_a_notch(self) -> Self:
        if not (np.array(self.wave_damping) < np.array(self.notch_damping)).all():
            raise ValueError(
                "wave_damping must be below notch_damping in every axis, found "
                f"{list(self.wave_damping)} and {list(self.notch_damping)}"
            )
        if not (np.array(self.cutoff_ratio) > 1.0).all():
            raise ValueError(f"cutoff_ratio must be above 1, found {list(self.cutoff_ratio)}")
        return self

    @model_validator(mode="after")
    def _physical(self) -> Self:
        require_symmetric("mass", self.mass)
        require_positive_definite("mass", self.mass)
        require_positive_definite("damping", self.damping)
        return self


class ReferenceGains(Section):
    """Second-order reference generator, [Ruth] B.3.2."""

    frequency: Annotated[Positive, Unit("rad/s")]
    damping: Annotated[Positive, Unit("1")]  # relative damping
    velocity_max: Annotated[PositiveVector3, Unit("m/s, m/s, rad/s")]  # in the body frame


class ControllerGains(Section):
    """Nonlinear PID, [Ruth] (B.15)-(B.18)."""

    proportional: Annotated[NonNegativeVector3, Unit("N/m, N/m, N m/rad")]
    integral: Annotated[NonNegativeVector3, Unit("N/(m s), N/(m s), N m/(rad s)")]
    derivative: Annotated[NonNegativeVector3, Unit("N s/m, N s/m, N m s/rad")]
    reference: ReferenceGains


class SectorGains(Section):
    """When the allocator changes from one window of directions to another, [Ruth] (6.2), Table 6.2."""

    dwell_time: Annotated[NonNegative, Unit("s")]  # t_lim, between two crossings of a forbidden sector
    hysteresis: Annotated[NonNegative, Unit("decades")]  # J_lim, decades of the cost


class FixedRotatingGains(Section):
    """When azimuth thrusters are held and when they rotate, [Ruth] (6.3)-(6.5), Table 6.3."""

    force_limit: Annotated[Positive, Unit("N")]  # tau_lim
    hysteresis: Annotated[NonNegative, Unit("N")]  # tau_hyst
    dwell_time: Annotated[NonNegative, Unit("s")]  # t_lim
    filter_frequency: Annotated[Positive, Unit("rad/s")]  # omega

    @model_validator(mode="after")
    def _there_is_a_way_back(self) -> Self:
        if self.hysteresis >= self.force_limit:
            raise ValueError(
                "hysteresis must be below force_limit, or the thrusters are never held again, found "
                f"{self.hysteresis} and {self.force_limit}"
            )
        return self


class SingularityGains(Section):
    """When azimuth thrusters are kept from near-singular configurations, [Ruth] 7.8.1, 7.9.2."""

    gain_limit: Annotated[Positive, Unit("1")]  # sigma_lim
    dwell_time: Annotated[NonNegative, Unit("s")]  # t_lim of (7.128)
    lock_time: Annotated[Positive, Unit("s")]  # how long costs are compared before a configuration counts as locked


class AllocatorGains(Section):
    """Weights and constants of the allocation problem, [Ruth] 4.4 and B.3.4."""

    slack_gain: Annotated[Positive, Unit("1")]  # gamma
    # Diagonal of W_v, one for each of the vessel's degrees of freedom; the cost is in N^2, so that those of moments are
    # in 1/m. On the surface: surge, sway, yaw.
    slack_weight: Annotated[tuple[Positive, ...], Field(strict=False), Unit("1, 1, 1/m")]
    thrust_weight: Annotated[tuple[Positive, ...], Field(strict=False), Unit("1")]  # diagonal of W_u
    approach_fraction: Annotated[float, Field(ge=0.0, lt=1.0), Unit("1")]  # c_1 of (4.14)-(4.17)
    zero_region: Annotated[float, Field(gt=0.0, le=0.1), Unit("1")]  # c_2 of (4.38)-(4.39)
    sectors: SectorGains | None = None  # needed where a thruster has sectors
    fixed_rotating: FixedRotatingGains | None = None
    singularity: SingularityGains | None = None


class ShaftSpeedGains(Section):
    """Shaft-speed PI, [Ruth] (3.9), per unit of shaft inertia so that one pair serves all thrusters."""

    bandwidth: Annotated[Positive, Unit("1/s")]
    integral_time: Annotated[Positive, Unit("s")]


class PowerGains(Section):
    """Power control, [Ruth] (3.11)-(3.12)."""

    # Torque over that of torque control, near n = 0
    torque_ratio_max: Annotated[float, Field(ge=1.0), Unit("1")] = 2.0


class CombinedGains(Section):
    """Weight of torque control in combined control, alpha = exp(-k |p n|^r), [Ruth] (3.14)."""

    gain: Annotated[Positive, Unit("1")] = 1.0  # k
    # p; absent: 1/p is the shaft speed at half of the largest thrust
    time: Annotated[PositiveByThruster | None, Unit("s")] = None
    exponent: Annotated[float, Field(ge=1.0, le=30.0), Unit("1")] = 20.0  # r


class PitchGains(Section):
    """Pitch control, [Ruth] (3.15)-(3.16)."""

    # n_d; absent: that of the largest thrust at the design pitch
    shaft_speed: Annotated[PositiveByThruster | None, Unit("Hz")] = None


class TorqueShaftSpeedGains(Section):
    """Torque/shaft-speed control, [Ruth] (3.22)-(3.24); what is absent follows from shaft and propeller."""

    # K_Qc; absent: the best at zero advance speed
    torque_coefficient: Annotated[PositiveByThruster | None, Unit("1")] = None
    gain: Annotated[PositiveByThruster | None, Unit("1/Hz")] = None  # pitch ratio per shaft speed
    integral_time: Annotated[PositiveByThruster | None, Unit("s")] = None
    # Low-pass of the shaft speed error; absent: that of the servo
    filter_time: Annotated[PositiveByThruster | None, Unit("s")] = None


class AzimuthGains(Section):
    """Modified P controller of the azimuth direction, [Ruth] (B.37)-(B.38)."""

    quadratic_gain: Annotated[Positive, Unit("step/rad^2")]  # below the threshold
    linear_gain: Annotated[Positive, Unit("step/rad")]  # above it
    threshold: Annotated[Positive, Unit("rad")]
    rate_per_step: Annotated[Positive, Unit("rad/s")]  # turning rate for one step of output


class VentilationGains(Section):
    """When a propeller counts as ventilating, [Ruth] (5.14)-(5.17) and (B.41)-(B.44)."""

    on: Annotated[float, Field(gt=0.0, lt=1.0), Unit("1")]  # beta_Q below which it ventilates
    off: Annotated[float, Field(gt=0.0, lt=1.0), Unit("1")]  # beta_Q above which it no longer does
    speed_min: Annotated[PositiveByThruster, Unit("Hz")]  # n_min
    # Share of the torque rate that the thrust rate asks for, K_Q D / K_T dT/dt: what rises faster is not flagged
    torque_rate_limit: Annotated[Positive, Unit("1")]
    deceleration_limit: Annotated[Positive, Unit("Hz/s")]  # what slows down faster is not flagged
    relax_rate: Annotated[Positive, Unit("1/s")]  # largest rise of beta_Q2
    # Between false alarms from noise of the sensors
    false_alarm_interval: Annotated[float, Field(ge=3600.0), Unit("s")]

    @model_validator(mode="after")
    def _hysteresis(self) -> Self:
        if self.on >= self.off:
            raise ValueError(f"on must be below off, found {self.on} and {self.off}")
        return self


class DriverGains(Section):
    """Local thruster control."""

    shaft_speed: ShaftSpeedGains
    power: PowerGains = PowerGains()
    combined: CombinedGains = CombinedGains()
    pitch: PitchGains = PitchGains()
    torque_shaft_speed: TorqueShaftSpeedGains = TorqueShaftSpeedGains()
    # From one law's torque to another's; absent: shaft_speed.integral_time
    transfer_time: Annotated[Positive | None, Unit("s")] = None
    azimuth: AzimuthGains
    command_timeout: Annotated[Positive, Unit("s")]  # without a command until thrust is ramped to zero
    ventilation: VentilationGains | None = None  # without it no ventilation is detected

    def by_thruster(self) -> dict[tuple[str, str], tuple[float, ...]]:
        """Return every gain that may be given per thruster, by its field; those that are absent are left out."""
        rows = {
            ("combined", "time"): self.combined.time,
            ("pitch", "shaft_speed"): self.pitch.shaft_speed,
            ("torque_shaft_speed", "torque_coefficient"): self.torque_shaft_speed.torque_coefficient,
            ("torque_shaft_speed", "gain"): self.torque_shaft_speed.gain,
            ("torque_shaft_speed", "integral_time"): self.torque_shaft_speed.integral_time,
            ("torque_shaft_speed", "filter_time"): self.torque_shaft_speed.filter_time,
            ("ventilation", "speed_min"): None if self.ventilation is None else self.ventilation.speed_min,
        }
        return {field: values for field, values in rows.items() if values is not None}


class Measurement(Section):
    """Position reference and sensors: rate and noise, as the simulator models them."""

    sample_time: Annotated[Positive, Unit("s")]  # between poses; the rate of the control system
    position_noise: Annotated[NonNegative, Unit("m")]  # standard deviation
    heading_noise: Annotated[NonNegative, Unit("rad")]  # standard deviation
    depth_noise: Annotated[NonNegative, Unit("m")] = 0.0  # standard deviation; of a submerged vehicle
    attitude_noise: Annotated[NonNegative, Unit("rad")] = 0.0  # standard deviation, of roll and pitch; likewise
    shaft_speed_noise: Annotated[NonNegative, Unit("Hz")]  # standard deviation
    azimuth_noise: Annotated[NonNegative, Unit("rad")]  # standard deviation
    dropout: Fraction  # chance that a pose is lost
    wind_speed_noise: Annotated[NonNegative, Unit("m/s")] = 0.0  # standard deviation
    wind_direction_noise: Annotated[NonNegative, Unit("rad")] = 0.0  # standard deviation


class Simulation(Section):
    """How the simulator steps."""

    time_step: Annotated[Positive, Unit("s")]  # of vessel, shafts and azimuths; the rate of thruster_feedback
