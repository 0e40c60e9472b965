"""What feeds the thrusters: available power and the buses."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from marine_model.schema import Positive, Section
from marine_model.units import Unit


class PowerBus(Section):
    """Thrusters fed from one switchboard, [Ruth] (4.50)."""

    name: str = Field(min_length=1, pattern=r"^[a-z][a-z0-9_]*$")
    thrusters: Annotated[tuple[str, ...], Field(strict=False, min_length=1)]  # by name, in any order
    limit: Annotated[Positive | None, Unit("W")] = None  # P_bus; none when absent


class PowerPlant(Section):
    """Power of all thrusters together, and by bus. A thruster on no bus counts for the total alone."""

    available: Annotated[Positive | None, Unit("W")] = None  # P_AV; no limit when absent
    buses: Annotated[tuple[PowerBus, ...], Field(strict=False)] = ()
