"""The demand beside the minimum gain, and minimum gains beside one another."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from dp_tools.attainable import MISSED, Reverse
from dp_tools.plot_specs.base import PlotSpec
from marine_model.schema import Positive


class AttainablePlot(PlotSpec):
    """Scaled demand and command beside the minimum gain; where force was missed is marked."""

    kind: Literal["attainable"]
    window: str = ""  # empty: the whole run
    reverse: Reverse = "as_ahead"
    tolerance: Positive = MISSED  # missed force that is marked, scaled
    # By window another reverse, where thrusters push one way only before they push both ways.
    reverse_in: dict[str, Reverse] = Field(default_factory=dict)

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window, if there is one, and those with a reverse of their own."""
        own = tuple(("reverse_in", name) for name in self.reverse_in)
        return (("window", self.window), *own) if self.window else own


class MinimumGains(PlotSpec):
    """Minimum gain of the commanded directions and of those without singularity avoidance."""

    kind: Literal["minimum_gains"]
    window: str = ""  # empty: the whole run
    limit: Positive | None = None  # sigma_lim
    push: bool = False  # also with rotating thrusters that push one way only

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window, if there is one."""
        return (("window", self.window),) if self.window else ()
