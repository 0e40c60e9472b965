"""The sea, and what it does to the hull: linear deep-water waves.

A train travels towards direction beta (NED). With k = omega^2 / g and phase

    theta = k (north cos beta + east sin beta) - omega t + epsilon,

the elevation is a cos(theta) and a water particle at depth z is displaced by -a exp(-k z) sin(theta) along the
direction of travel and by a exp(-k z) cos(theta) upwards (linear wave theory). A sea is a sum of trains.
"""

from vessel_sim.waves.hull_form import HullForm
from vessel_sim.waves.irregular import IrregularSea
from vessel_sim.waves.regular import Waves
from vessel_sim.waves.sea import Sea
from vessel_sim.waves.spectrum import Jonswap
from vessel_sim.waves.train import WaveTrain

__all__ = ["HullForm", "IrregularSea", "Jonswap", "Sea", "WaveTrain", "Waves"]
