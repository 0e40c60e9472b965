"""Settings of the methods beside the quadratic program."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from marine_model.axes import Axis
from marine_model.schema import Positive
from marine_model.settings import Settings, setting

Weights = Annotated[tuple[Positive, ...], Field(strict=False)]


class PrioritySettings(Settings):
    """What feasible = priority keeps, [Garus-N] (10)."""

    axis: Axis = setting("yaw", "Axis whose demand is kept; one of the vessel's degrees of freedom")
    weights: Weights = setting(
        (),
        "Per degree of freedom: weight of what is left of its demand; that of the kept axis has no say",
        unit="1",
    )


class AzimuthAngleSettings(Settings):
    """Four azimuth propellers that turn together, [Garus-A]."""

    reserved_moment: float = setting(
        0.0, "Yaw moment that is kept free at any thrust angle, (12)-(14)", unit="N m", ge=0.0, le=1e9
    )
    angle_min: float = setting(
        0.0, "Smallest thrust angle; the largest is pi/2 less it, (7)", unit="rad", ge=0.0, le=math.pi / 4.0
    )
    angle_rule: Literal["as_needed", "as_printed"] = setting(
        "as_needed",
        "Of a demand within the asteroid: turn where the present angle cannot give it, or never, as step 2 is printed",
    )


class PortionSettings(Settings):
    """Shares of the marching thrusters, [Kostenko] (6)."""

    surge: float = setting(0.5, "Share of the largest thrust that surge may have", unit="1", ge=0.0, le=1.0)
    yaw: float = setting(0.5, "Share of yaw: 1 less that of surge", unit="1", ge=0.0, le=1.0)
    pitch: float = setting(0.5, "Share of pitch: 1 less that of surge", unit="1", ge=0.0, le=1.0)
    speed_limited: bool = setting(
        False, "Take the largest thrust at the speed that odometry tells, and not that at rest"
    )
