"""The nodes of the graph and the settings of each, so that tools can check parameters without a running node."""

from __future__ import annotations

from dp_controller import ControllerSettings
from dp_observer import ObserverSettings
from marine_model import Vessel
from marine_model.settings import Settings
from thrust_allocator import AllocatorSettings
from thruster_drivers import DriverSettings
from vessel_sim import SimulatorSettings

SIMULATOR = "vessel_sim"
OBSERVER = "dp_observer"
CONTROLLER = "dp_controller"
ALLOCATOR = "thrust_allocator"
DRIVERS = "thruster_drivers"


def default_settings(vessel: Vessel) -> dict[str, Settings]:
    """Return the settings of every node, by node name, that hold when nothing overrides them."""
    return {
        SIMULATOR: SimulatorSettings.for_vessel(vessel),
        OBSERVER: ObserverSettings(),
        CONTROLLER: ControllerSettings(),
        ALLOCATOR: AllocatorSettings.for_vessel(vessel),
        DRIVERS: DriverSettings.for_vessel(vessel),
    }
