"""The wave components that settings ask for."""

from __future__ import annotations

import math

import numpy as np

from marine_model.guards import FloatArray
from vessel_sim.settings import WaveSettings
from vessel_sim.waves.components import WIDTH, component_table
from vessel_sim.waves.irregular import IrregularSea
from vessel_sim.waves.spectrum import Jonswap


def components_of(settings: WaveSettings, seed: int | np.random.SeedSequence) -> FloatArray:
    """Return the components, fully grown everywhere, shape (m, ``components.WIDTH``); none for a calm sea.

    The same settings and seed give the same components, also if other waves were in between; another significant height
    gives the same with other amplitudes.
    """
    if settings.kind == "regular":
        if settings.amplitude == 0.0:
            return np.zeros((0, WIDTH))
        omega = np.array([2.0 * math.pi / settings.period])
        return component_table(omega, settings.direction, settings.amplitude, 0.0)
    if settings.significant_height == 0.0:
        return np.zeros((0, WIDTH))
    peakedness = settings.peakedness if settings.kind == "jonswap" else 1.0
    spectrum = Jonswap(settings.significant_height, settings.peak_period, peakedness)
    sea = IrregularSea(spectrum, settings.direction, seed, settings.components, spreading=settings.spreading)
    return sea.components
