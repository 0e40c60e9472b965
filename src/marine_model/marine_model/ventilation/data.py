"""Section `ventilation` of a vessel file: [Ruth] Table 2.5 and the constants of 2.3.2-2.3.3."""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import model_validator

from marine_model.guards import FloatArray
from marine_model.schema import FieldError, Fraction, NonNegative, Positive, Section
from marine_model.units import Unit
from marine_model.ventilation import table

# Numbers of a file are decimal fractions; a sum such as 0.87 + 0.13 may be off by a rounding or two.
_ROUNDING = 1e-12

Plain = Annotated[float, Unit("1")]

_HIGH, _LOW = table.HIGH_LOSS_FACTOR, table.LOW_LOSS_FACTOR


class Line(NamedTuple):
    """The modified Froude number F_nh2 at one loss factor, as a function of x = h/R: slope x + offset."""

    slope: float
    offset: float

    def __call__(self, x: float) -> float:
        """Return F_nh2 at ``x``."""
        return self.slope * x + self.offset


class VentilationData(Section):
    """Static map and dynamics of ventilation. Names are those of Table 2.5.

    Either band ("plus" for deep, "minus" for shallow propellers) has two lines over x = h/R: the F_nh2 at which
    beta_Tw is 0.8, and that at which it is 0.2. A section is accepted if they make a map that is finite, continuous
    over x > -1, falling with F_nh2 and within [0, 1]:

    - the plus band is open (0.2 line above 0.8 line) at x = -1 and does not narrow with depth, and a deeper
      propeller stands more: neither its line of ``beta_tw_max`` nor that of ``beta_tw_min`` falls with x;
    - the minus band is open at x = -1. It may close further down, as that of Table 2.5 does at x = 1.81, but only
      where the plus band has no loss at the F_nh2 at which it closes, so that dropping it changes nothing;
    - a propeller at rest loses nothing: at F_nh2 = 0 one of the bands is at ``beta_tw_max``, whatever x;
    - torque loss factors lie in [0, 1] and do not fall when the thrust loss factor rises.
    """

    a_08_plus: Plain
    b_08_plus: Plain
    a_08_minus: Plain
    b_08_minus: Plain
    a_02_plus: Plain
    b_02_plus: Plain
    a_02_minus: Plain
    b_02_minus: Plain
    beta_tw_max: Fraction
    beta_tw_min: Fraction
    a_q: Annotated[NonNegative, Unit("1")]
    b_q: Plain
    thrust_rise_rate: Annotated[Positive, Unit("1/s")]  # largest rate of rise of beta_Tw, (2.52)
    torque_rise_rate: Annotated[Positive, Unit("1/s")]  # of beta_Qw, (2.53)
    time_shift: Annotated[NonNegative, Unit("s")]  # by which the losses lead their quasi-static values

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        low, high = self.beta_tw_min, self.beta_tw_max
        if low >= high:
            raise FieldError(("beta_tw_min",), f"expected less than beta_tw_max, found {low} and {high}")
        least, largest = self.a_q * low + self.b_q, self.a_q * high + self.b_q
        if least < -_ROUNDING or largest > 1.0 + _ROUNDING:
            raise FieldError(
                ("b_q",),
                "expected a_q beta_Tw + b_q in [0, 1] between beta_tw_min and beta_tw_max, "
                f"found {least:g} to {largest:g}",
            )
        self._check_plus_band()
        self._check_minus_band()
        self._check_rest()
        return self

    def _check_plus_band(self) -> None:
        width = self._width("plus")
        if width(-1.0) <= 0.0:
            raise FieldError(
                ("b_02_plus",),
                f"expected the 0.2 line above the 0.8 line of the plus band at h/R = -1, found {width(-1.0):g} between",
            )
        if width.slope < 0.0:
            raise FieldError(
                ("a_02_plus",), f"expected at least a_08_plus, found {self.a_02_plus} and {self.a_08_plus}"
            )
        for name in ("beta_tw_max", "beta_tw_min"):
            slope = self.line("plus", getattr(self, name)).slope
            if slope < 0.0:
                raise FieldError(
                    ("a_08_plus",),
                    f"expected the line of {name} in the plus band not to fall with h/R, found {slope:g}",
                )

    def _check_minus_band(self) -> None:
        width = self._width("minus")
        if width(-1.0) <= 0.0:
            raise FieldError(
                ("b_02_minus",),
                "expected the 0.2 line above the 0.8 line of the minus band at h/R = -1, "
                f"found {width(-1.0):g} between",
            )
        x = self.minus_end
        if math.isfinite(x):
            step, free = self.line("minus", _HIGH)(x), self.line("plus", self.beta_tw_max)(x)
            if free < step:
                raise FieldError(
                    ("a_02_minus",),
                    f"the lines of the minus band meet at h/R = {x:g}, F_nh2 = {step:g}; expected no loss in the plus "
                    f"band there, found that its loss begins at {free:g}",
                )

    def _check_rest(self) -> None:
        plus, minus = self.line("plus", self.beta_tw_max), self.line("minus", self.beta_tw_max)
        if plus(-1.0) >= 0.0:
            return
        # Over [-1, x] the plus band has losses at rest; a line that is positive at both ends is so between.
        x = -plus.offset / plus.slope if plus.slope > 0.0 else math.inf
        if x > self.minus_end or minus(-1.0) < 0.0 or (math.isfinite(x) and minus(x) < 0.0) or not math.isfinite(x):
            raise FieldError(
                ("b_08_minus",), f"a propeller at rest would ventilate: expected no loss at F_nh2 = 0 up to h/R = {x:g}"
            )

    def _width(self, band: Literal["plus", "minus"]) -> Line:
        """Distance from the 0.8 to the 0.2 line."""
        a, b = self.line(band, _LOW), self.line(band, _HIGH)
        return Line(a.slope - b.slope, a.offset - b.offset)

    def line(self, band: Literal["plus", "minus"], beta: float) -> Line:
        """Return where beta_Tw of a band, before its limits, is ``beta``: linear between its 0.8 and 0.2 lines."""
        if band == "plus":
            high, low = (self.a_08_plus, self.b_08_plus), (self.a_02_plus, self.b_02_plus)
        else:
            high, low = (self.a_08_minus, self.b_08_minus), (self.a_02_minus, self.b_02_minus)
        share = (_HIGH - beta) / (_HIGH - _LOW)
        return Line(high[0] + share * (low[0] - high[0]), high[1] + share * (low[1] - high[1]))

    @property
    def minus_end(self) -> float:
        """h/R at which the lines of the minus band meet and the band ends; infinite if they do not."""
        width = self._width("minus")
        return -width.offset / width.slope if width.slope < 0.0 else math.inf

    def row(self) -> FloatArray:
        """Return the parameters packed for compiled functions, shape (``table.WIDTH``,), read-only and finite."""
        row = np.empty(table.WIDTH)
        for column, name in enumerate(table.NAMES):
            row[column] = getattr(self, name)
        row.setflags(write=False)
        return row
