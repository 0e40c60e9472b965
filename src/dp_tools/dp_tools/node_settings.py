"""The nodes of the graph and the settings of each, so that tools can check parameters without a running node."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import dp_controller.settings
import thrust_allocator.settings
import thruster_drivers.settings
import vessel_sim.settings
from dp_controller import ControllerSettings
from dp_observer import ObserverSettings
from marine_model import Vessel
from marine_model.settings import Settings, with_parameters
from thrust_allocator import AllocatorSettings
from thruster_drivers import DriverSettings
from vessel_sim import SimulatorSettings
from vessel_sim.time_settings import NodeSettings

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
        CONTROLLER: ControllerSettings.for_vessel(vessel),
        ALLOCATOR: AllocatorSettings.for_vessel(vessel),
        DRIVERS: DriverSettings.for_vessel(vessel),
    }


def declared_settings(vessel: Vessel) -> dict[str, Settings]:
    """Return the settings whose fields are the parameters of every node: how time goes at the simulator among them."""
    return {**default_settings(vessel), SIMULATOR: NodeSettings.for_vessel(vessel)}


_CHECKS: Mapping[str, Callable[[Any, Vessel], None]] = {
    SIMULATOR: vessel_sim.settings.check_settings,
    CONTROLLER: dp_controller.settings.check_settings,
    ALLOCATOR: thrust_allocator.settings.check_settings,
    DRIVERS: thruster_drivers.settings.check_settings,
}


def changed_settings(node: str, settings: Settings, changes: Mapping[str, Any], vessel: Vessel) -> Settings:
    """Return the settings of ``node`` with some parameters changed, judged as the node does.

    Raises
    ------
    InputError
        If a name is unknown, a value is refused, or the settings do not fit the vessel.
    """
    changed = with_parameters(settings, changes)
    if node in _CHECKS:
        _CHECKS[node](changed, vessel)
    return changed
