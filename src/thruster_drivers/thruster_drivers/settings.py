"""What an operator may change about the drivers."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import model_validator

from marine_model.settings import Settings, setting
from marine_model.vessel import Vessel
from thruster_drivers.ventilation.settings import AntiSpinSettings, VentilationSettings


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
    ventilation: VentilationSettings = VentilationSettings()
    antispin: AntiSpinSettings = AntiSpinSettings()

    @model_validator(mode="after")
    def _antispin_needs_the_observer(self) -> Self:
        if self.antispin.enabled and not self.ventilation.enabled:
            raise ValueError("antispin.enabled must be false while ventilation.enabled is, because it needs its observer")
        return self

    @classmethod
    def for_vessel(cls, vessel: Vessel) -> Self:
        """Return the defaults with the vessel's own numbers, so that parameters show what is in force."""
        return cls(
            command_timeout=vessel.drivers.command_timeout,
            ventilation=VentilationSettings.for_vessel(vessel),
        )
