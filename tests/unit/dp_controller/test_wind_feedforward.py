"""Wind feed-forward: what it asks for, filter, bumpless switches, safe state, refusals."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from dp_controller import Controller, ControllerInputs, ControllerOutput, ControllerSettings
from marine_model.errors import InputError
from marine_model.wind import wind_force
from support.controller_rig import DT, VESSEL, Rig, rig

Array = NDArray[np.float64]
FORCES = VESSEL.wind_forces
assert FORCES is not None
CONSTANTS, TABLE = FORCES.constants(), FORCES.table()
WIND = np.array([-2.5, 1.0])


def force_of(wind: Array) -> Array:
    return np.array(wind_force(CONSTANTS, TABLE, -float(wind[0]), -float(wind[1])))


def windy(mode: str = "setpoint", wind: Array = WIND, **feedforward: Any) -> Rig:
    made = rig(mode=mode, wind_feedforward={"enabled": True} | feedforward)
    made.wind = wind
    return made


def switch(ship: Rig, **feedforward: Any) -> None:
    now = ship.controller.settings.wind_feedforward.model_dump()
    ship.change(wind_feedforward=now | feedforward)


def total(output: ControllerOutput) -> Array:
    parts = (output.proportional, output.integral, output.derivative, output.wind_feedforward, output.joystick)
    return np.sum([*parts, output.transfer], axis=0)


def test_it_asks_for_the_opposite_of_the_wind_from_the_first_sample_on() -> None:
    output = windy().step()
    np.testing.assert_allclose(output.wind_feedforward, -force_of(WIND), rtol=1e-15)
    np.testing.assert_allclose(output.tau_desired, -force_of(WIND), rtol=1e-15)
    assert output.wind_feedforward[0] > 0.0  # head wind: ahead
    assert output.status == "nominal"


def test_gain_scales_it() -> None:
    np.testing.assert_allclose(windy(gain=0.5).step().wind_feedforward, -0.5 * force_of(WIND), rtol=1e-15)


def test_disabled_it_asks_for_nothing_and_looks_at_nothing() -> None:
    ship = windy(enabled=False)
    ship.wind = np.array([math.nan, 0.0])
    output = ship.step()
    assert not output.wind_feedforward.any()
    assert output.status == "nominal"


@given(x=st.floats(-0.5, 0.5), wind=st.tuples(st.floats(-5, 5), st.floats(-5, 5)))
def test_terms_add_up_to_the_demand(x: float, wind: tuple[float, float]) -> None:
    ship = windy(wind=np.array(wind))
    ship.position = np.array([x, -x, 0.1])
    ship.velocity = np.array([0.1 * x, 0.0, x])
    for _ in range(3):
        output = ship.step()
        # Sums of some hundred N.
        np.testing.assert_allclose(total(output), output.tau_desired, atol=1e-12)


def test_filter_is_the_mean_at_first_and_then_first_order() -> None:
    ship = windy(filter_time=2.0)
    winds = [np.array([-2.0 - 0.1 * k, 0.3 * (-1) ** k]) for k in range(60)]
    found, expected = [], np.zeros(3)
    for k, wind in enumerate(winds):
        ship.wind = wind
        found.append(ship.step().wind_feedforward)
        share = max(1.0 / (k + 1), -math.expm1(-DT / 2.0))
        expected = expected + share * (force_of(wind) - expected)
        np.testing.assert_allclose(found[-1], -expected, rtol=1e-12)
    # Mean of the first ten: 1 - exp(-0.1) is just below a tenth.
    np.testing.assert_allclose(found[9], -np.mean([force_of(w) for w in winds[:10]], axis=0), rtol=1e-12)


def test_a_gap_in_the_measurements_counts_in_full() -> None:
    """One sample after 1 s moves the estimate as far as five equal ones in 1 s."""
    one, five = windy(filter_time=2.0, timeout=10.0), windy(filter_time=2.0, timeout=10.0)
    for ship in (one, five):
        ship.run(40)
    gust = np.array([-3.0, 0.5])
    five.wind, one.wind = gust, None
    one.run(4)
    one.wind = gust
    np.testing.assert_allclose(one.step().wind_feedforward, five.run(5).wind_feedforward, rtol=1e-12)


# Switching -----------------------------------------------------------------------------------------------------------


def balanced() -> Rig:
    """A rig whose integral balances something, the wind among it."""
    ship = windy(enabled=False, filter_time=1.0)
    ship.step()  # the set point is where it lies
    ship.position = np.array([-0.02, 0.01, 0.005])
    ship.run(100)
    ship.position = np.zeros(3)
    ship.run(50)
    return ship


def test_switching_on_and_off_moves_no_demand() -> None:
    ship = balanced()
    before = ship.step()
    assert np.abs(before.integral).min() > 0.01
    switch(ship, enabled=True)
    outputs = [ship.step() for _ in range(20)]
    switch(ship, gain=0.6)
    outputs += [ship.step() for _ in range(5)]
    switch(ship, enabled=False)
    outputs += [ship.step() for _ in range(5)]
    for output in outputs:
        # Rounding: nothing else may move it, as the vessel lies still and the wind is steady.
        np.testing.assert_allclose(output.tau_desired, before.tau_desired, atol=1e-12)
    assert not outputs[0].transfer.any()


def test_switched_on_while_the_integral_balances_the_wind_it_acts_once_it_has_a_mean() -> None:
    ship = balanced()
    switch(ship, enabled=True)
    outputs = [ship.step() for _ in range(10)]
    acts = [bool(output.wind_feedforward.any()) for output in outputs]
    # The first measurement at 0.2 s, the filter time of 1 s of measurements at the sixth.
    assert acts == [False] * 5 + [True] * 5
    before, after = outputs[4], outputs[5]
    # The integral gives up what the feed-forward takes over.
    np.testing.assert_allclose(after.integral - before.integral, force_of(WIND), rtol=1e-12)


def test_the_mean_of_gusts_is_handed_over_and_not_the_last_gust() -> None:
    ship = balanced()
    switch(ship, enabled=True)
    winds = [WIND * (1.0 + 0.3 * (-1) ** k) for k in range(6)]
    for wind in winds:
        ship.wind = wind
        output = ship.step()
    mean = np.mean([force_of(wind) for wind in winds], axis=0)
    # The last of the six counts as 1 - exp(-0.2) = 0.18 instead of 1/6. It alone is less than half the mean.
    np.testing.assert_allclose(output.wind_feedforward, -mean, rtol=0.02)
    assert np.abs(force_of(winds[-1]) / mean - 1.0).min() > 0.3


def test_an_axis_taken_over_from_the_joystick_keeps_its_demand() -> None:
    ship = windy(mode="joystick")
    ship.change(joystick_timeout=0.0)
    ship.controller.set_joystick([1.0, -0.5, 0.1])
    manual = ship.run(5)
    assert not manual.wind_feedforward.any()
    ship.change(mode="setpoint")
    automatic = ship.step()
    np.testing.assert_allclose(automatic.tau_desired, manual.tau_desired, atol=1e-12)
    np.testing.assert_allclose(automatic.wind_feedforward, -force_of(WIND), rtol=1e-12)
    np.testing.assert_allclose(automatic.integral, np.add([1.0, -0.5, 0.1], force_of(WIND)), rtol=1e-12)


def test_an_axis_that_was_off_fades_it_in() -> None:
    ship = windy(mode="standby")
    ship.change(transfer_time=2.0)
    off = ship.run(5)
    assert not off.wind_feedforward.any()
    ship.change(mode="setpoint")
    outputs = [ship.step() for _ in range(12)]
    np.testing.assert_allclose(outputs[0].tau_desired, off.tau_desired, atol=1e-12)
    np.testing.assert_allclose(outputs[-1].tau_desired, -force_of(WIND), rtol=1e-12)
    # Ten equal steps in between.
    steps = [later.tau_desired - earlier.tau_desired for earlier, later in pairwise(outputs[:11])]
    np.testing.assert_allclose(steps, np.tile(-force_of(WIND) / 10.0, (10, 1)), atol=1e-12)


def test_manual_axes_get_none_of_it() -> None:
    ship = rig(
        mode="semi_automatic", axis_surge="joystick", axis_sway="off", axis_yaw="automatic",
        wind_feedforward={"enabled": True},
    )  # fmt: skip
    ship.wind = WIND
    np.testing.assert_allclose(ship.step().wind_feedforward, [0.0, 0.0, -force_of(WIND)[2]], rtol=1e-15)


def test_thrusters_that_fall_short_wind_no_integral_up() -> None:
    """Back-calculation sees the whole demand: with nothing achieved, the integral ends at minus the feed-forward."""
    ship = windy()
    ship.change(anti_windup_time=2.0)
    for _ in range(600):
        output = ship.step()
        ship.achieved = np.zeros(3)
    np.testing.assert_allclose(output.integral, -output.wind_feedforward, rtol=1e-6)


# Safe states ---------------------------------------------------------------------------------------------------------


def test_without_a_measurement_the_integral_takes_over_and_the_status_says_so() -> None:
    ship = windy(timeout=1.0)
    before = ship.run(20)
    ship.wind = None
    outputs = [ship.step() for _ in range(8)]
    assert [output.status for output in outputs] == ["nominal"] * 5 + ["wind_stale"] * 3
    for output in outputs:
        np.testing.assert_allclose(output.tau_desired, before.tau_desired, atol=1e-12)
    np.testing.assert_array_equal(outputs[4].wind_feedforward, before.wind_feedforward)
    assert not outputs[5].wind_feedforward.any()
    np.testing.assert_allclose(outputs[5].integral, before.integral + before.wind_feedforward, rtol=1e-12)


def test_when_the_wind_is_back_so_is_the_feedforward_without_a_bump() -> None:
    ship = windy(timeout=1.0, filter_time=1.0)
    ship.run(20)
    ship.wind = None
    lost = ship.run(20)
    ship.wind = WIND
    outputs = [ship.step() for _ in range(10)]
    assert {output.status for output in outputs} == {"nominal"}
    for output in outputs:
        np.testing.assert_allclose(output.tau_desired, lost.tau_desired, atol=1e-12)
    np.testing.assert_allclose(outputs[-1].wind_feedforward, -force_of(WIND), rtol=1e-12)


def test_wind_that_never_comes_is_stale_after_the_timeout() -> None:
    ship = windy(timeout=0.5)
    ship.wind = None
    assert [ship.step().status for _ in range(4)] == ["nominal", "nominal", "wind_stale", "wind_stale"]


def test_with_an_observer_that_is_lost_it_goes_on() -> None:
    ship = windy()
    ship.run(10)
    ship.valid = False
    ship.run(40)
    ship.wind = 1.2 * WIND
    output = ship.run(100)
    assert output.status == "observer_invalid"
    np.testing.assert_allclose(output.wind_feedforward, -force_of(1.2 * WIND), rtol=1e-6)


@pytest.mark.parametrize("wind", [[1.0], [1.0, math.nan], [1.0, 2.0, 3.0], "calm"])
def test_wrong_wind_is_refused_and_changes_nothing(wind: Any) -> None:
    ship = windy()
    ship.run(3)
    time = ship.controller.time
    with pytest.raises(InputError, match="wind"):
        ship.controller.step(ControllerInputs(np.zeros(3), np.zeros(3), None, True, wind), DT)
    assert ship.controller.time == time


def test_a_vessel_without_wind_forces_has_no_feedforward() -> None:
    bare = VESSEL.model_copy(update={"wind_forces": None})
    enabled = ControllerSettings.model_validate({"wind_feedforward": {"enabled": True}})
    message = r"wind_feedforward\.enabled: expected false, because vessel 'cybership3' has no section wind_forces"
    with pytest.raises(InputError, match=message):
        Controller(bare, enabled)
    controller = Controller(bare)
    with pytest.raises(InputError, match=message):
        controller.apply(enabled)
    assert not controller.settings.wind_feedforward.enabled
