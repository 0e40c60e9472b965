"""An irregular sea."""

from __future__ import annotations

import math

import numpy as np

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number
from vessel_sim.waves.components import component_table
from vessel_sim.waves.sea import Sea
from vessel_sim.waves.spectrum import Jonswap
from vessel_sim.waves.spreading import spread_directions


class IrregularSea(Sea):
    """Components of equal energy with random phases, long-crested or short-crested.

    The energy of the spectrum is cut into ``count`` equal shares, and every component takes a random place within its
    share. All amplitudes are H_s / sqrt(8 count), so that 4 sqrt(m_0) is H_s to rounding in every realisation;
    components lie close together where the energy is. The frequencies have no common divisor, so that the record does
    not repeat itself, as one of equally spaced frequencies would after 2 pi / (their distance).

    Waves above ``cutoff`` times the peak frequency are left out and their energy (0.13 % above 5) is given to the
    others: in linear theory the steepness of the whole tail has no bound.

    In a short-crested sea the spreading function is cut into ``count`` equal shares too, and every component takes a
    random place within one of them; which one has nothing to do with its frequency.

    Parameters
    ----------
    spectrum
        The spectrum.
    direction
        Direction in NED that the waves travel towards, in the mean, rad.
    seed
        Of places and phases; the same seed gives the same sea. An integer, or what numpy spawns from one.
    count
        Number of components, at least 1.
    cutoff
        Highest frequency over that of the peak, above 1.
    spreading
        s of cos^2s(delta / 2), see ``spread_directions``; 0 for a long-crested sea.

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    def __init__(
        self,
        spectrum: Jonswap,
        direction: float,
        seed: int | np.random.SeedSequence,
        count: int = 200,
        cutoff: float = 5.0,
        spreading: float = 0.0,
    ) -> None:
        beta = finite_number("direction", direction)
        if count < 1:
            raise InputError(f"count: expected at least 1, found {count}")
        if finite_number("cutoff", cutoff) <= 1.0:
            raise InputError(f"cutoff: expected a number above 1, found {cutoff}")
        if isinstance(seed, int) and seed < 0:
            raise InputError(f"seed: expected at least 0, found {seed}")
        self.spectrum = spectrum
        random = np.random.Generator(np.random.PCG64(seed))
        place, angle = random.random((2, count))
        omega = spectrum.frequencies((np.arange(count) + place) / count, cutoff)
        towards = np.full(count, beta)
        if finite_number("spreading", spreading) != 0.0:
            towards += spread_directions((random.permutation(count) + random.random(count)) / count, spreading)
        amplitude = spectrum.significant_height / math.sqrt(8.0 * count)
        self._components = component_table(omega, towards, amplitude, 2.0 * math.pi * angle)

    @property
    def components(self) -> FloatArray:
        """Components, shape (count, ``components.WIDTH``)."""
        return self._components
