"""Force of the wind on a vessel: its windage and coefficients, and the one formula that simulator and controller share.

No numba here: the controller computes in plain Python; the simulator compiles :func:`wind_force` for itself.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from marine_model.guards import FloatArray
from marine_model.schema import FieldError, Fraction, NonNegative, Positive, Section
from marine_model.units import Unit

# Columns of WindForces.constants.
FRONTAL, LATERAL, LENGTH, AHEAD, TRANSVERSE, BOW, STERN, CROSS, AREA_RATIO = range(9)
# Columns of WindForces.table.
ANGLE, SURGE, SWAY, YAW = range(4)

# Angles are typed from tables in degrees with a few digits.
_ANGLE_DIGITS = 1e-3


class BlendermannCoefficients(Section):
    """Resistance coefficients of one class of ship, W. Blendermann (1994); Fossen (2011), Table 8.1."""

    model: Literal["blendermann"]
    transverse: Annotated[Positive, Unit("1")]  # CD_t
    longitudinal_bow: Annotated[NonNegative, Unit("1")]  # CD_l,AF in head wind
    longitudinal_stern: Annotated[NonNegative, Unit("1")]  # CD_l,AF in following wind
    cross_force: Fraction  # delta


class TabulatedCoefficients(Section):
    """Coefficients by angle of attack, of a hull symmetric to port and starboard; linear between two rows."""

    model: Literal["table"]
    # [gamma (rad), C_X, C_Y, C_N]: gamma from 0 (head wind) over wind from port to pi (following wind).
    rows: Annotated[
        tuple[Annotated[tuple[float, float, float, float], Field(strict=False)], ...], Field(strict=False), Unit("1")
    ]

    @model_validator(mode="after")
    def _half_a_turn(self) -> Self:
        angles = [row[ANGLE] for row in self.rows]
        if len(angles) < 2 or any(later <= earlier for earlier, later in pairwise(angles)):
            raise FieldError(("rows",), f"expected two rows or more with increasing angles, found {angles}")
        if abs(angles[0]) > _ANGLE_DIGITS or abs(angles[-1] - math.pi) > _ANGLE_DIGITS:
            raise FieldError(("rows",), f"expected angles from 0 to pi, found {angles[0]} to {angles[-1]}")
        for i in (0, len(self.rows) - 1):
            if self.rows[i][SWAY] != 0.0 or self.rows[i][YAW] != 0.0:
                raise FieldError(
                    ("rows", i),
                    "expected C_Y and C_N of 0 in head and following wind, where they change sign, "
                    f"found {self.rows[i][SWAY]} and {self.rows[i][YAW]}",
                )
        return self


class WindForces(Section):
    """Windage above the waterline, at the scale of the file, and wind coefficients.

    X = q A_F C_X, Y = q A_L C_Y, N = q A_L L C_N with q = rho V_rw^2 / 2; Fossen (2011), 8.1.
    """

    length: Annotated[Positive, Unit("m")]  # over all
    frontal_area: Annotated[Positive, Unit("m^2")]  # A_F
    lateral_area: Annotated[Positive, Unit("m^2")]  # A_L
    centroid_ahead: Annotated[float, Unit("m")]  # s_L: centroid of A_L ahead of the origin
    centroid_height: Annotated[Positive, Unit("m")]  # of A_L above the waterline: where the wind is taken
    density: Annotated[Positive, Unit("kg/m^3")] = 1.247  # of air at 10 deg C
    coefficients: Annotated[BlendermannCoefficients | TabulatedCoefficients, Field(discriminator="model")]

    def constants(self) -> FloatArray:
        """Return the numbers of :func:`wind_force`, shape (9,), in the order of the column names."""
        row = np.zeros(9)
        row[FRONTAL] = 0.5 * self.density * self.frontal_area
        row[LATERAL] = 0.5 * self.density * self.lateral_area
        row[LENGTH], row[AHEAD] = self.length, self.centroid_ahead
        row[AREA_RATIO] = self.frontal_area / self.lateral_area
        data = self.coefficients
        if isinstance(data, BlendermannCoefficients):
            row[TRANSVERSE], row[CROSS] = data.transverse, data.cross_force
            row[BOW], row[STERN] = data.longitudinal_bow, data.longitudinal_stern
        return row

    def table(self) -> FloatArray:
        """Return the rows of a table of coefficients, shape (k, 4); (0, 4) for Blendermann's formulas."""
        data = self.coefficients
        # Writable: numba takes an array that is not for another type, and would compile twice.
        return np.zeros((0, 4)) if isinstance(data, BlendermannCoefficients) else np.array(data.rows)


def wind_force(constants: FloatArray, table: FloatArray, u: float, v: float) -> tuple[float, float, float]:
    """Return the force of the wind: surge (N), sway (N), yaw (N m) in the body frame.

    The angle of attack is gamma = -atan2(v, u) of the vessel's velocity (u, v) relative to the air: 0 in head wind, pi
    in following wind, positive in wind from port. With L the length, s_L the lever of the lateral area and
    CD_l = CD_l,AF A_F / A_L, Fossen (2011), (8.35)-(8.38) after Blendermann,

        C_X = -CD_l,AF cos(gamma) / d,  C_Y = CD_t sin(gamma) / d,  C_N = (s_L / L - 0.18 (|gamma| - pi / 2)) C_Y,
        d = 1 - delta / 2 (1 - CD_l / CD_t) sin^2(2 gamma).

    His C_N stands for gamma from 0 to pi; |gamma| makes it odd, as port and starboard are alike.

    Parameters
    ----------
    constants, table
        Of :class:`WindForces`.
    u, v
        Velocity over ground less that of the air, in the body frame (u_rw, v_rw), m/s.
    """
    speed = math.sqrt(u * u + v * v)
    if speed == 0.0:
        return 0.0, 0.0, 0.0
    rows = len(table)
    if rows > 0:
        angle = min(max(math.atan2(abs(v), u), table[0, ANGLE]), table[rows - 1, ANGLE])
        i = 0
        while i < rows - 2 and angle > table[i + 1, ANGLE]:
            i += 1
        share = (angle - table[i, ANGLE]) / (table[i + 1, ANGLE] - table[i, ANGLE])
        c_x = table[i, SURGE] + share * (table[i + 1, SURGE] - table[i, SURGE])
        c_y = table[i, SWAY] + share * (table[i + 1, SWAY] - table[i, SWAY])
        c_n = table[i, YAW] + share * (table[i + 1, YAW] - table[i, YAW])
        side = 1.0 if v < 0.0 else -1.0
        square = speed * speed
        return (
            constants[FRONTAL] * square * c_x,
            side * constants[LATERAL] * square * c_y,
            side * constants[LATERAL] * constants[LENGTH] * square * c_n,
        )
    longitudinal = constants[BOW] if u >= 0.0 else constants[STERN]
    # V cos(gamma) = u, V sin(gamma) = -v.
    sine = 2.0 * u * v / (speed * speed)
    ratio = longitudinal * constants[AREA_RATIO] / constants[TRANSVERSE]
    divisor = 1.0 - 0.5 * constants[CROSS] * (1.0 - ratio) * sine * sine
    x = -constants[FRONTAL] * longitudinal * speed * u / divisor
    y = -constants[LATERAL] * constants[TRANSVERSE] * speed * v / divisor
    lever = constants[AHEAD] - 0.18 * (math.atan2(abs(v), u) - 0.5 * math.pi) * constants[LENGTH]
    return x, y, lever * y
