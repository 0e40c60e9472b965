"""Shaft-speed control, [Ruth] (3.8)-(3.9)."""

from __future__ import annotations

from thruster_drivers.controllers.speed_control import SpeedController


class ShaftSpeedController(SpeedController):
    """The shaft speed that gives the desired thrust at zero advance speed, at the design pitch."""

    def _aim(self, thrust_reference: float) -> tuple[float, float]:
        """Return n_d of [Ruth] (3.8), with the sign of thrust, and the design pitch ratio."""
        return self._model.shaft_speed(thrust_reference), self._pitch.design
