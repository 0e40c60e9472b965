"""Simulated vessel: hull, thrusters, waves, current, wind and sensors. The core is free of middleware."""

from vessel_sim.settings import (
    CurrentSettings,
    InitialState,
    PropulsionSettings,
    SimulatorSettings,
    WaveSettings,
    WindSettings,
)
from vessel_sim.simulator import Simulator, SimulatorInputs, SimulatorOutput, SimulatorTruth

__all__ = [
    "CurrentSettings",
    "InitialState",
    "PropulsionSettings",
    "Simulator",
    "SimulatorInputs",
    "SimulatorOutput",
    "SimulatorSettings",
    "SimulatorTruth",
    "WaveSettings",
    "WindSettings",
]
