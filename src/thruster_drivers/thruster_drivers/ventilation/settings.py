"""What an operator may change about ventilation detection and low-level anti-spin."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from marine_model.errors import InputError
from marine_model.propulsion import Propulsion
from marine_model.settings import Settings, setting
from marine_model.vessel import Vessel

Switches = Annotated[tuple[bool, ...], Field(strict=False)]
Speeds = Annotated[tuple[Annotated[float, Field(gt=0.0)], ...], Field(strict=False)]


class VentilationSettings(Settings):
    """Ventilation detection; without a section ``drivers.ventilation`` in the vessel file there is none."""

    enabled: bool = setting(True, "Detect ventilation and publish it; needs drivers.ventilation in the vessel file")
    method: Literal["torque_rate", "shaft_deceleration"] = setting(
        "torque_rate",
        "Conditions (5.14) at every feedback, or (B.41)-(B.43) at every sample of the control system",
    )
    on: float = setting(
        0.0,
        "Loss factor beta_Q below which a propeller ventilates; 0 takes the vessel file's",
        unit="1",
        ge=0.0,
        le=1.0,
    )
    off: float = setting(
        0.0, "Loss factor beta_Q above which it no longer does; 0 takes the vessel file's", unit="1", ge=0.0, le=1.0
    )
    speed_min: Speeds = setting(
        (),
        "Per thruster: shaft speed below which ventilation is never flagged; empty takes the vessel file's",
        unit="Hz",
    )
    excluded: Switches = setting((), "Per thruster: true where ventilation is never flagged; empty excludes none")

    @model_validator(mode="after")
    def _hysteresis(self) -> Self:
        if 0.0 < self.off <= self.on:
            raise ValueError(f"on must be below off, found {self.on} and {self.off}")
        return self

    @classmethod
    def for_vessel(cls, vessel: Vessel) -> Self:
        """Return the defaults with the vessel's own thresholds, so that parameters show the numbers in force."""
        gains = vessel.drivers.ventilation
        if gains is None:
            return cls()
        n = len(vessel.thrusters)
        return cls(on=gains.on, off=gains.off, speed_min=_each(gains.speed_min, n), excluded=(False,) * n)

    def resolved(self, vessel: Propulsion) -> tuple[float, float, tuple[float, ...], tuple[bool, ...]]:
        """Return ``on``, ``off``, ``speed_min`` and ``excluded`` with the numbers of ``vessel`` filled in.

        Raises
        ------
        InputError
            If ``speed_min`` or ``excluded`` has not one element a thruster, ``on`` is not below ``off``, or the vessel
            has no section ``drivers.ventilation``.
        """
        gains, n = vessel.drivers.ventilation, len(vessel.thrusters)
        if gains is None:
            raise InputError(f"drivers.ventilation: expected this section in vessel '{vessel.name}', found none")
        on, off = self.on or gains.on, self.off or gains.off
        if on >= off:
            raise InputError(f"ventilation.on: expected a number below ventilation.off = {off}, found {on}")
        speed_min, excluded = self.speed_min or _each(gains.speed_min, n), self.excluded or (False,) * n
        for name, found in (("speed_min", len(speed_min)), ("excluded", len(excluded))):
            if found != n:
                raise InputError(f"ventilation.{name}: expected {n} elements, one a thruster, found {found}")
        return on, off, speed_min, excluded


class AntiSpinSettings(Settings):
    """Low-level anti-spin, [Ruth] 3.4.3. Off by default: shaft-speed control, the thesis' own, does not race."""

    enabled: bool = setting(
        False, "Reduce thrust while a propeller ventilates and keep every shaft below its speed limit"
    )
    thrust_floor: float = setting(
        0.2, "Least share of the demanded thrust that is left while ventilating", unit="1", ge=0.0, le=1.0
    )
    reduction_rate: float = setting(10.0, "Rate at which the share falls", unit="1/s", ge=0.1, le=1000.0)
    release_rate: float = setting(0.5, "Rate at which the share rises again", unit="1/s", ge=0.001, le=100.0)
    speed_limit: float = setting(
        1.2,
        "Shaft speed that no motor goes beyond, over that of the largest thrust at zero advance speed",
        unit="1",
        ge=1.0,
        le=5.0,
    )

    def check(self, vessel: Vessel) -> None:
        """Raise InputError if ``vessel`` has no torque observer that anti-spin needs."""
        if self.enabled and vessel.drivers.ventilation is None:
            raise InputError(
                f"antispin.enabled: expected false, because vessel '{vessel.name}' has no section drivers.ventilation, "
                "found true"
            )


def _each(values: tuple[float, ...], n: int) -> tuple[float, ...]:
    """Return ``n`` numbers of a vessel file that gives one for all, or one for each."""
    return values * n if len(values) == 1 else values
