"""The laws that work through the pitch, [Ruth] (3.15)-(3.24), against propellers of the B-series."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model.errors import InputError
from marine_model.propellers import WageningenBPropeller
from marine_model.propellers.optimal import advance_number, optimal_maps, optimal_pitch
from marine_model.thruster import PitchDrive
from support.thruster_rig import ThrusterRig, controllable_pitch_vessel
from thruster_drivers.controllers import (
    PitchController,
    ShaftSpeedPitchController,
    ThrusterController,
    TorquePitchController,
    TorqueShaftSpeedController,
    Tuning,
    make_controller,
    tuning_of,
)
from thruster_drivers.shaft_model import ShaftModel, shaft_models

VESSEL = controllable_pitch_vessel()
MODEL = shaft_models(VESSEL)[2]
TUNING = tuning_of(VESSEL.drivers, 2)
DT = 0.02
PITCH_LAWS = ["pitch", "torque_pitch", "shaft_speed_pitch", "torque_shaft_speed"]

# [Ruth] 3.7. The gains are the printed ones: 1e6 N m/Hz is 2 pi J times 200 1/s.
B4_70 = WageningenBPropeller(4.0, 4, 0.7, 0.58)
K_T, K_Q = (float(k) for k in B4_70.coefficients(0.0))
SHIP = ShaftModel(
    thrust_per_speed_squared=K_T * 1025.0 * 4.0**4,
    torque_per_speed_squared=K_Q * 1025.0 * 4.0**5,
    inertia=5000.0 / (2.0 * math.pi),
    torque_max=1e6,
    friction_static=0.0,
    friction_viscous=0.0,
    thrust_max=300e3,
    density=1025.0,
    pitch_ratio=0.58,
    propeller=B4_70,
    pitch=PitchDrive(min=0.5, max=1.4, rate=0.2, time_constant=0.1),
)
SHIP_TUNING = Tuning(
    bandwidth=200.0,
    integral_time=1.0 / (2.0 * math.pi),
    transfer_time=0.2,
    pitch_shaft_speed=2.0,
    torque_coefficient=K_Q,
    pitch_gain=1.0,
    pitch_integral_time=3.0 / (2.0 * math.pi),
)


def run(controller: ThrusterController, rig: ThrusterRig, thrust: float, seconds: float, dt: float = DT) -> None:
    for _ in range(round(seconds / dt)):
        output = controller.step(thrust, rig.speed, rig.pitch_ratio, dt)
        rig.step(*output, dt)


@pytest.mark.parametrize("name", PITCH_LAWS)
@pytest.mark.parametrize("thrust", [13.0, 5.0, -9.0])
def test_thrust_is_met_at_bollard_pull(name: str, thrust: float) -> None:
    controller, rig = make_controller(name, MODEL, TUNING), ThrusterRig(MODEL)
    run(controller, rig, thrust, 12.0)
    # 12 s are more than 15 times the slowest mode, the pitch loop at the low speed of 5 N; the maps are good to 1e-5.
    assert rig.thrust == pytest.approx(thrust, rel=1e-3)
    assert rig.speed == pytest.approx(controller.shaft_speed_reference, rel=1e-3)


def test_fixed_pitch_is_refused() -> None:
    for name in PITCH_LAWS:
        with pytest.raises(InputError, match="pitch: expected a controllable-pitch propeller, found a fixed pitch"):
            make_controller(name, replace(MODEL, pitch=None), TUNING)


class TestPitch:
    def test_shaft_speed_is_constant_and_the_pitch_makes_the_thrust(self) -> None:
        controller, rig = PitchController(SHIP, SHIP_TUNING), ThrusterRig(SHIP)
        for thrust, pitch in ((K_T * 1025.0 * 256.0 * 4.0, 0.58), (450e3, None), (220e3, None)):
            run(controller, rig, thrust, 6.0, 0.002)
            # Hz; ten integral times of 0.16 s after the pitch has stopped
            assert rig.speed == pytest.approx(2.0, abs=1e-4)
            assert rig.thrust == pytest.approx(thrust, rel=1e-3)
            if pitch is not None:
                assert rig.pitch_ratio == pytest.approx(pitch, abs=1e-4)

    @given(st.floats(-20.0, 20.0), st.floats(1e-6, 0.05))
    def test_set_points_are_continuous_in_thrust_and_of_its_sign(self, thrust: float, step: float) -> None:
        controller = PitchController(MODEL, TUNING)
        (n1, p1), (n2, p2) = controller._aim(thrust), controller._aim(thrust + step)
        # Below the pitch range n = sqrt(T ...), whose change over a step is largest across zero.
        assert abs(n2 - n1) <= 2.0 * MODEL.shaft_speed(step) * 1.4 + 1e-9
        assert abs(p2 - p1) <= 0.2 * step + 1e-9  # slope of g: 1 / (rho D^4 n^2 dK_T/dP)
        assert n1 * thrust >= 0.0

    def test_thrust_below_the_least_pitch_is_made_by_the_shaft(self) -> None:
        controller = PitchController(MODEL, TUNING)
        least = float(MODEL.propeller.coefficients(0.0, 0.5)[0]) * 1000.0 * 0.09**4  # type: ignore[union-attr]
        n, pitch = controller._aim(0.3)
        assert pitch == 0.5
        assert least * n * n == pytest.approx(0.3, rel=1e-9)
        assert controller._aim(0.0) == (0.0, 0.5)

    def test_default_speed_is_that_of_the_largest_thrust(self) -> None:
        n, pitch = PitchController(MODEL, TUNING)._aim(MODEL.thrust_max)
        assert n == pytest.approx(MODEL.shaft_speed(MODEL.thrust_max))
        assert pitch == pytest.approx(MODEL.pitch_ratio, abs=1e-4)  # table of g


class TestOptimalLaws:
    @pytest.mark.parametrize("advance_speed", [0.0, 0.5, 1.0])
    def test_pitch_is_the_best_one_for_the_assumed_advance_speed(self, advance_speed: float) -> None:
        tuning = replace(TUNING, advance_speed=advance_speed)
        thrust = 10.0
        tau = math.sqrt(1000.0) * 0.09 * advance_speed / math.sqrt(thrust)
        for law in (TorquePitchController, ShaftSpeedPitchController):
            controller, rig = law(MODEL, tuning), ThrusterRig(MODEL, advance_speed)
            run(controller, rig, thrust, 12.0)
            # Tables with straight pieces between 2001 points, on maps good to 1e-5.
            assert rig.pitch_ratio == pytest.approx(float(optimal_pitch(MODEL.propeller, tau)), rel=1e-4)  # type: ignore[arg-type]
            # Model and advance speed are exact, and so is the thrust.
            assert rig.thrust == pytest.approx(thrust, rel=1e-3)

    def test_both_laws_agree_and_use_least_power(self) -> None:
        thrust, speed = 10.0, 0.8
        powers = {}
        for name in ("torque_pitch", "shaft_speed_pitch", "torque"):
            model = MODEL if name != "torque" else replace(MODEL, pitch=None)
            controller = make_controller(name, model, replace(TUNING, advance_speed=speed))
            rig = ThrusterRig(MODEL, speed)
            run(controller, rig, thrust, 12.0)
            powers[name] = rig.speed * rig.torque / abs(rig.thrust) ** 1.5
        assert powers["torque_pitch"] == pytest.approx(powers["shaft_speed_pitch"], rel=1e-3)
        assert powers["torque_pitch"] < powers["torque"]

    def test_astern_the_advance_speed_is_left_out(self) -> None:
        controller = TorquePitchController(MODEL, replace(TUNING, advance_speed=2.0))
        torque, desired, pitch = controller._aim(-6.0, 0.0)
        still = TorquePitchController(MODEL, TUNING)._aim(6.0, 0.0)
        assert (-torque, -desired, pitch) == still


class TestTorqueShaftSpeed:
    def test_set_points_of_section_3_7(self) -> None:
        """(3.22)-(3.23) with P_d of (3.11) are (3.10) and (3.8)."""
        controller = TorqueShaftSpeedController(SHIP, SHIP_TUNING)
        thrust = 200e3
        power = 2.0 * math.pi * K_Q / (math.sqrt(1025.0) * 4.0 * K_T**1.5) * thrust**1.5  # (3.11)
        load = K_Q * 1025.0 * 4.0**5
        torque, desired, _ = controller._aim(thrust, 0.0)
        # The pitch of K_Qc is found to rounding.
        assert torque == pytest.approx((load / (2.0 * math.pi) ** 2 * power**2) ** (1.0 / 3.0), rel=1e-6)
        assert desired == pytest.approx((power / (2.0 * math.pi * load)) ** (1.0 / 3.0), rel=1e-6)

    @pytest.mark.parametrize("advance_speed", [0.0, 0.5, 1.0])
    @pytest.mark.parametrize("coefficient", [None, 0.033])
    def test_torque_and_shaft_speed_are_kept_whatever_the_flow(
        self, advance_speed: float, coefficient: float | None
    ) -> None:
        controller = TorqueShaftSpeedController(MODEL, replace(TUNING, torque_coefficient=coefficient))
        rig = ThrusterRig(MODEL, advance_speed)
        run(controller, rig, 10.0, 20.0)
        torque, desired, _ = controller._aim(10.0, 0.0)
        assert rig.speed == pytest.approx(desired, rel=1e-4)  # 20 s: the integral is done
        assert rig.torque == pytest.approx(torque, rel=1e-4)
        wanted = coefficient or float(optimal_maps(MODEL.propeller, (0.5, 1.4)).torque_coefficient(0.0))  # type: ignore[arg-type]
        assert rig.torque / (1000.0 * 0.09**5 * rig.speed**2) == pytest.approx(wanted, rel=1e-3)
        J = advance_speed / (rig.speed * 0.09)
        tau = J / math.sqrt(float(MODEL.propeller.coefficients(J, rig.pitch_ratio)[0]))  # type: ignore[union-attr]
        assert float(advance_number(MODEL.propeller, tau, rig.pitch_ratio)) == pytest.approx(J, abs=1e-9)  # type: ignore[arg-type]

    def test_gains_of_section_3_7_settle_in_its_flow(self) -> None:
        controller = TorqueShaftSpeedController(SHIP, replace(SHIP_TUNING, pitch_filter_time=0.1))
        rig = ThrusterRig(SHIP, 1.0)
        run(controller, rig, 200e3, 20.0, 0.005)
        assert rig.speed == pytest.approx(SHIP.shaft_speed(200e3), rel=1e-3)
        assert rig.pitch_ratio > 0.58

    def test_a_saturated_pitch_does_not_wind_up(self) -> None:
        """After 40 s the pitch must leave the end of its range as soon as after 10 s."""

        def time_to_leave(held: float) -> float:
            controller, rig = TorqueShaftSpeedController(MODEL, TUNING), ThrusterRig(MODEL, 3.0)
            run(controller, rig, 10.0, held)
            assert rig.pitch_ratio > 1.39
            rig.advance_speed = 0.0
            for k in range(2000):
                output = controller.step(10.0, rig.speed, rig.pitch_ratio, DT)
                if output.pitch_ratio < 1.39:
                    return k * DT
                rig.step(*output, DT)
            raise AssertionError("the pitch never left its limit")

        assert time_to_leave(40.0) == pytest.approx(time_to_leave(10.0), abs=2.0 * DT)

    def test_error_is_filtered(self) -> None:
        """Noise of a sample passes T_s / (T_s + T_f) of the way to the pitch."""
        quiet, noisy = (TorqueShaftSpeedController(MODEL, TUNING) for _ in range(2))
        n = quiet._aim(10.0, 0.0)[1]
        for _ in range(50):
            quiet.step(10.0, n, 0.8, DT)
            noisy.step(10.0, n, 0.8, DT)
        step = noisy.step(10.0, n + 0.5, 0.8, DT).pitch_ratio - quiet.step(10.0, n, 0.8, DT).pitch_ratio
        servo = MODEL.pitch.time_constant  # type: ignore[union-attr]
        proportional = noisy._gain * 0.5 * DT / (DT + servo)
        assert step == pytest.approx(proportional * (1.0 + DT / noisy._integral_time), rel=1e-9)

    def test_lost_shaft_speed_or_no_thrust_leaves_the_pitch(self) -> None:
        controller, rig = TorqueShaftSpeedController(MODEL, TUNING), ThrusterRig(MODEL, 0.5)
        run(controller, rig, 10.0, 10.0)
        pitch = controller.step(10.0, rig.speed, rig.pitch_ratio, DT).pitch_ratio
        for thrust, speed in ((10.0, math.nan), (10.0, math.inf), (0.0, 3.0)):
            for _ in range(20):
                output = controller.step(thrust, speed, rig.pitch_ratio, DT)
            assert output.pitch_ratio == pytest.approx(pitch, abs=1e-12)

    @pytest.mark.parametrize("coefficient", [0.005, 0.2])
    def test_a_torque_coefficient_that_no_pitch_has_is_refused(self, coefficient: float) -> None:
        with pytest.raises(InputError, match=r"torque_coefficient: expected 0.0\d+ to 0.\d+, .* found"):
            TorqueShaftSpeedController(MODEL, replace(TUNING, torque_coefficient=coefficient))


@pytest.mark.parametrize("name", PITCH_LAWS)
def test_pitch_set_point_keeps_range_and_rate(name: str) -> None:
    rng = np.random.default_rng(3)
    controller = make_controller(name, MODEL, TUNING)
    last = 0.93  # measured at the first step: the set point starts there
    for _ in range(500):
        thrust, speed = rng.uniform(-13.0, 13.0), rng.uniform(-30.0, 30.0)
        pitch = controller.step(thrust, speed, 0.93, DT).pitch_ratio
        assert abs(pitch - last) <= 0.4 * DT * (1.0 + 1e-9)
        assert 0.5 <= pitch <= 1.4
        last = pitch
