"""Memory of torque losses: what a propeller has lost to air counts at once and is forgotten slowly."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector, positive_number


@compiled
def remembered(ventilating: bool, beta_q: float, held: float, rise: float) -> float:
    """Return beta_Q2 of one thruster after a step in which it may rise by ``rise``, see :class:`LossMemory`."""
    target = min(beta_q, 1.0) if ventilating else 1.0
    return min(target, held + rise)


class LossMemory:
    """beta_Q2 of [Ruth] (5.16)-(5.17), for a row of thrusters.

    beta_Q1 is beta_Q while a thruster ventilates and 1 otherwise (5.16). beta_Q2 falls to it at once and rises to it
    no faster than ``rate``. (5.17) is printed with derivatives; over a step of dt with beta_Q1 held it is

        beta_Q2 <- min(beta_Q1, beta_Q2 + rate dt).

    A loss factor above 1 (air makes no propeller heavier) counts as 1.

    Parameters
    ----------
    count
        Number of thrusters, n.
    rate
        Largest rise, 1/s, above 0.

    Raises
    ------
    InputError
        If ``rate`` is not above 0.
    """

    def __init__(self, count: int, rate: float) -> None:
        self._count = count
        self.rate = rate
        self._held: FloatArray = np.ones(count)

    @property
    def rate(self) -> float:
        """Largest rise, 1/s."""
        return self._rate

    @rate.setter
    def rate(self, value: float) -> None:
        self._rate = positive_number("rate", value)

    @property
    def value(self) -> FloatArray:
        """beta_Q2 of the last step, shape (n,); 1 before the first. A copy."""
        return self._held.copy()

    def reset(self) -> None:
        """Forget all losses."""
        self._held = np.ones(self._count)

    def step(self, ventilating: ArrayLike, beta_q: ArrayLike, dt: float) -> FloatArray:
        """Return beta_Q2, shape (n,).

        Parameters
        ----------
        ventilating
            Shape (n,), bool.
        beta_q
            Torque loss factor, shape (n,).
        dt
            s since the last step, above 0.

        Raises
        ------
        InputError
            If a shape is wrong, a loss factor is not finite or ``dt`` is not above 0; nothing has changed then.
        """
        elapsed = positive_number("dt", dt)
        factor = finite_vector("beta_q", beta_q, self._count)
        flags = np.asarray(ventilating, dtype=bool)
        if flags.shape != (self._count,):
            raise InputError(f"ventilating: expected shape ({self._count},), found {flags.shape}")
        told = zip(flags.tolist(), factor.tolist(), self._held.tolist(), strict=True)
        rise = self._rate * elapsed
        self._held = np.array([remembered(flag, beta, held, rise) for flag, beta, held in told], dtype=np.float64)
        return self._held.copy()
