"""Vehicles below the surface, in six degrees of freedom."""

from vessel_sim.underwater.body import SubmergedBody
from vessel_sim.underwater.simulator import UnderwaterSimulator

__all__ = ["SubmergedBody", "UnderwaterSimulator"]
