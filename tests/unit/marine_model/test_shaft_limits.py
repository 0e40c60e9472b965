"""Limits of the shaft that contradict the thrust, and gains by thruster, are refused with their field."""

from __future__ import annotations

import re
from typing import Any

import pytest
from pydantic import ValidationError

from marine_model import Vessel, load_vessel
from support.thruster_rig import controllable_pitch_vessel


def with_shaft(thruster: int, **limits: float) -> Vessel:
    content: dict[str, Any] = load_vessel("cybership3").model_dump()
    content["thrusters"][thruster]["shaft"] |= limits
    return Vessel.model_validate(content)


# azimuth_bow at 8.7 N: n = sqrt(8.7 / (0.52 1000 0.06^4)) = 35.93 Hz, Q = 0.0362 / 0.52 0.06 8.7 = 0.036339 N m,
# P = 2 pi n Q = 8.204 W.
@pytest.mark.parametrize(
    ("field", "enough", "too_little", "message"),
    [
        ("torque_max", 0.03634, 0.03633, "expected at least 0.0363 N m, the torque at the largest thrust of 8.7 N"),
        ("power_max", 8.205, 8.20, "expected at least 8.2 W, the power at the largest thrust of 8.7 N"),
        ("speed_max", 35.94, 35.92, "expected at least 35.9 Hz, the shaft speed at the largest thrust of 8.7 N"),
    ],
)
def test_a_limit_below_what_the_largest_thrust_needs(
    field: str, enough: float, too_little: float, message: str
) -> None:
    assert getattr(with_shaft(1, **{field: enough}).thrusters[1].shaft, field) == enough
    with pytest.raises(ValidationError, match=re.escape(message)) as caught:
        with_shaft(1, **{field: too_little})
    assert f"found {too_little:g}" in str(caught.value)


def test_friction_counts() -> None:
    with pytest.raises(ValidationError, match=r"expected at least 0.0474 N m, the torque .* found 0.0465"):
        # 0.036339 + 0.01 + 3e-5 * 35.93
        with_shaft(1, torque_max=0.0465, friction_static=0.01, friction_viscous=3e-5)


@pytest.mark.parametrize("field", ["power_max", "speed_max"])
@pytest.mark.parametrize("value", [0.0, -1.0])
def test_limits_are_above_zero(field: str, value: float) -> None:
    with pytest.raises(ValidationError, match="greater than 0"):
        with_shaft(1, **{field: value})


def test_the_best_pitch_counts_where_it_is_controllable() -> None:
    """At P/D 0.8 8.7 N need 43.5 Hz, at 1.4 less."""
    vessel = controllable_pitch_vessel()
    model = vessel.propeller_models[1]
    K_T = [float(model.coefficients(0.0, pitch)[0]) for pitch in (0.8, 1.4)]
    needed = [(8.7 / (k * 1000.0 * 0.06**4)) ** 0.5 for k in K_T]
    assert needed[0] == pytest.approx(43.5, abs=0.05)
    content = vessel.model_dump()
    content["thrusters"][1]["shaft"]["speed_max"] = 1.001 * needed[1]
    assert Vessel.model_validate(content).thrusters[1].shaft.speed_max == 1.001 * needed[1]
    content["thrusters"][1]["shaft"]["speed_max"] = 0.999 * needed[1]
    with pytest.raises(ValidationError, match="the shaft speed at the largest thrust"):
        Vessel.model_validate(content)


def test_gains_are_one_number_or_one_a_thruster() -> None:
    one = controllable_pitch_vessel(drivers={"combined": {"time": 0.5}})
    assert one.drivers.combined.time == (0.5,)
    each = controllable_pitch_vessel(drivers={"pitch": {"shaft_speed": [40.0, 30.0, 20.0, 21.0]}})
    assert each.drivers.pitch.shaft_speed == (40.0, 30.0, 20.0, 21.0)
    with pytest.raises(ValidationError, match="expected one number, or 4, one a thruster, found 3"):
        controllable_pitch_vessel(drivers={"torque_shaft_speed": {"gain": [1.0, 1.0, 1.0]}})
    for bad in (0.0, [1.0, -1.0, 1.0, 1.0], [], True, "1.0"):
        with pytest.raises(ValidationError, match=r"combined\.time"):
            controllable_pitch_vessel(drivers={"combined": {"time": bad}})
