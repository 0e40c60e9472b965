"""The gains of one thruster, as scalars."""

from __future__ import annotations

from dataclasses import dataclass

from marine_model.gains import DriverGains


@dataclass(frozen=True, slots=True)
class Tuning:
    """Gains of all laws for one thruster; None where the law derives its own, see docs/thruster_drivers.md.

    Attributes
    ----------
    bandwidth, integral_time
        Of the shaft-speed loop, 1/s and s.
    transfer_time
        s, in which one law's torque passes to the next law's.
    torque_ratio_max
        Largest torque of power control over that of torque control.
    combined_gain, combined_time, combined_exponent
        k, p (s) and r of [Ruth] (3.14).
    pitch_shaft_speed
        Hz, n_d of pitch control.
    torque_coefficient
        K_Qc of torque/shaft-speed control.
    pitch_gain, pitch_integral_time, pitch_filter_time
        1/Hz, s and s, of [Ruth] (3.24).
    advance_speed
        m/s, V_A that the consolidated laws assume.
    """

    bandwidth: float
    integral_time: float
    transfer_time: float
    torque_ratio_max: float = 2.0
    combined_gain: float = 1.0
    combined_time: float | None = None
    combined_exponent: float = 20.0
    pitch_shaft_speed: float | None = None
    torque_coefficient: float | None = None
    pitch_gain: float | None = None
    pitch_integral_time: float | None = None
    pitch_filter_time: float | None = None
    advance_speed: float = 0.0


def tuning_of(gains: DriverGains, thruster: int, advance_speed: float = 0.0) -> Tuning:
    """Return the gains of thruster number ``thruster``."""

    def own(values: tuple[float, ...] | None) -> float | None:
        return None if values is None else values[thruster if len(values) > 1 else 0]

    return Tuning(
        bandwidth=gains.shaft_speed.bandwidth,
        integral_time=gains.shaft_speed.integral_time,
        transfer_time=gains.transfer_time or gains.shaft_speed.integral_time,
        torque_ratio_max=gains.power.torque_ratio_max,
        combined_gain=gains.combined.gain,
        combined_time=own(gains.combined.time),
        combined_exponent=gains.combined.exponent,
        pitch_shaft_speed=own(gains.pitch.shaft_speed),
        torque_coefficient=own(gains.torque_shaft_speed.torque_coefficient),
        pitch_gain=own(gains.torque_shaft_speed.gain),
        pitch_integral_time=own(gains.torque_shaft_speed.integral_time),
        pitch_filter_time=own(gains.torque_shaft_speed.filter_time),
        advance_speed=advance_speed,
    )
