"""Trial files: one thruster in a basin, what happens to it, how it is controlled, and what is measured."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from dp_tools.open_water.case import Case, Name, TrialGains
from dp_tools.open_water.outcome_specs import Figure, Sweep, Table, Window
from dp_tools.open_water.surroundings import Inflow, Sine, ThrustReference
from marine_model.guards import FloatArray
from marine_model.propellers.sections import PropellerData
from marine_model.schema import FieldError, NonNegative, Positive, Section
from marine_model.thruster import PitchDrive, ShaftDrive, ThrustLimits, check_pitch
from marine_model.ventilation.data import VentilationData
from marine_model.yaml_document import FieldPath
from thruster_drivers.controllers import needs_pitch
from thruster_drivers.ventilation import AntiSpinSettings


class Trial(Section):
    """One trial file."""

    name: Name
    title: str = Field(min_length=1)
    description: str
    source: str = ""
    density: Positive  # kg/m^3
    duration: Positive  # s
    time_step: Positive  # s, of plant and controllers
    series_step: Positive  # s, of the series that are written
    seed: int = Field(default=0, ge=0)  # of the sensor
    shaft_speed_noise: NonNegative = 0.0  # Hz, standard deviation of the measured shaft speed
    limits: ThrustLimits
    propeller: PropellerData
    pitch: PitchDrive | None = None
    shaft: ShaftDrive
    gains: TrialGains
    anti_spin: AntiSpinSettings = AntiSpinSettings()
    ventilation: VentilationData | None = None
    inflow: Inflow = Inflow()
    submergence_ratio: Sine | None = None  # h/R; absent: so deep that nothing ventilates
    thrust: ThrustReference | None = None  # needed unless every case holds a shaft speed
    cases: Annotated[tuple[Case, ...], Field(strict=False, min_length=1)]
    windows: dict[Name, Window]
    close_up: Name | None = None  # window that the plots show as well
    table: Table
    figures: Annotated[tuple[Figure, ...], Field(strict=False)] = ()
    sweep: Sweep | None = None

    @model_validator(mode="after")
    def _pitch_fits(self) -> Self:
        if self.pitch is not None:
            check_pitch(self.propeller, self.pitch.min, self.pitch.max)
        return self

    @model_validator(mode="after")
    def _surroundings_fit(self) -> Self:
        if (self.ventilation is None) != (self.submergence_ratio is None):
            missing, there = ("ventilation", "submergence_ratio")
            if self.ventilation is not None:
                missing, there = there, missing
            raise FieldError((missing,), f"expected this section, because there is '{there}'; found none")
        ventilation = self.gains.ventilation
        if ventilation is not None and len(ventilation.speed_min) != 1:
            raise FieldError(
                ("gains", "ventilation", "speed_min"),
                f"expected 1 number, that of the thruster, found {len(ventilation.speed_min)}",
            )
        if "enabled" in self.anti_spin.model_fields_set:
            raise FieldError(("anti_spin", "enabled"), "expected none: every case says whether it has anti-spin")
        if self.thrust is None:
            for i, case in enumerate(self.cases):
                if not case.holds_speed:
                    raise FieldError(
                        ("thrust",), f"expected this section, because cases.{i} '{case.name}' follows it; found none"
                    )
        return self

    @model_validator(mode="after")
    def _cases_fit(self) -> Self:
        known = self.propeller.build().pitch_range
        names = [case.name for case in self.cases]
        for i, case in enumerate(self.cases):
            at = ("cases", i)
            if case.name in names[:i]:
                raise FieldError((*at, "name"), f"every name must be unique, found '{case.name}' twice")
            if needs_pitch(case.controller) and self.pitch is None:
                raise FieldError(
                    (*at, "controller"), f"'{case.controller}' works through the pitch; expected a section 'pitch'"
                )
            if case.pitch_ratio is not None and case.pitch_ratio != self.propeller.pitch_ratio:
                low, high = known or (self.propeller.pitch_ratio,) * 2
                if not low <= case.pitch_ratio <= high:
                    raise FieldError(
                        (*at, "pitch_ratio"),
                        f"expected a number from {low:g} to {high:g}, those of the propeller's data, "
                        f"found {case.pitch_ratio:g}",
                    )
            if case.anti_spin and self.gains.ventilation is None:
                raise FieldError(
                    (*at, "anti_spin"), "expected a section 'gains.ventilation', which detects; found none"
                )
            if case.anti_spin and needs_pitch(case.controller):
                raise FieldError((*at, "anti_spin"), f"expected a fixed pitch, found '{case.controller}'")
        return self

    @model_validator(mode="after")
    def _windows_lie_within_the_run(self) -> Self:
        for name, (start, end) in self.windows.items():
            if not start < end <= self.duration:
                raise FieldError(
                    ("windows", name), f"expected 0 <= start < end <= {self.duration:g}, found {[start, end]}"
                )
        for field, window in self._window_uses():
            if window not in self.windows:
                known = ", ".join(self.windows) or "none"
                raise FieldError(field, f"expected a name out of windows ({known}), found '{window}'")
        return self

    def _window_uses(self) -> Iterator[tuple[FieldPath, str]]:
        yield ("table", "window"), self.table.window
        if self.close_up is not None:
            yield ("close_up",), self.close_up
        for i, figure in enumerate(self.figures):
            yield ("figures", i, "window"), figure.window

    @model_validator(mode="after")
    def _figures_are_of_cases(self) -> Self:
        cases, figures = [case.name for case in self.cases], [figure.name for figure in self.figures]
        for i, figure in enumerate(self.figures):
            if figure.name in figures[:i]:
                raise FieldError(("figures", i, "name"), f"every name must be unique, found '{figure.name}' twice")
            for field in ("case", "over"):
                chosen = getattr(figure, field)
                if chosen is not None and chosen not in cases:
                    raise FieldError(
                        ("figures", i, field), f"expected one of the cases {', '.join(cases)}, found '{chosen}'"
                    )
        return self

    @model_validator(mode="after")
    def _thrust_lies_within_limits(self) -> Self:
        asked: list[tuple[FieldPath, ThrustReference]] = []
        if self.thrust is not None:
            asked.append((("thrust",), self.thrust))
        if self.sweep is not None:
            asked += [(("sweep", "variants", i, "thrust"), v.thrust) for i, v in enumerate(self.sweep.variants)]
        for field, thrust in asked:
            least, most = thrust.extremes
            if least < self.limits.min or most > self.limits.max:
                raise FieldError(
                    field,
                    f"expected thrust within limits, {self.limits.min:g} to {self.limits.max:g} N, "
                    f"found {least:g} to {most:g} N",
                )
        return self

    @model_validator(mode="after")
    def _sweep_is_possible(self) -> Self:
        if self.sweep is None:
            return self
        n, thesis, (start, end) = len(self.cases), self.sweep.thesis, self.sweep.window
        if not start < end:
            raise FieldError(("sweep", "window"), f"expected 0 <= start < end, found {[start, end]}")
        if thesis is not None and len(thesis) != n:
            raise FieldError(("sweep", "thesis"), f"expected {n} numbers, one a case, found {len(thesis)}")
        return self

    @model_validator(mode="after")
    def _whole_steps(self) -> Self:
        for field, whole in (("duration", self.duration), ("series_step", self.series_step)):
            steps = whole / self.time_step
            if round(steps) < 1 or abs(steps - round(steps)) > 1e-6:  # decimals such as 0.6 / 0.2 are not exact
                raise FieldError(
                    (field,), f"expected a whole multiple of time_step, {self.time_step:g} s, found {whole:g}"
                )
        return self

    @property
    def instants(self) -> FloatArray:
        """0, time_step, ... duration, s."""
        return np.arange(round(self.duration / self.time_step) + 1, dtype=np.float64) * self.time_step

    def variant(self, thrust: ThrustReference, duration: float) -> Self:
        """Return the trial with another thrust and duration."""
        return self.model_copy(update={"thrust": thrust, "duration": duration})
