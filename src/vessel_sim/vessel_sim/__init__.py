"""Simulated vessel: hull or submerged body, thrusters, sea, wind and sensors. The core is free of middleware."""

from vessel_sim.interface import SimulatorInputs, SimulatorOutput, SimulatorTruth, VesselSimulator
from vessel_sim.make_simulator import make_simulator
from vessel_sim.settings import (
    CurrentSettings,
    InitialState,
    PropulsionSettings,
    SimulatorSettings,
    WaveSettings,
    WindSettings,
)
from vessel_sim.simulator import Simulator
from vessel_sim.underwater import UnderwaterSimulator

__all__ = [
    "CurrentSettings",
    "InitialState",
    "PropulsionSettings",
    "Simulator",
    "SimulatorInputs",
    "SimulatorOutput",
    "SimulatorSettings",
    "SimulatorTruth",
    "UnderwaterSimulator",
    "VesselSimulator",
    "WaveSettings",
    "WindSettings",
    "make_simulator",
]
