"""All kinds of pictures that a scenario can ask for."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from dp_tools.plot_specs.gain import AttainablePlot, MinimumGains
from dp_tools.plot_specs.overlay import Overlay

AnyPlot = Annotated[AttainablePlot | MinimumGains | Overlay, Field(discriminator="kind")]
