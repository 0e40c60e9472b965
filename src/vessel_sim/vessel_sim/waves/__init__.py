"""The sea, and what it does to the hull: linear deep-water waves.

A train travels towards direction beta (NED). With k = omega^2 / g and phase

    theta = k (north cos beta + east sin beta) - omega t + epsilon,

the elevation is a cos(theta) and a water particle at depth z is displaced by -a exp(-k z) sin(theta) along the
direction of travel and by a exp(-k z) cos(theta) upwards (linear wave theory). A sea is a sum of trains, whose
amplitudes may be steps that travel with the group velocity.
"""

from vessel_sim.waves.at_ship import Waves
from vessel_sim.waves.computed_hull import ComputedHull
from vessel_sim.waves.hull_form import HullForm
from vessel_sim.waves.hull_in_waves import HullInWaves
from vessel_sim.waves.irregular import IrregularSea
from vessel_sim.waves.of_vessel import hull_in_waves
from vessel_sim.waves.sea import Sea
from vessel_sim.waves.spectrum import Jonswap
from vessel_sim.waves.spreading import spread_directions

__all__ = [
    "ComputedHull",
    "HullForm",
    "HullInWaves",
    "IrregularSea",
    "Jonswap",
    "Sea",
    "Waves",
    "hull_in_waves",
    "spread_directions",
]
