"""One way to control the thruster of a trial."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from marine_model.gains import (
    CombinedGains,
    PowerGains,
    ShaftSpeedGains,
    TorqueShaftSpeedGains,
    VentilationGains,
)
from marine_model.schema import FieldError, Positive, Section
from thruster_drivers.controllers import ControllerName, needs_pitch

Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]


class TrialGains(Section):
    """What the controllers of the trial need, in the sections of a vessel file's ``drivers``."""

    shaft_speed: ShaftSpeedGains
    power: PowerGains = PowerGains()
    combined: CombinedGains = CombinedGains()
    torque_shaft_speed: TorqueShaftSpeedGains = TorqueShaftSpeedGains()
    ventilation: VentilationGains | None = None  # needed for anti-spin


class CaseGains(Section):
    """Gains of one case; what is absent is the trial's."""

    shaft_speed: ShaftSpeedGains | None = None
    power: PowerGains | None = None
    combined: CombinedGains | None = None
    torque_shaft_speed: TorqueShaftSpeedGains | None = None


class Case(Section):
    """One way to control the thruster."""

    name: Name
    title: str = Field(min_length=1)
    controller: ControllerName
    pitch_ratio: Positive | None = None  # a fixed pitch; without it the propeller's own, or a controllable one
    shaft_speed: Positive | None = None  # Hz, that pitch or shaft-speed control holds whatever thrust is asked for
    gains: CaseGains = CaseGains()
    anti_spin: bool = False

    @model_validator(mode="after")
    def _fits_its_controller(self) -> Self:
        if self.pitch_ratio is not None and needs_pitch(self.controller):
            raise FieldError(
                ("pitch_ratio",), f"expected none, because '{self.controller}' works through the pitch, found one"
            )
        if self.shaft_speed is not None and self.controller not in ("pitch", "shaft_speed"):
            raise FieldError(
                ("shaft_speed",), f"expected none with '{self.controller}', which holds no shaft speed, found one"
            )
        return self

    @property
    def holds_speed(self) -> bool:
        """Whether it holds one shaft speed instead of following a thrust."""
        return self.controller == "shaft_speed" and self.shaft_speed is not None
