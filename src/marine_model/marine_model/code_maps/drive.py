"""A drive that is asked for codes, and the torque that a code means, [Kostenko] (1)-(3)."""

from __future__ import annotations

import math
from typing import SupportsIndex

from marine_model.code_maps.code_from_thrust import CodeFromThrust
from marine_model.code_maps.codes import require_code
from marine_model.code_maps.rest_code_from_thrust import RestCodeFromThrust
from marine_model.code_maps.thrust_from_code import ThrustFromCode
from marine_model.errors import InputError
from marine_model.guards import finite_number, positive_number
from marine_model.propellers.base import PropellerModel


class CodeDrive:
    """Maps of one drive and its mechanical characteristic M(n, N) of (3).

    The print has M(n, N) as a figure only. What (4) and the propeller say of it: at no speed through the water code N
    turns the shaft at n_0 where K_T0 rho D^4 n_0^2 is the thrust of N, with the torque M_0 = K_Q0 rho D^5 n_0^2. From
    there the torque falls with the shaft speed by ``torque_droop`` = d:

        M(n, N) = M_0(N) - d (n - n_0(N)) for N > 0, and odd in (n, N).

    Parameters
    ----------
    thrust_from_code, code_from_thrust, rest_code_from_thrust
        (4), (8) and (7).
    propeller
        Whose K_T0 and K_Q0 are taken.
    density
        rho, kg/m^3.
    torque_droop
        d, N m/Hz; 0 for a drive whose torque does not depend on the shaft speed.

    Raises
    ------
    InputError
        If the density is not above 0, or the droop is below 0.
    """

    def __init__(
        self,
        thrust_from_code: ThrustFromCode,
        code_from_thrust: CodeFromThrust,
        rest_code_from_thrust: RestCodeFromThrust,
        propeller: PropellerModel,
        density: float,
        torque_droop: float = 0.0,
    ) -> None:
        self.thrust_from_code = thrust_from_code
        self.code_from_thrust = code_from_thrust
        self.rest_code_from_thrust = rest_code_from_thrust
        self.speeds = code_from_thrust.speeds
        self.code_max = thrust_from_code.code_max
        self.torque_droop = finite_number("torque_droop", torque_droop)
        if self.torque_droop < 0.0:
            raise InputError(f"torque_droop: expected a number not below 0, found {torque_droop:g}")
        thrust, torque = (float(k) for k in propeller.coefficients(0.0))
        self._thrust_per_square = thrust * positive_number("density", density) * propeller.diameter**4
        self._torque_per_thrust = torque * propeller.diameter / thrust

    def code(self, thrust: float, speed: float | None) -> int:
        """Return the code for ``thrust`` (N) at ``speed`` (m/s), (8); without a speed (None) that at rest, (7).

        Raises
        ------
        InputError
            If the thrust is not finite, or the speed is outside the tables.
        """
        if speed is None:
            return self.rest_code_from_thrust.code(thrust)
        return self.code_from_thrust.code(thrust, speed)

    def rest_shaft_speed(self, code: SupportsIndex) -> float:
        """Return n_0 (Hz) of a code, with its sign; 0 in the dead zone. Raises InputError if it is no code."""
        thrust = self.thrust_from_code.thrust(code, 0.0)
        return math.copysign(math.sqrt(abs(thrust) / self._thrust_per_square), thrust)

    def torque(self, code: SupportsIndex, shaft_speed: float) -> float:
        """Return M (N m) of a code at ``shaft_speed`` (Hz); where that is not finite, M_0.

        Raises
        ------
        InputError
            If ``code`` is not whole or beyond the largest.
        """
        thrust = self.thrust_from_code.thrust(require_code(code, self.code_max), 0.0)
        torque = self._torque_per_thrust * thrust
        if self.torque_droop == 0.0 or not math.isfinite(shaft_speed):
            return torque
        rest = math.copysign(math.sqrt(abs(thrust) / self._thrust_per_square), thrust)
        return torque - self.torque_droop * (shaft_speed - rest)
