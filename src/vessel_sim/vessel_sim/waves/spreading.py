"""How the energy of a short-crested sea is spread over directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number


def spread_directions(share: ArrayLike, exponent: float) -> FloatArray:
    """Return the angles from the main direction below which lies ``share`` of the energy, rad in [-pi, pi].

    The spreading function is cos^2s(delta / 2) (Longuet-Higgins, Cartwright and Smith 1963). With t = sin^2(delta / 2)
    its energy within +-delta is the incomplete beta function I_t(1/2, s + 1/2), which SciPy inverts.

    Parameters
    ----------
    share
        In [0, 1].
    exponent
        s, above 0; the standard deviation is about sqrt(2 / s) rad for a large one.

    Raises
    ------
    InputError
        If ``exponent`` is not above 0.
    """
    from scipy.special import betaincinv  # here: its import is slow

    if finite_number("exponent", exponent) <= 0.0:
        raise InputError(f"exponent: expected a number above 0, found {exponent}")
    beside = 2.0 * np.asarray(share, dtype=np.float64) - 1.0
    half = np.arcsin(np.sqrt(betaincinv(0.5, exponent + 0.5, np.abs(beside))))
    return np.asarray(np.copysign(2.0 * half, beside))
