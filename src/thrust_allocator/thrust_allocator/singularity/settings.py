"""What an operator chooses about singularity."""

from __future__ import annotations

from typing import Literal

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.gains import SingularityGains
from marine_model.settings import Settings, setting

# Azimuth thrusters whose angles are searched over, at most.
MOST_TURNING = 4


class SingularitySettings(Settings):
    """Settings of monitor and avoidance. Where one is None, ``allocator.singularity`` of the vessel file holds."""

    method: Literal["none", "three_step", "required_gain", "crossing"] = setting(
        "none", "How rotating thrusters are kept from configurations of small gain"
    )
    gain_limit: float | None = setting(
        None, "Least minimum gain, sigma_lim; unset: the vessel's", unit="1", ge=0.0, le=10.0
    )
    dwell_time: float | None = setting(
        None, "How long the gain must have been sufficient before three_step turns, t_lim; unset: the vessel's",
        unit="s", ge=0.0, le=600.0,
    )  # fmt: skip
    lock_ratio: float = setting(
        0.3, "Cost of the third step above the first's from which three_step may be locked", unit="decades",
        ge=0.01, le=10.0,
    )  # fmt: skip
    switch_ratio: float = setting(
        0.04, "How much better a configuration elsewhere must be for required_gain and crossing to go there",
        unit="decades", ge=0.001, le=10.0,
    )  # fmt: skip
    lock_time: float | None = setting(
        None, "How long costs are compared before three_step counts as locked; unset: the vessel's",
        unit="s", ge=0.1, le=3600.0,
    )  # fmt: skip
    release: bool = setting(True, "Whether a locked three_step turns to the best configuration of sufficient gain")
    demand_margin: float = setting(
        0.05, "Scaled force that must be left along the weakest direction for a crossing to begin at once",
        unit="1", ge=0.0, le=10.0,
    )  # fmt: skip
    patience: float = setting(
        1.0, "A crossing begins when waiting has cost this many times what crossing costs", unit="1", ge=0.0, le=1e6
    )
    shortfall_price: float = setting(
        5.0, "Seconds of turning that are worth one second less of insufficient gain", unit="1", ge=0.0, le=1e6
    )
    reduced_share: float = setting(
        0.8,
        "Where the thrusters left cannot reach gain_limit: share of the best gain they can reach",
        unit="1",
        ge=0.0,
        le=1.0,
    )
    monitor: Literal["none", "global", "local", "horizon", "all"] = setting(
        "global", "Which minimum gains are computed and published"
    )
    horizon: float = setting(1.0, "Time in which azimuths may turn for the horizon gain", unit="s", ge=0.0, le=600.0)
    required_change: float = setting(
        0.1,
        "Share of its limits by which a thrust must be able to change, for the local gain",
        unit="1",
        ge=0.0,
        le=1.0,
    )


def limits_of(settings: SingularitySettings, vessel: Vessel) -> SingularityGains:
    """Return the numbers that belong to a vessel, with those of ``settings`` in their place.

    Raises
    ------
    InputError
        If neither has a number that the method needs, or the method searches over the angles of too many thrusters.
    """
    turning = sum(vessel.can_rotate)
    if settings.method in ("required_gain", "crossing") and turning > MOST_TURNING:
        raise InputError(
            f"singularity.method: expected three_step with more than {MOST_TURNING} azimuth thrusters, "
            f"found {settings.method} with {turning}"
        )
    gains = vessel.allocator.singularity
    found = {}
    for name in SingularityGains.model_fields:
        value = getattr(settings, name)
        if value is None:
            if gains is None:
                raise InputError(
                    f"singularity.{name}: expected a number here or allocator.singularity in the vessel "
                    "file, found none"
                )
            value = getattr(gains, name)
        if name != "dwell_time" and not value > 0.0:
            raise InputError(f"singularity.{name}: expected a number above 0, found {value}")
        found[name] = value
    return SingularityGains(**found)
