"""Wind feed-forward: the opposite of the estimated wind force, before it has moved the vessel."""

from __future__ import annotations

import math

from dp_controller.settings import WindFeedforwardSettings
from dp_controller.vectors import ZERO, Triple
from marine_model import Vessel
from marine_model.wind import wind_force


class WindFeedforward:
    """Low-pass filter of the force that the measured wind exerts, and what is to be asked for against it.

    The estimate begins as the mean of what is measured, and goes over into a first-order low-pass filter once the mean
    is ``filter_time`` long. Switched on while the integral balances the wind already, it acts only from then on: the
    integral gives up a mean and not a gust.

    Parameters
    ----------
    vessel
        With ``wind_forces``, if it is ever to be enabled.

    Attributes
    ----------
    force
        Estimated wind force, N, N, N m, body frame; the last one where it has ended.
    stale
        True if enabled and nothing has been measured for longer than ``timeout``.
    switched
        By how much the factor on ``force`` changed in the last step: what was switched, not what the wind did.
    """

    __slots__ = ("_age", "_begun", "_constants", "_factor", "_quiet", "_table", "_wait", "force", "stale", "switched")

    def __init__(self, vessel: Vessel) -> None:
        forces = vessel.wind_forces
        self._constants = None if forces is None else forces.constants()
        self._table = None if forces is None else forces.table()
        self.force: Triple = ZERO
        self.stale = False
        self.switched = 0.0
        self._factor = 0.0  # on the force, in what is asked for
        self._begun = False
        self._age = 0.0  # of the estimate, s
        self._quiet = 0.0  # since the last measurement, or since it was enabled, s
        self._wait = 0.0

    def step(
        self, wind: tuple[float, float] | None, dt: float, settings: WindFeedforwardSettings, is_balanced: bool
    ) -> Triple:
        """Return what to ask for against the wind, N, N, N m in the body frame.

        Parameters
        ----------
        wind
            Newly measured velocity of the air relative to the vessel, body frame, m/s; None without.
        dt
            Time since the last step, s.
        settings
            In force.
        is_balanced
            Whether an integral balances the wind where feed-forward does not.
        """
        before = self._factor
        self._factor = 0.0
        if not settings.enabled:
            self._begun = self.stale = False
            self._quiet = 0.0
        else:
            self._quiet += dt
            if wind is not None:
                self._measure(wind, settings.filter_time, is_balanced)
            # Sums of dt are off by rounding.
            self.stale = self._quiet > settings.timeout * (1.0 + 1e-9)
            self._begun = self._begun and not self.stale
            if self._begun and self._age >= self._wait * (1.0 - 1e-9):
                self._factor = -settings.gain
        self.switched = self._factor - before
        return scaled(self.force, self._factor)

    def _measure(self, wind: tuple[float, float], filter_time: float, is_balanced: bool) -> None:
        if self._constants is None or self._table is None:
            return
        x, y, n = wind_force(self._constants, self._table, -wind[0], -wind[1])
        measured = float(x), float(y), float(n)
        if not self._begun:
            self.force, self._begun, self._age = measured, True, 0.0
            self._wait = filter_time if is_balanced else 0.0
        else:
            elapsed = self._quiet
            self._age += elapsed
            share = -math.expm1(-elapsed / filter_time) if filter_time > 0.0 else 1.0
            share = max(share, elapsed / (self._age + elapsed))
            self.force = (
                self.force[0] + share * (measured[0] - self.force[0]),
                self.force[1] + share * (measured[1] - self.force[1]),
                self.force[2] + share * (measured[2] - self.force[2]),
            )
        self._quiet = 0.0


def scaled(vector: Triple, factor: float) -> Triple:
    """Return ``factor`` times ``vector``."""
    return factor * vector[0], factor * vector[1], factor * vector[2]
