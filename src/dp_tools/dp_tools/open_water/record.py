"""What a trial leaves: the series of every case."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from marine_model.guards import FloatArray


@dataclass(frozen=True)
class CaseRecord:
    """Series of one case, shape (k,) each, at the end of every step.

    Attributes
    ----------
    thrust_demanded
        T_d, N, of the trial; anti-spin may let less of it through.
    thrust
        T, N, after losses.
    shaft_speed
        n, Hz.
    torque
        Motor torque Q_m, N m.
    power
        P_m = 2 pi n Q_m, W, [Ruth] (3.67).
    pitch_ratio
        P/D.
    thrust_loss, torque_loss
        beta_T and beta_Q.
    """

    thrust_demanded: FloatArray
    thrust: FloatArray
    shaft_speed: FloatArray
    torque: FloatArray
    power: FloatArray
    pitch_ratio: FloatArray
    thrust_loss: FloatArray
    torque_loss: FloatArray

    def part(self, chosen: slice) -> Self:
        """Return some samples."""
        return type(self)(**{name: getattr(self, name)[chosen] for name in QUANTITIES})


QUANTITIES = tuple(field.name for field in fields(CaseRecord))
UNITS = dict(zip(QUANTITIES, ("N", "N", "Hz", "N m", "W", "1", "1", "1"), strict=True))


@dataclass(frozen=True)
class Record:
    """Series of one trial.

    Attributes
    ----------
    t
        s, shape (k,).
    advance_speed
        V_A, m/s, shape (k,).
    submergence_ratio
        h/R, shape (k,); None where the propeller is deep.
    cases
        One for each case, by its name.
    """

    t: FloatArray
    advance_speed: FloatArray
    submergence_ratio: FloatArray | None
    cases: dict[str, CaseRecord]

    def window(self, start: float, end: float) -> slice:
        """Return which samples lie within ``start`` < t <= ``end`` (s): those of the steps between them."""
        first, last = np.searchsorted(self.t, (start + 1e-9, end + 1e-9))
        return slice(int(first), int(last))
