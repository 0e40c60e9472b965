"""The hull as a potential-flow code sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from marine_model.constants import GRAVITY
from marine_model.guards import FloatArray
from marine_model.wave_response import WaveResponse
from vessel_sim.waves.hull_in_waves import HullInWaves
from vessel_sim.waves.response_table import DRIFT_X, FUNCTIONS


@dataclass(frozen=True, slots=True)
class ComputedHull(HullInWaves):
    """A hull whose response was computed; the data have no dimensions and serve every scale of it.

    Parameters
    ----------
    response
        Motion over the amplitude (surge, sway, heave) and over the amplitude per length (roll, pitch, yaw); drift over
        rho g L a^2 (surge, sway) and rho g L^2 a^2 (yaw).
    length
        L, m.
    density
        rho, kg/m^3.
    drift_factor
        What the drift is multiplied by.
    """

    response: WaveResponse
    length: float
    density: float
    drift_factor: float = 1.0

    def responses(self, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the data at the frequencies, with dimensions."""
        motion, drift = self.response.at(omega * np.sqrt(self.length / GRAVITY))
        values = np.empty((*motion.shape[:2], FUNCTIONS))
        scaled = motion / np.array([1.0, 1.0, 1.0, self.length, self.length, self.length])
        values[:, :, 0:DRIFT_X:2] = scaled.real
        values[:, :, 1:DRIFT_X:2] = scaled.imag
        force = self.drift_factor * self.density * GRAVITY * self.length
        values[:, :, DRIFT_X:] = drift * np.array([force, force, force * self.length])
        return self.response.heading, values
