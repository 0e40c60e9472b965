"""Where the first quadrant ends: the advance number at which a propeller has no thrust left."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers.base import PropellerModel
from marine_model.root import rising_root

_LARGEST = 64.0  # of the advance numbers that a model without an end is searched to: 20 times that of any propeller


def last_advance_number(model: PropellerModel, pitch_ratio: ArrayLike | None = None) -> FloatArray:
    """Return the advance number at which thrust is zero, or where the data end if there is thrust up to there.

    Parameters
    ----------
    model
        The propeller. Its thrust coefficient must fall with J, as it does in open water.
    pitch_ratio
        P/D, any shape; None for the design pitch ratio.

    Raises
    ------
    InputError
        If there is no thrust at J = 0, or a model without an end has thrust at any J.
    """
    pitch = np.asarray(model.pitch_ratio if pitch_ratio is None else pitch_ratio, dtype=np.float64)
    at_rest = np.asarray(model.coefficients(np.zeros(pitch.shape), pitch)[0])
    if np.any(at_rest <= 0.0):
        low = float(pitch[at_rest <= 0.0].max())
        raise InputError(f"pitch_ratio: expected thrust ahead at J = 0, found none at P/D = {low:g}")
    end = np.asarray(model.advance_number_end(pitch), dtype=np.float64)
    if not np.all(np.isfinite(end)):
        end = np.where(np.isfinite(end), end, _beyond(model, pitch))
    # A range that ends with the thrust leaves of it what rounding does.
    beyond = model.coefficients(end, pitch)[0] < -1e-12 * at_rest
    if not np.any(beyond):
        return end
    found = rising_root(lambda J: -model.coefficients(J, pitch)[0], np.zeros(end.shape), end)
    return np.where(beyond, found, end)


def _beyond(model: PropellerModel, pitch: FloatArray) -> float:
    """Return an advance number at which no pitch ratio has thrust, at most twice the largest of zero thrust."""
    J = 0.5
    while np.any(model.coefficients(J, pitch)[0] >= 0.0):
        J *= 2.0
        if J > _LARGEST:
            raise InputError(
                f"propeller: expected thrust that ends at some advance number, found it at J = {J / 2.0:g}"
            )
    return J
