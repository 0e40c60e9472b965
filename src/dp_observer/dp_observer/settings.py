"""What an operator may change while the observer runs."""

from __future__ import annotations

from marine_model.settings import Settings, setting


class ObserverSettings(Settings):
    """Limits on measurements. The observer's gains belong to the vessel and are in its file.

    The position limit counts in hull lengths, so that one default serves a model and the ship it is a model of.
    """

    dead_reckoning_limit: float = setting(
        5.0,
        "Time without a usable position fix after which the estimate is called invalid.",
        unit="s",
        ge=0.0,
        le=3600.0,
    )
    innovation_limit: float = setting(
        0.25,
        "Horizontal distance between fix and prediction beyond which the fix is refused.",
        unit="hull lengths",
        ge=0.001,
        le=1000.0,
    )
    heading_innovation_limit: float = setting(
        0.35,
        "Angle between measured and predicted heading beyond which the fix is refused; pi for never.",
        unit="rad",
        ge=0.001,
        le=3.141592653589793,
    )
    reacceptance_count: int = setting(
        5,
        "Refused fixes in a row that agree with one another after which the position is set to them.",
        ge=1,
        le=1000,
    )
    frozen_count: int = setting(
        10,
        "Fixes in a row equal to the last bit after which the position reference is said to stand still; 0 for never. "
        "Not for a vessel whose references have no noise.",
        ge=0,
        le=100_000,
    )
