"""What a trial does to the thruster: water that flows in, depth of the shaft, and thrust that is asked for."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from marine_model.constants import GRAVITY
from marine_model.guards import FloatArray
from marine_model.schema import FieldError, NonNegative, Positive, Section
from vessel_sim.waves import IrregularSea, Jonswap

Step = Annotated[tuple[NonNegative, float], Field(strict=False)]  # s, N


class RegularWaves(Section):
    """One wave in deep water."""

    spectrum: Literal["regular"]
    amplitude: NonNegative  # m
    period: Positive  # s

    def orbital_velocity(self, depth: float, time: FloatArray) -> FloatArray:
        """Return the velocity of the water along the propeller's axis, m/s, ``depth`` m below the calm surface."""
        omega = 2.0 * math.pi / self.period
        speed = self.amplitude * omega * math.exp(-(omega**2) / GRAVITY * depth)
        return np.asarray(speed * np.cos(omega * time))


class JonswapWaves(Section):
    """A long-crested sea along the propeller's axis."""

    spectrum: Literal["jonswap"]
    significant_height: Positive  # m
    peak_period: Positive  # s
    peakedness: Annotated[float, Field(ge=1.0)]
    seed: int = Field(default=0, ge=0)

    def orbital_velocity(self, depth: float, time: FloatArray) -> FloatArray:
        """Return the velocity of the water along the propeller's axis, m/s, ``depth`` m below the calm surface."""
        spectrum = Jonswap(self.significant_height, self.peak_period, self.peakedness)
        velocity = IrregularSea(spectrum, 0.0, self.seed).particle_velocity(0.0, 0.0, depth, time)
        return np.ascontiguousarray(velocity[:, 0])


class Inflow(Section):
    """Advance speed: current and orbital velocity of undisturbed waves at the depth of the shaft, [Ruth] 3.7."""

    current: float = 0.0  # m/s, onto the propeller
    waves: Annotated[RegularWaves | JonswapWaves, Field(discriminator="spectrum")] | None = None
    depth: NonNegative | None = None  # m, of the shaft below the calm surface; needed with waves
    positive_only: bool = False  # a negative advance speed counts as 0

    @model_validator(mode="after")
    def _waves_have_a_depth(self) -> Self:
        if self.waves is not None and self.depth is None:
            raise FieldError(("depth",), "expected the depth of the shaft, because there are waves; found none")
        return self

    def advance_speed(self, time: FloatArray) -> FloatArray:
        """Return V_A, m/s, at ``time`` (s), shape (k,)."""
        speed = np.full(time.shape, self.current)
        if self.waves is not None and self.depth is not None:
            speed += self.waves.orbital_velocity(self.depth, time)
        return np.maximum(speed, 0.0) if self.positive_only else speed


class Sine(Section):
    """mean + amplitude sin(2 pi t / period)."""

    mean: float
    amplitude: float = 0.0
    period: Positive | None = None  # s; needed with an amplitude

    @model_validator(mode="after")
    def _swing_has_a_period(self) -> Self:
        if self.amplitude != 0.0 and self.period is None:
            raise FieldError(("period",), "expected a period, because there is an amplitude; found none")
        return self

    def at(self, time: FloatArray) -> FloatArray:
        """Return the values at ``time`` (s)."""
        swing = 0.0 if self.period is None else self.amplitude * np.sin(2.0 * math.pi / self.period * time)
        return np.asarray(self.mean + swing + 0.0 * time)


class ThrustReference(Section):
    """Thrust that is asked for, N: a sine, or steps that hold until the next one."""

    mean: float | None = None
    amplitude: float = 0.0
    period: Positive | None = None  # s
    steps: Annotated[tuple[Step, ...], Field(strict=False, min_length=1)] | None = None

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.mean is None) == (self.steps is None):
            found = "neither" if self.mean is None else "both"
            raise ValueError(f"expected a mean or steps, found {found}")
        if self.steps is None:
            if self.amplitude != 0.0 and self.period is None:
                raise FieldError(("period",), "expected a period, because there is an amplitude; found none")
            return self
        if self.amplitude != 0.0 or self.period is not None:
            raise FieldError(("steps",), "expected none beside amplitude and period")
        times = [time for time, _ in self.steps]
        if times[0] != 0.0 or sorted(set(times)) != times:
            raise FieldError(("steps",), f"expected times that begin at 0 and increase, found {times}")
        return self

    @property
    def extremes(self) -> tuple[float, float]:
        """Least and largest thrust, N."""
        if self.steps is not None:
            values = [value for _, value in self.steps]
            return min(values), max(values)
        mean = self.mean or 0.0
        return mean - abs(self.amplitude), mean + abs(self.amplitude)

    def at(self, time: FloatArray) -> FloatArray:
        """Return T_d, N, at ``time`` (s), shape (k,)."""
        if self.steps is not None:
            starts, values = np.array(self.steps).T
            # A step counts from its own instant on; instants of a run are whole time steps but for rounding.
            return np.asarray(values[np.searchsorted(starts, time + 1e-9, side="right") - 1])
        return Sine(mean=self.mean or 0.0, amplitude=self.amplitude, period=self.period).at(time)
