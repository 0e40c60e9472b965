"""What an operator may change about the drivers."""

from __future__ import annotations

from typing import Literal

from marine_model.settings import Settings, setting


class DriverSettings(Settings):
    """Options of :class:`thruster_drivers.Drivers`; gains belong to the vessel file."""

    controller: Literal["shaft_speed"] = setting("shaft_speed", "Local control law that turns thrust into motor torque")
    command_timeout: float = setting(
        0.0,
        "Age of the newest command beyond which thrust is ramped to zero; 0 takes the vessel file's limit",
        unit="s",
        ge=0.0,
        le=60.0,
    )
