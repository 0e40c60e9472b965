"""The demand beside the minimum gain, and minimum gains beside one another."""

from __future__ import annotations

from typing import Annotated, Literal

from dp_tools.attainable import MISSED, Reverse
from dp_tools.plot_specs.base import PartPlot
from marine_model.schema import Positive
from marine_model.units import Unit


class AttainablePlot(PartPlot):
    """Scaled demand and command beside the minimum gain; where force was missed is marked."""

    kind: Literal["attainable"]
    reverse: Reverse = "as_ahead"
    tolerance: Annotated[Positive, Unit("1")] = MISSED  # missed force that is marked, scaled


class MinimumGains(PartPlot):
    """Minimum gain of the commanded directions and of those without singularity avoidance."""

    kind: Literal["minimum_gains"]
    limit: Annotated[Positive | None, Unit("1")] = None  # sigma_lim
    push: bool = False  # also with rotating thrusters that push one way only
