"""What an operator may change about the drivers."""

from __future__ import annotations

import math
from typing import Self

from pydantic import field_validator, model_validator

from marine_model.errors import InputError
from marine_model.settings import Settings, setting
from marine_model.thruster import Thruster
from marine_model.vessel import Vessel
from thruster_drivers.controllers import CONTROLLERS, needs_drive, needs_pitch
from thruster_drivers.ventilation.settings import AntiSpinSettings, VentilationSettings


class CodeMapSettings(Settings):
    """How thrust becomes an integer code."""

    compensated: bool = setting(
        True,
        "Law code_map: true takes codes for the vessel's surge speed, from odometry; false those at rest",
    )


class DriverSettings(Settings):
    """Options of :class:`thruster_drivers.Drivers`; gains belong to the vessel file."""

    controller: str = setting(
        "shaft_speed",
        "Local control law that turns thrust into motor torque and pitch: one for all thrusters, or one for each in "
        f"the order of the vessel file with commas between (any of: {', '.join(CONTROLLERS)})",
    )
    advance_speed: float = setting(
        0.0,
        "Advance speed that torque_pitch and shaft_speed_pitch find the best pitch for",
        unit="m/s",
        ge=0.0,
        le=30.0,
    )
    command_timeout: float = setting(
        0.0,
        "Age of the newest command beyond which thrust is ramped to zero; 0 takes the vessel file's limit",
        unit="s",
        ge=0.0,
        le=60.0,
    )
    code_map: CodeMapSettings = CodeMapSettings()
    ventilation: VentilationSettings = VentilationSettings()
    antispin: AntiSpinSettings = AntiSpinSettings()

    @field_validator("controller")
    @classmethod
    def _known(cls, value: str) -> str:
        for name in _split(value):
            if name not in CONTROLLERS:
                raise ValueError(f"expected {', '.join(CONTROLLERS)}, or a list of them, found '{name}'")
        return value

    def controllers(self, vessel: Vessel) -> tuple[str, ...]:
        """Return the law of every thruster of ``vessel``, in file order.

        Raises
        ------
        InputError
            If there are neither one nor as many laws as thrusters, or a thruster has not the pitch or the drive that
            its law needs, or that drive's torque falls too steeply with the shaft speed for the time step.
        """
        names, n = _split(self.controller), len(vessel.thrusters)
        if len(names) == 1:
            names *= n
        if len(names) != n:
            raise InputError(
                f"controller: expected one law, or {n}, one a thruster ({', '.join(vessel.thruster_names)}), "
                f"found {len(names)}"
            )
        for thruster, name in zip(vessel.thrusters, names, strict=True):
            if thruster.pitch is None and needs_pitch(name):
                raise InputError(
                    f"controller: expected a law for a fixed pitch at thruster '{thruster.name}', found '{name}', "
                    "which needs a controllable pitch"
                )
            if needs_drive(name):
                _check_drive(thruster, name, vessel.simulation.time_step)
        return names

    def needs_speed(self, vessel: Vessel) -> bool:
        """Return whether a law looks at the speed of ``vessel``. Raises InputError as :meth:`controllers`."""
        return self.code_map.compensated and any(map(needs_drive, self.controllers(vessel)))

    @model_validator(mode="after")
    def _antispin_needs_the_observer(self) -> Self:
        if self.antispin.enabled and not self.ventilation.enabled:
            raise ValueError(
                "antispin.enabled must be false while ventilation.enabled is, because it needs its observer"
            )
        return self

    @classmethod
    def for_vessel(cls, vessel: Vessel) -> Self:
        """Return the defaults with the vessel's own numbers, so that parameters show what is in force."""
        return cls(
            command_timeout=vessel.drivers.command_timeout,
            ventilation=VentilationSettings.for_vessel(vessel),
        )


def check_settings(settings: DriverSettings, vessel: Vessel) -> None:
    """Raise InputError if ``settings`` do not fit ``vessel``, such as a law that a thruster cannot follow."""
    settings.controllers(vessel)
    settings.antispin.check(vessel)
    if vessel.drivers.ventilation is not None:
        settings.ventilation.resolved(vessel)


def _check_drive(thruster: Thruster, law: str, time_step: float) -> None:
    drive = thruster.drive
    if drive is None:
        raise InputError(
            f"controller: expected a law without codes at thruster '{thruster.name}', found '{law}', "
            "which needs a section 'drive' in the vessel file"
        )
    # The torque holds for a time step: above this the shaft would be braked past the speed at which it has none.
    steepest = 2.0 * math.pi * thruster.shaft.inertia / time_step
    if drive.torque_droop > steepest:
        raise InputError(
            f"controller: expected a drive.torque_droop of at most {steepest:.4g} N m/Hz at thruster '{thruster.name}' "
            f"for '{law}', by its shaft's inertia and the time step, found {drive.torque_droop:g}"
        )


def _split(controller: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in controller.split(","))
