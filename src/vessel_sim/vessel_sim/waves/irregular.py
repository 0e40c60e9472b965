"""An irregular long-crested sea."""

from __future__ import annotations

import math

import numpy as np

from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number
from vessel_sim.waves.components import AMPLITUDE, COS_BETA, OMEGA, PHASE, SIN_BETA, WAVE_NUMBER, WIDTH
from vessel_sim.waves.sea import Sea
from vessel_sim.waves.spectrum import Jonswap


class IrregularSea(Sea):
    """Components of equal energy with random phases, all in one direction.

    The energy of the spectrum is cut into ``count`` equal shares, and every component takes a random place within its
    share. All amplitudes are H_s / sqrt(8 count), so that 4 sqrt(m_0) is H_s to rounding in every realisation;
    components lie close together where the energy is. The frequencies have no common divisor, so that the record does
    not repeat itself, as one of equally spaced frequencies would after 2 pi / (their distance).

    Waves above ``cutoff`` times the peak frequency are left out and their energy (0.13 % above 5) is given to the
    others: in linear theory the steepness of the whole tail has no bound.

    Parameters
    ----------
    spectrum
        The spectrum.
    direction
        Direction in NED that the waves travel towards, rad.
    seed
        Of places and phases; the same seed gives the same sea.
    count
        Number of components, at least 1.
    cutoff
        Highest frequency over that of the peak, above 1.

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    def __init__(self, spectrum: Jonswap, direction: float, seed: int, count: int = 200, cutoff: float = 5.0) -> None:
        beta = finite_number("direction", direction)
        if count < 1:
            raise InputError(f"count: expected at least 1, found {count}")
        if finite_number("cutoff", cutoff) <= 1.0:
            raise InputError(f"cutoff: expected a number above 1, found {cutoff}")
        if seed < 0:
            raise InputError(f"seed: expected at least 0, found {seed}")
        self.spectrum = spectrum
        place, angle = np.random.Generator(np.random.PCG64(seed)).random((2, count))
        omega = spectrum.frequencies((np.arange(count) + place) / count, cutoff)
        table = np.zeros((count, WIDTH))
        table[:, OMEGA] = omega
        table[:, WAVE_NUMBER] = omega**2 / GRAVITY
        table[:, COS_BETA] = math.cos(beta)
        table[:, SIN_BETA] = math.sin(beta)
        table[:, AMPLITUDE] = spectrum.significant_height / math.sqrt(8.0 * count)
        table[:, PHASE] = 2.0 * math.pi * angle
        self._components = table

    @property
    def components(self) -> FloatArray:
        """Components, shape (count, ``components.WIDTH``)."""
        return self._components
