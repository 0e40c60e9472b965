"""Propulsion plant: shafts, propellers, azimuth and pitch actuators of all thrusters in one step."""

from vessel_sim.propulsion.plant import PropulsionPlant
from vessel_sim.propulsion.tables import PlantTables

__all__ = ["PlantTables", "PropulsionPlant"]
