"""From the arrays of a message to a command in the order of the vessel file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector
from marine_model.vessel import Vessel


@dataclass(frozen=True, slots=True)
class ThrusterCommand:
    """A command fit for use.

    Attributes
    ----------
    thrust
        Shape (n,), N, within the vessel's limits.
    azimuth
        Shape (n,), rad.
    clipped
        Names of the thrusters whose thrust lay beyond a limit.
    """

    thrust: FloatArray
    azimuth: FloatArray
    clipped: tuple[str, ...]


class CommandReader:
    """Maps arrays to thrusters by name and checks them against a vessel."""

    def __init__(self, vessel: Vessel) -> None:
        self._names = vessel.thruster_names
        self._expected = list(vessel.thruster_names)
        self._thrust_min = vessel.thrust_min
        self._thrust_max = vessel.thrust_max
        # The allocator's own arithmetic may pass a limit by rounding; that is no news to an operator.
        self._rounding = 1e-9 * (vessel.thrust_max - vessel.thrust_min)

    def order(self, names: Sequence[str]) -> list[int] | None:
        """Return where each thruster of the vessel stands in ``names``; None if the order is the vessel's.

        Raises
        ------
        InputError
            If a thruster is unknown, missing or repeated.
        """
        found = list(names)
        if found == self._expected:
            return None
        if sorted(found) != sorted(self._expected):
            raise InputError(f"name: expected {self._expected} in any order, found {found}")
        return [found.index(name) for name in self._expected]

    def in_order(self, name: str, values: ArrayLike, order: list[int] | None) -> FloatArray:
        """Return ``values`` as floats of shape (n,) in the vessel's order; NaN may be among them.

        Raises
        ------
        InputError
            If the length differs.
        """
        vector = np.asarray(values, dtype=np.float64)
        if vector.shape != (len(self._names),):
            raise InputError(f"{name}: expected shape ({len(self._names)},), found {vector.shape}")
        return vector if order is None else vector[order]

    def read(self, names: Sequence[str], thrust: ArrayLike, azimuth: ArrayLike) -> ThrusterCommand:
        """Return the command of a message.

        Raises
        ------
        InputError
            If names do not match the vessel's, a length differs, or a number is not finite. Thrust beyond a limit is
            not an error: it is clipped, and said in ``clipped``.
        """
        order = self.order(names)
        n = len(self._names)
        demanded = self.in_order("thrust", finite_vector("thrust", thrust, n), order)
        direction = self.in_order("azimuth", finite_vector("azimuth", azimuth, n), order)
        clipped = demanded.clip(self._thrust_min, self._thrust_max)
        beyond = np.abs(demanded - clipped) > self._rounding
        return ThrusterCommand(
            thrust=clipped,
            azimuth=direction,
            clipped=tuple(name for name, far in zip(self._names, beyond, strict=True) if far),
        )
