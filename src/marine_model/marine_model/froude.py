"""Froude's law: the same vessel, or the same trial with it, at another length.

With lambda the ratio of lengths, and gravity and the density of water kept, lengths go with lambda, times with
lambda^(1/2), masses with lambda^3; so forces with lambda^3, moments with lambda^4, power with lambda^(7/2), [Ruth] 2.1.
Every number goes by its unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import BaseModel

from marine_model.errors import InputError
from marine_model.guards import positive_number
from marine_model.schema import Section
from marine_model.units import dimension, unit_of
from marine_model.vessel import Vessel

S = TypeVar("S", bound=Section)

# Significant digits of a scaled number. What is left out is far below what the time step loses in whole nanoseconds,
# and 8.7 N times 30^3 comes out as 234900 N.
_DIGITS = 12


@dataclass(frozen=True)
class FroudeLaw:
    """What numbers are multiplied by.

    Parameters
    ----------
    length
        lambda, new length over old.
    clock
        Factor of times over lambda^(1/2): near 1, where the time steps of both scales are whole nanoseconds.
    """

    length: float
    clock: float = 1.0

    @property
    def time(self) -> float:
        """Factor of times."""
        return self.factor("s")

    def factor(self, unit: str) -> float:
        """Return the factor of a number with one unit. Raises InputError if the unit is not known."""
        d = dimension(unit)
        return float(self.length ** (3.0 * d.mass + d.length + 0.5 * d.time) * self.clock**d.time)

    def value(self, value: Any, unit: str) -> Any:
        """Return a number, vector or matrix with the units of a text, see ``marine_model.units``.

        What is no number stays as it is, and so does every number whose unit has no dimension.

        Raises
        ------
        InputError
            If a unit is not known, or there are not as many as elements.
        """
        if isinstance(value, list | tuple):
            parts = unit.split(";") if ";" in unit else unit.split(",")
            if len(parts) not in (1, len(value)):
                raise InputError(f"unit: expected one for all or {len(value)}, found '{unit}'")
            units = parts * len(value) if len(parts) == 1 else parts
            return type(value)([self.value(v, u) for v, u in zip(value, units, strict=True)])
        if isinstance(value, bool) or not isinstance(value, int | float):
            return value
        factor = self.factor(unit)
        if factor == 1.0:
            return value
        return float(f"{value * factor:.{_DIGITS}g}")

    def section(self, section: S, **changes: Any) -> S:
        """Return a section with every number in it, at any depth, scaled by its unit; ``changes`` are taken as is.

        Raises
        ------
        InputError
            If a number has no unit; the message names it.
        pydantic.ValidationError
            If the section refuses what comes out.
        """
        values = {}
        for name, field in type(section).model_fields.items():
            old = getattr(section, name)
            new = self._within(old, unit_of(field), f"{type(section).__name__}.{name}")
            # A default that scales is written out.
            if name in section.model_fields_set or new != old:
                values[name] = new
        return type(section).model_validate(values | changes)

    def _within(self, value: Any, unit: str | None, name: str) -> Any:
        if unit == "":
            return value
        if isinstance(value, Section):
            return self.section(value)
        if isinstance(value, Mapping):
            return {key: self._within(item, unit, f"{name}.{key}") for key, item in value.items()}
        if isinstance(value, tuple) and any(isinstance(item, BaseModel) for item in value):
            return tuple(self._within(item, unit, name) for item in value)
        if unit is not None:
            return self.value(value, unit)
        if _has_numbers(value):
            raise InputError(f"{name}: expected a unit in its type, found none")
        return value


def _has_numbers(value: Any) -> bool:
    if isinstance(value, tuple):
        return any(_has_numbers(item) for item in value)
    return isinstance(value, float)


def scaled(vessel: Vessel, length_ratio: float, name: str = "", description: str = "") -> Vessel:
    """Return a geometrically similar vessel with similar thrusters, gains and sensors.

    The density of water stays. The time step is rounded to whole nanoseconds, as stamps are, and the sample time has as
    many of them as before: against all other times they are off by up to 0.5 ns a step.

    Parameters
    ----------
    vessel
        The vessel; not changed.
    length_ratio
        lambda, new length over old, above 0.
    name, description
        Of the new vessel; those of ``vessel`` with the ratio behind if empty.

    Raises
    ------
    InputError
        If the ratio is not above 0, a number of the vessel has no unit, or it is submerged: far below the surface there
        are no waves that Froude's law is about, and the resistance goes by Reynolds'.
    """
    vessel.on_surface()
    ratio = positive_number("length_ratio", length_ratio)
    law = FroudeLaw(ratio)
    steps = round(vessel.measurement.sample_time / vessel.simulation.time_step)
    nanoseconds = round(vessel.simulation.time_step * law.time * 1e9)
    if nanoseconds < 1:
        raise InputError(f"length_ratio: expected a time step of 1 ns or more, found {length_ratio}")
    return law.section(
        vessel,
        name=name or f"{vessel.name}_{ratio:g}".replace(".", "_"),
        description=description or f"{vessel.description}, scaled by {ratio:g}",
        scale=float(f"{vessel.scale / ratio:.{_DIGITS}g}"),
        measurement=law.section(vessel.measurement, sample_time=round(steps * nanoseconds * 1e-9, 9)),
        simulation=law.section(vessel.simulation, time_step=round(nanoseconds * 1e-9, 9)),
    )
