"""Columns of the thruster configuration matrix at given directions."""

from __future__ import annotations

import numpy as np

from marine_model.guards import FloatArray


def along_direction(columns: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Return the generalized force of a newton of every thruster, shape (n, m), from columns (n, m, 2) and azimuths."""
    along: FloatArray = columns[:, :, 0] * np.cos(azimuth)[:, None] + columns[:, :, 1] * np.sin(azimuth)[:, None]
    return along
