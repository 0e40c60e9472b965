"""The demand beside the minimum gain, and minimum gains beside one another."""

from __future__ import annotations

from typing import Annotated, Literal

from dp_tools.attainable import MISSED, Reverse
from dp_tools.plot_specs.base import PlotSpec
from marine_model.schema import Positive
from marine_model.units import Unit


class AttainablePlot(PlotSpec):
    """Scaled demand and command beside the minimum gain; where force was missed is marked."""

    kind: Literal["attainable"]
    window: str = ""  # empty: the whole run
    reverse: Reverse = "as_ahead"
    tolerance: Annotated[Positive, Unit("1")] = MISSED  # missed force that is marked, scaled

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window, if there is one."""
        return (("window", self.window),) if self.window else ()


class MinimumGains(PlotSpec):
    """Minimum gain of the commanded directions and of those without singularity avoidance."""

    kind: Literal["minimum_gains"]
    window: str = ""  # empty: the whole run
    limit: Annotated[Positive | None, Unit("1")] = None  # sigma_lim
    push: bool = False  # also with rotating thrusters that push one way only

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window, if there is one."""
        return (("window", self.window),) if self.window else ()
