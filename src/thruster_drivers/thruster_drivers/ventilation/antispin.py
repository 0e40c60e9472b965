"""Low-level anti-spin, [Ruth] 3.4.3 after Smogeli (2006): less thrust while ventilating, and a limit of shaft speed."""

from __future__ import annotations

import math

from marine_model.errors import InputError
from marine_model.propulsion import Propulsion
from thruster_drivers.ventilation.settings import AntiSpinSettings


class AntiSpin:
    """Acts on either side of a control law: on the thrust it is asked for and on the torque it gives.

    Thrust. While a thruster ventilates its share of the demanded thrust goes to beta_Q. Under the torque law
    that keeps the shaft at the speed of the demand, K_Q rho D^5 n_d^2 = beta_Q Q_d / beta_Q; under the power law,
    P ~ T^(3/2), at beta_Q^(1/6) of it; under the shaft-speed law at sqrt(beta_Q) of it, and less speed draws less air.
    The share moves at limited rates, so that nothing jumps.

    Speed. From 2 pi J dn/dt = Q_m - Q_f - Q_p, with the propeller torque observed, the motor torque

        Q_m <= Q_f + Q_p + 2 pi J omega_b (n_limit - |n|)

    keeps dn/dt <= omega_b (n_limit - |n|): the limit is approached as by the shaft-speed law's own bandwidth and never
    crossed. No integral is needed, because the load is observed; none can wind up.

    Parameters
    ----------
    vessel
        Shafts, propellers and the bandwidth of the shaft-speed law.
    settings
        Operator's options.
    """

    def __init__(self, vessel: Propulsion, settings: AntiSpinSettings | None = None) -> None:
        self._share = [1.0] * len(vessel.thrusters)
        bandwidth = vessel.drivers.shaft_speed.bandwidth
        self._gain = [2.0 * math.pi * t.shaft.inertia * bandwidth for t in vessel.thrusters]
        self._friction = [(t.shaft.friction_static, t.shaft.friction_viscous) for t in vessel.thrusters]
        factors = vessel.propellers.thrust_per_speed_squared.tolist()
        self._full_speed = [
            math.sqrt(max(t.thrust.max, -t.thrust.min) / factor)
            for t, factor in zip(vessel.thrusters, factors, strict=True)
        ]
        self._speed_max = [math.inf if t.shaft.speed_max is None else t.shaft.speed_max for t in vessel.thrusters]
        self.apply(settings if settings is not None else AntiSpinSettings())

    def apply(self, settings: AntiSpinSettings) -> None:
        """Swap the settings as a whole; shares go on from where they are."""
        self._settings = settings
        ratio = settings.speed_limit
        self._limit = [min(ratio * speed, most) for speed, most in zip(self._full_speed, self._speed_max, strict=True)]

    @property
    def active(self) -> bool:
        """Whether anything is to be done: enabled, or on the way back to full thrust."""
        return self._settings.enabled or min(self._share) < 1.0

    @property
    def share(self) -> tuple[float, ...]:
        """Share of the demanded thrust that is left, per thruster."""
        return tuple(self._share)

    @property
    def speed_limit(self) -> tuple[float, ...]:
        """n_limit of every thruster, Hz."""
        return tuple(self._limit)

    def thrust(self, j: int, demanded: float, ventilating: bool, beta_q: float, dt: float) -> float:
        """Return what is left of the ``demanded`` thrust (N) of thruster ``j`` after another ``dt`` (s).

        Raises
        ------
        InputError
            If ``beta_q`` is not a number.
        """
        if not math.isfinite(beta_q):
            raise InputError(f"beta_q: expected a finite number, found {beta_q}")
        settings = self._settings
        goal = 1.0
        if ventilating and settings.enabled:
            goal = min(1.0, max(settings.thrust_floor, beta_q))
        share = self._share[j]
        lowest, highest = share - settings.reduction_rate * dt, share + settings.release_rate * dt
        share = self._share[j] = max(lowest, min(highest, goal))
        return share * demanded

    def torque(self, j: int, motor: float, propeller: float, shaft_speed: float) -> float:
        """Return the motor torque (N m) that keeps thruster ``j`` below its speed limit.

        Parameters
        ----------
        j
            Thruster.
        motor
            Torque of the control law, N m.
        propeller
            Observed propeller torque Q_p, N m.
        shaft_speed
            Observed, Hz. NaN: the sensor is lost, and nothing can be limited.
        """
        if not self._settings.enabled or not math.isfinite(shaft_speed):
            return motor
        static, viscous = self._friction[j]
        if shaft_speed >= 0.0:
            bound = propeller + static + viscous * shaft_speed + self._gain[j] * (self._limit[j] - shaft_speed)
            return min(motor, bound)
        bound = propeller - static + viscous * shaft_speed - self._gain[j] * (self._limit[j] + shaft_speed)
        return max(motor, bound)
