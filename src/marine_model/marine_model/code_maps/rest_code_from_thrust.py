"""Code of a thrust at zero speed, [Kostenko] (7), Table 3."""

from __future__ import annotations

from collections.abc import Sequence

from marine_model.code_maps.codes import nearest_code
from marine_model.code_maps.cubic import Cubic, require_rising, value
from marine_model.errors import InputError
from marine_model.guards import finite_number, finite_vector, positive_number


class RestCodeFromThrust:
    """N = K_0 + K_1 T + K_2 T^2 + K_3 T^3 with coefficients of its own for thrust ahead and astern; 0 near T = 0.

    Thrust beyond the largest is saturated there, and the code at the largest of the drive.

    Parameters
    ----------
    ahead, astern
        K_N00 to K_N03 and K_N10 to K_N13: 1, 1/N, 1/N^2, 1/N^3. Those astern are of T itself, which is negative.
    thrust_max
        N, either way.
    dead_zone
        N: thrust not above this gets code 0.
    code_max
        Largest code.

    Raises
    ------
    InputError
        If one of the two does not rise.
    """

    def __init__(
        self, ahead: Sequence[float], astern: Sequence[float], thrust_max: float, dead_zone: float, code_max: int
    ) -> None:
        self.thrust_max = positive_number("thrust_max", thrust_max)
        self.dead_zone = positive_number("dead_zone", dead_zone)
        self.code_max = code_max
        if self.dead_zone >= self.thrust_max:
            raise InputError(f"dead_zone: expected a number below {self.thrust_max:g}, found {self.dead_zone:g}")
        a0, a1, a2, a3 = finite_vector("ahead", ahead, 4).tolist()
        b0, b1, b2, b3 = finite_vector("astern", astern, 4).tolist()
        self._ahead: Cubic = (a0, a1, a2, a3)
        self._astern: Cubic = (-b0, b1, -b2, b3)  # of sizes: -N(-|T|)
        for name, cubic in (("ahead", self._ahead), ("astern", self._astern)):
            require_rising(name, cubic, self.dead_zone, self.thrust_max)

    def at(self, thrust: float) -> float:
        """Return the code of ``thrust`` (N) before it is made whole; it may be beyond the largest.

        Raises
        ------
        InputError
            If the thrust is not finite.
        """
        size = min(abs(finite_number("thrust", thrust)), self.thrust_max)
        if size <= self.dead_zone:
            return 0.0
        return value(self._ahead, size) if thrust > 0.0 else -value(self._astern, size)

    def code(self, thrust: float) -> int:
        """Return the nearest code, halves away from zero, no further than the largest. Raises as :meth:`at`."""
        return nearest_code(self.at(thrust), self.code_max)
