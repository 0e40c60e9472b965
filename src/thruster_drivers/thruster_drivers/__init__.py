"""Local thruster control: thrust to shaft speed to motor torque, and the azimuth direction. Pure Python."""

from thruster_drivers.command import CommandReader, ThrusterCommand
from thruster_drivers.drivers import DriverInputs, DriverOutput, Drivers
from thruster_drivers.settings import DriverSettings

__all__ = [
    "CommandReader",
    "DriverInputs",
    "DriverOutput",
    "DriverSettings",
    "Drivers",
    "ThrusterCommand",
]
