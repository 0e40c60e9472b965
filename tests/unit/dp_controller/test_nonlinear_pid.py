"""Nonlinear PID, [Ruth] (B.15)-(B.18)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dp_controller import Controller, ControllerInputs, ControllerSettings
from dp_controller.pid import NonlinearPid
from dp_controller.vectors import ZERO
from support.controller_rig import VESSEL, Basin, basin


def test_hand_worked_case_with_the_gains_of_appendix_b() -> None:
    """Heading 90 deg east: 0.2 m to the north is 0.2 m to port, 0.1 m to the east is 0.1 m ahead."""
    controller = Controller(VESSEL, ControllerSettings(mode="setpoint"))
    at = np.array([0.0, 0.0, math.pi / 2])
    rest = np.zeros(3)
    controller.step(ControllerInputs(at, rest, None), 0.2)
    # The reference has come to rest at the set point: 0.5 rad/s settles to 1e-12 within 80 s.
    controller.set_setpoint([0.2, 0.1, math.pi / 2 + 0.05])
    goal = np.array([0.2, 0.1, math.pi / 2 + 0.05])
    for _ in range(400):
        before = controller.step(ControllerInputs(goal, rest, None), 0.2)
    output = controller.step(ControllerInputs(at, np.array([0.01, -0.02, 0.03]), None), 0.2)
    assert output.error == pytest.approx([0.1, -0.2, 0.05], abs=1e-12)
    assert output.proportional == pytest.approx([75 * 0.1, 77 * -0.2, 15 * 0.05], abs=1e-9)
    assert output.derivative == pytest.approx([-98 * 0.01, -89 * -0.02, -14 * 0.03], abs=1e-12)
    grown = [3.0 * 0.1 * 0.2, 3.1 * -0.2 * 0.2, 0.59 * 0.05 * 0.2]
    assert output.integral - before.integral == pytest.approx(grown, abs=1e-12)
    assert output.transfer == pytest.approx([0, 0, 0], abs=0)
    total = output.proportional + output.integral + output.derivative
    assert output.tau_desired == pytest.approx(total, abs=1e-12)


def test_integral_is_in_the_body_frame() -> None:
    pid = NonlinearPid(ZERO, (3.0, 3.1, 0.59), ZERO)
    pid.integrate((0.1, 0.0, 0.0), ZERO, 0.2, 10.0)
    pid.integrate((0.0, -0.1, 1.0), ZERO, 0.2, 10.0)
    assert pid.force == pytest.approx((0.06, -0.062, 0.118), abs=1e-15)


def test_back_calculation_is_a_first_order_lag() -> None:
    pid = NonlinearPid(ZERO, ZERO, ZERO)
    pid.force = (10.0, 10.0, 10.0)
    # Thrusters give nothing in surge: what is asked for (the integral) falls as exp(-t / T).
    for _ in range(50):
        pid.integrate(ZERO, (-pid.force[0], 0.0, 0.0), 0.2, 5.0)
    assert pid.force == pytest.approx((10.0 * math.exp(-2.0), 10.0, 10.0), abs=1e-12)
    pid.integrate(ZERO, (-pid.force[0], 0.0, 0.0), 1e6, 5.0)
    assert pid.force[0] == pytest.approx(0.0, abs=1e-12)


def drift_off_and_recover(ship: Basin, anti_windup_time: float) -> tuple[float, float, float]:
    """16 N against thrusters of 15 N for a minute, then 5 N: largest |I| and |P| under strain, largest overshoot."""
    controller = Controller(VESSEL, ControllerSettings(mode="setpoint", anti_windup_time=anti_windup_time))
    strained = ship.sail(controller, 60.0)
    assert ship.position[0] < -7.0  # far off: hundreds of newtons of proportional part
    ship.force[:] = [-5.0, 0.0, 0.0]
    overshoot = max(max(ship.sail(controller, 0.2)[0].error[0] * -1.0 for _ in range(50)) for _ in range(40))
    assert ship.position == pytest.approx([0, 0, 0], abs=1e-3)  # recovered after 400 s, 16 integral times
    return (
        max(abs(output.integral[0]) for output in strained),
        max(abs(output.proportional[0]) for output in strained),
        overshoot,
    )


@pytest.mark.parametrize("anti_windup_time", [5.0, 20.0])
def test_saturated_thrusters_do_not_wind_up_the_integral(anti_windup_time: float) -> None:
    integral, proportional, overshoot = drift_off_and_recover(
        basin(force=[-16.0, 0.0, 0.0], tau_max=15.0), anti_windup_time
    )
    # In the steady state of back-calculation the whole demand is a little above what is achieved: |I| < |P| + 15 N.
    assert integral < proportional
    assert overshoot < 0.01
    _, _, without = drift_off_and_recover(basin(force=[-16.0, 0.0, 0.0], tau_max=15.0), 0.0)
    assert without > 10.0


def test_demand_limit_does_not_wind_up_the_integral() -> None:
    """The same with a limit on the demand, and an allocator that says nothing."""
    integral = {}
    for time in (20.0, 0.0):
        settings = ControllerSettings(mode="setpoint", anti_windup_time=time, tau_max=(15.0, 0.0, 0.0))
        controller, away = Controller(VESSEL, settings), np.array([-1.0, 0.0, 0.0])
        controller.step(ControllerInputs(np.zeros(3), np.zeros(3)), 0.2)
        for _ in range(1000):
            output = controller.step(ControllerInputs(away, np.zeros(3)), 0.2)
            assert abs(output.tau_desired[0]) <= 15.0
        integral[time] = output.integral[0]
    assert integral[0.0] == pytest.approx(3.0 * 1.0 * 200.0, rel=1e-9)
    # Equilibrium of back-calculation: K_I e T = P + I - 15 with P = 75, hence I = 0.
    assert integral[20.0] == pytest.approx(3.0 * 20.0 - 75.0 + 15.0, abs=1.0)


def test_gain_scales_multiply_the_gains_of_the_vessel() -> None:
    settings = ControllerSettings(
        mode="setpoint",
        proportional_scale=(2.0, 1.0, 1.0),
        derivative_scale=(1.0, 0.5, 1.0),
        integral_scale=(1.0, 1.0, 0.0),
    )
    controller = Controller(VESSEL, settings)
    assert controller._pid.gains == ((150.0, 77.0, 15.0), (3.0, 3.1, 0.0), (98.0, 44.5, 14.0))
