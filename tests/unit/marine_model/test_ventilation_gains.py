"""Section drivers.ventilation of a vessel file."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from marine_model import load_vessel
from marine_model.gains import VentilationGains
from marine_model.vessel import Vessel

GOOD: dict[str, Any] = {
    "on": 0.5,
    "off": 0.8,
    "speed_min": (50.0, 50.0, 5.0, 5.0),
    "torque_rate_limit": 0.5,
    "deceleration_limit": 10.0,
    "relax_rate": 0.0625,
    "false_alarm_interval": 3.6e6,
}


def test_cybership3_has_the_printed_numbers() -> None:
    """[Ruth] (B.41)-(B.44)."""
    gains = load_vessel("cybership3").drivers.ventilation
    assert gains is not None
    assert (gains.on, gains.off, gains.deceleration_limit) == (0.5, 0.8, 10.0)
    # (B.41) for the tank tests, without current; for a moderate sea, see the test of the detection campaign.
    assert gains.speed_min[:2] == (50.0, 50.0)
    trimmed = load_vessel("cybership3_trimmed").drivers.ventilation
    assert trimmed == gains.model_copy(update={"speed_min": (50.0, 50.0, 5.0, 5.0)})


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("on", 0.8, "on must be below off, found 0.8 and 0.8"),
        ("on", 0.0, "greater than 0"),
        ("off", 1.0, "less than 1"),
        ("speed_min", (5.0, -1.0), "greater than 0"),
        ("torque_rate_limit", 0.0, "greater than 0"),
        ("deceleration_limit", -10.0, "greater than 0"),
        ("relax_rate", 0.0, "greater than 0"),
        ("false_alarm_interval", 60.0, "greater than or equal to 3600"),
    ],
)
def test_what_is_refused(field: str, value: object, message: str) -> None:
    assert VentilationGains.model_validate(GOOD).on == 0.5
    with pytest.raises(ValidationError, match=message):
        VentilationGains.model_validate(GOOD | {field: value})


def test_one_least_speed_or_one_a_thruster() -> None:
    tree = load_vessel("cybership3").model_dump()
    tree["drivers"]["ventilation"]["speed_min"] = (5.0, 6.0)
    with pytest.raises(ValueError, match=r"expected one number, or 4, one a thruster, found 2"):
        Vessel.model_validate(tree)


def test_the_section_may_be_left_out() -> None:
    tree = load_vessel("cybership3").model_dump()
    del tree["drivers"]["ventilation"]
    assert Vessel.model_validate(tree).drivers.ventilation is None
