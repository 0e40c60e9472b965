"""Lost observer, silent joystick, missing path, late estimates, bad inputs: named states, nothing lost."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from dp_controller import Controller, ControllerInputs, ControllerSettings
from marine_model.errors import InputError
from support.controller_rig import VESSEL, rig

DT = 0.2


def off_station(ship: Any) -> None:
    """Held at 0 with an error and an integral in every axis."""
    ship.step()
    ship.position, ship.velocity = np.array([-0.3, 0.2, 0.1]), np.array([0.02, 0.01, 0.01])
    ship.run(100)


def test_lost_observer_leaves_the_integral_part() -> None:
    ship = rig(mode="setpoint")
    off_station(ship)
    before = ship.step()
    assert np.abs(before.integral).min() > 0.5
    ship.valid = False
    ship.position = ship.velocity = np.full(3, math.nan)  # nobody looks at it
    lost = ship.step()
    assert lost.status == "observer_invalid"
    assert lost.tau_desired == pytest.approx(before.tau_desired, abs=1e-12)
    late = ship.run(100)
    assert late.tau_desired == pytest.approx(before.integral, abs=1e-12)
    assert not late.proportional.any()
    assert not late.derivative.any()


def test_recovery_is_bumpless_and_returns_to_the_set_point() -> None:
    ship = rig(mode="setpoint")
    off_station(ship)
    ship.valid = False
    held = ship.run(100)
    ship.valid = True
    ship.position = np.array([2.0, -1.0, 0.5])
    back = ship.step()
    assert back.status == "nominal"
    assert back.tau_desired == pytest.approx(held.tau_desired, abs=1e-12)
    assert back.reference_position == pytest.approx(ship.position, abs=1e-12)
    assert back.integral == pytest.approx(held.integral, abs=1e-12)
    assert ship.run(500).reference_position == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_lost_observer_does_not_touch_manual_axes() -> None:
    ship = rig(mode="semi_automatic", joystick_timeout=0.0)
    ship.controller.set_joystick([4.0, 5.0, 6.0])
    off_station(ship)
    ship.valid = False
    output = ship.run(100)
    assert output.tau_desired == pytest.approx([4.0, 5.0, output.integral[2]], abs=1e-12)


def test_mode_changes_while_the_observer_is_lost() -> None:
    ship = rig(mode="tracking")
    ship.controller.set_path([0.0, 50.0], [[0, 0, 0], [5, 0, 0]])
    off_station(ship)
    ship.valid = False
    ship.step()
    ship.change(mode="setpoint")
    ship.run(5)
    ship.valid = True
    ship.position, ship.velocity = np.array([1.0, 1.0, 0.0]), np.zeros(3)
    # Neither the path nor what was held before it: the present position.
    assert ship.run(300).reference_position == pytest.approx([1.0, 1.0, 0.0], abs=1e-9)


def test_never_a_valid_estimate() -> None:
    ship = rig(mode="setpoint")
    ship.valid = False
    output = ship.run(20)
    assert output.status == "observer_invalid"
    assert not output.tau_desired.any()


def test_axis_that_becomes_automatic_without_an_estimate_keeps_the_demand_in_force() -> None:
    ship = rig(mode="joystick", joystick_timeout=0.0, transfer_time=0.0)
    ship.controller.set_joystick([4.0, 5.0, 0.6])
    ship.run(3)
    ship.valid = False
    ship.change(mode="setpoint")
    assert ship.run(10).tau_desired == pytest.approx([4.0, 5.0, 0.6], abs=1e-12)


def test_silent_joystick_fades_to_zero_and_comes_back_without_a_bump() -> None:
    ship = rig(mode="joystick", joystick_timeout=1.0, transfer_time=4.0)
    ship.step()
    ship.controller.set_joystick([8.0, 0.0, 0.0], time=0.2)
    outputs = [ship.step() for _ in range(40)]  # 0.2 s ... 8.0 s
    for k, output in enumerate(outputs):
        age = 0.2 * k
        # One rounding for every addition to the clock.
        assert output.tau_desired[0] == pytest.approx(8.0 * min(1.0, max(0.0, 1.0 - (age - 1.0) / 4.0)), abs=1e-9)
        if abs(age - 1.0) > 0.1:
            assert output.status == ("joystick_stale" if age > 1.0 else "nominal")
    ship.controller.set_joystick([8.0, 0.0, 0.0])
    assert ship.step().tau_desired[0] == 0.0
    assert ship.step().tau_desired[0] == pytest.approx(8.0 * 0.2 / 4.0, abs=1e-12)


def test_a_joystick_that_never_spoke_is_stale() -> None:
    output = rig(mode="joystick").step()
    assert (output.status, output.tau_desired.tolist()) == ("joystick_stale", [0.0, 0.0, 0.0])


def test_two_safe_states_at_once_are_both_named() -> None:
    ship = rig(mode="semi_automatic")
    ship.valid = False
    assert ship.step().status == "observer_invalid,joystick_stale"


def test_tracking_without_a_path_holds_the_present_position() -> None:
    ship = rig(mode="tracking")
    ship.position = np.array([1.0, 2.0, 0.5])
    output = ship.run(20)
    assert output.status == "path_missing"
    assert output.reference_position == pytest.approx(ship.position, abs=1e-12)


def test_a_late_estimate_counts_as_ten_samples() -> None:
    ship = rig(mode="setpoint")
    off_station(ship)
    before = ship.step()
    late = ship.step(dt=1000.0)
    assert late.status == "estimate_late"
    grown = np.array([3.0, 3.1, 0.59]) * late.error * 2.0
    assert late.integral - before.integral == pytest.approx(grown, abs=1e-9)
    assert ship.step().status == "nominal"


def inputs(**changes: Any) -> ControllerInputs:
    values: dict[str, Any] = {
        "position": np.zeros(3),
        "velocity": np.zeros(3),
        "tau_achieved": np.zeros(3),
        "valid": True,
    }
    return ControllerInputs(**(values | changes))


@pytest.mark.parametrize(
    ("bad", "dt", "message"),
    [
        (
            inputs(position=np.array([0.0, math.nan, 0.0])),
            DT,
            "position: expected finite numbers, found [0.0, nan, 0.0]",
        ),
        (
            inputs(velocity=np.array([math.inf, 0.0, 0.0])),
            DT,
            "velocity: expected finite numbers, found [inf, 0.0, 0.0]",
        ),
        (inputs(tau_achieved=np.full(3, math.nan)), DT, "tau_achieved: expected finite numbers, found [nan, nan, nan]"),
        (inputs(position=np.zeros(4)), DT, "position: expected shape (3,), found (4,)"),
        (inputs(velocity=["a", 0, 0]), DT, "velocity: expected 3 numbers, found ['a', 0, 0]"),
        (inputs(), 0.0, "dt: expected a number above 0, found 0.0"),
        (inputs(), math.nan, "dt: expected a finite number, found nan"),
    ],
)
def test_bad_estimate_is_refused_and_nothing_is_lost(bad: ControllerInputs, dt: float, message: str) -> None:
    pair = [Controller(VESSEL, ControllerSettings(mode="setpoint")) for _ in range(2)]
    moving = inputs(position=np.array([0.1, -0.1, 0.2]), velocity=np.array([0.01, 0.02, 0.03]))
    for controller in pair:
        controller.step(inputs(), DT)
        controller.step(moving, DT)
    with pytest.raises(InputError) as caught:
        pair[0].step(bad, dt)
    assert str(caught.value) == message
    for _ in range(3):
        a, b = (controller.step(moving, DT) for controller in pair)
        assert a.tau_desired.tolist() == b.tau_desired.tolist()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda c: c.set_setpoint([0.0, math.nan, 0.0]), "set point: expected finite numbers, found [0.0, nan, 0.0]"),
        (lambda c: c.set_setpoint([0.0, 0.0]), "set point: expected shape (3,), found (2,)"),
        (lambda c: c.set_joystick([0.0, math.inf, 0.0]), "joystick: expected finite numbers, found [0.0, inf, 0.0]"),
        (lambda c: c.set_joystick([0, 0, 0], time=0.5), "joystick time: expected at least 0.600 s, found 0.500 s"),
        (
            lambda c: c.set_joystick([0, 0, 0], time=1e9),
            "joystick time: expected at most 2.000 s after the last estimate, found 999999999.400 s",
        ),
        (lambda c: c.set_joystick([0, 0, 0], time=math.nan), "joystick time: expected a finite number, found nan"),
        (lambda c: c.set_path([0.0, 0.0], np.zeros((2, 3))), "path times: expected them to increase"),
    ],
)
def test_bad_operator_input_is_refused_with_the_reason_and_the_last_good_one_kept(
    call: Callable[[Controller], None], message: str
) -> None:
    ship = rig(mode="semi_automatic")
    ship.run(4)
    ship.controller.set_joystick([1.0, 2.0, 0.0], time=0.6)
    ship.controller.set_setpoint([0.0, 0.0, 0.3])
    ship.controller.set_path([0.0, 1.0], [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    with pytest.raises(InputError) as caught:
        call(ship.controller)
    assert message in str(caught.value)
    output = ship.step()
    assert output.message == f"refused: {caught.value}"
    assert output.joystick == pytest.approx([1.0, 2.0, 0.0])
    assert ship.controller._guidance.has_path
    for _ in range(200):
        ship.controller.set_joystick([1.0, 2.0, 0.0])
        output = ship.step()
    assert output.reference_position[2] == pytest.approx(0.3, abs=1e-6)


@pytest.mark.parametrize(
    "bad",
    [{"mode": "autopilot"}, {"axis_yaw": "manual"}, {"transfer_time": -1.0}, {"tau_max": (1.0, 2.0)}, {"gain": 1.0}],
)
def test_bad_settings_are_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(bad))):
        ControllerSettings.model_validate(bad)


def test_answers_say_what_was_understood() -> None:
    ship = rig()
    ship.change(mode="setpoint")
    assert ship.controller.message == "accepted: mode setpoint: surge automatic, sway automatic, yaw automatic"
    ship.controller.set_setpoint([1.0, 2.0, 0.5])
    assert ship.controller.message == "accepted: set point 1.000 m, 2.000 m, 0.5000 rad"
    ship.controller.set_path([0.0, 10.0], [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    assert ship.controller.message == (
        "accepted: path of 2 poses from 0.0 s to 10.0 s; faster than the velocity limit in surge (0.45 of 0.1): "
        "the reference will lag; waits for mode tracking"
    )
    ship.change(transfer_time=1.0)
    assert ship.controller.message == "accepted: settings"
    assert ship.step().message == "accepted: settings"
