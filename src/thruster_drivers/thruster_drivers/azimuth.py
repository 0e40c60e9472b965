"""Azimuth direction controller, [Ruth] B.3.6."""

from __future__ import annotations

import math

from marine_model.gains import AzimuthGains

_TWO_PI = 2.0 * math.pi


class AzimuthController:
    """Modified P controller of one azimuth thruster, [Ruth] (B.37)-(B.38).

    The output is quadratic in small errors, so that measurement noise does not make the direction chatter, and
    linear in large ones. (B.38) prints its condition on the signed error, which would send every negative error,
    however large, through the quadratic branch; with its |alpha~| alpha~ that is a slip. The condition here is on
    |alpha~|, and the law is odd. At the threshold the linear branch holds.

    Parameters
    ----------
    gains
        Constants of (B.38) and the turning rate of one step.
    rate_max
        What the azimuth motor can do, rad/s.
    """

    def __init__(self, gains: AzimuthGains, rate_max: float) -> None:
        self._quadratic = gains.quadratic_gain * gains.rate_per_step
        self._linear = gains.linear_gain * gains.rate_per_step
        self._threshold = gains.threshold
        self._rate_max = rate_max

    def rate(self, commanded: float, measured: float) -> float:
        """Return the turning rate, rad/s, that takes ``measured`` to ``commanded`` (rad) the shortest way round.

        A measurement that is not finite stops the motor.
        """
        if not math.isfinite(measured):
            return 0.0
        error = math.remainder(commanded - measured, _TWO_PI)  # (B.37), in [-pi, pi]
        size = abs(error)
        rate = error * (self._linear if size >= self._threshold else self._quadratic * size)
        return max(-self._rate_max, min(self._rate_max, rate))
