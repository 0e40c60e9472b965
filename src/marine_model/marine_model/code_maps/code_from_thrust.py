"""Code of a thrust at a speed, [Kostenko] (8), Table 4."""

from __future__ import annotations

import math
from collections.abc import Sequence

from marine_model.code_maps.codes import nearest_code
from marine_model.code_maps.cubic import Cubic, require_rising, value
from marine_model.code_maps.speeds import Speeds
from marine_model.errors import InputError
from marine_model.guards import finite_number, positive_number


class CodeFromThrust:
    """N = K_N0S(V) sign T + K_N1S(V) T + K_N2S(V) T |T| + K_N3S(V) T^3; 0 for the smallest thrusts.

    Thrust beyond T_max(V) is saturated there, and the code at the largest of the drive. Between two speeds the codes of
    both at the same thrust are weighted; T_max(V) is linear between its values. The column of the higher speed is then
    used beyond its own T_max, up to that of the lower one, and is checked to rise that far.

    Parameters
    ----------
    speeds
        Of the columns.
    thrust_max
        T_max, N, above 0 and not rising: one a speed, as what follows.
    constant, linear, quadratic, cubic
        K_N0S, 1; K_N1S, 1/N; K_N2S, 1/N^2, the one that is labelled K_N3S a second time in print; K_N3S, 1/N^3.
    dead_zone
        N: thrust not above this gets code 0.
    code_max
        Largest code.

    Raises
    ------
    InputError
        If a column does not rise.
    """

    def __init__(
        self,
        speeds: Speeds,
        thrust_max: Sequence[float],
        constant: Sequence[float],
        linear: Sequence[float],
        quadratic: Sequence[float],
        cubic: Sequence[float],
        dead_zone: float,
        code_max: int,
    ) -> None:
        self.speeds = speeds
        self.dead_zone = positive_number("dead_zone", dead_zone)
        self.code_max = code_max
        self._thrust_max = speeds.require_column_each("thrust_max", thrust_max)
        rows = {"constant": constant, "linear": linear, "quadratic": quadratic, "cubic": cubic}
        columns = [speeds.require_column_each(name, row) for name, row in rows.items()]
        self._columns: tuple[Cubic, ...] = tuple(zip(*columns, strict=True))
        reach = math.inf
        for i, (largest, column) in enumerate(zip(self._thrust_max, self._columns, strict=True)):
            if not self.dead_zone < largest <= reach:
                raise InputError(
                    f"thrust_max[{i}]: expected a number above {self.dead_zone:g} and not above {reach:g} before it, "
                    f"found {largest:g}"
                )
            require_rising(f"linear[{i}]", column, self.dead_zone, largest if i == 0 else reach)
            reach = largest

    def thrust_max(self, speed: float) -> float:
        """Return T_max (N) at ``speed`` (m/s). Raises InputError if the speed is outside the table."""
        return self.speeds.at(self._thrust_max, speed)

    def at(self, thrust: float, speed: float) -> float:
        """Return the code of ``thrust`` (N) at ``speed`` (m/s) before it is made whole; it may be above the largest.

        Raises
        ------
        InputError
            If the thrust is not finite, or the speed is outside the table.
        """
        i, weight = self.speeds.place(speed)
        size = min(abs(finite_number("thrust", thrust)), self.thrust_max(speed))
        if size <= self.dead_zone:
            return 0.0
        code = value(self._columns[i], size)
        if weight > 0.0:
            code = (1.0 - weight) * code + weight * value(self._columns[i + 1], size)
        return math.copysign(code, thrust)

    def code(self, thrust: float, speed: float) -> int:
        """Return the nearest code, halves away from zero, no further than the largest. Raises as :meth:`at`."""
        return nearest_code(self.at(thrust, speed), self.code_max)
