"""Rise rates and time shift of ventilation, and the open-water runs of [Ruth] 2.3.3."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.ventilation import VentilationData
from marine_model.ventilation.dynamic import LossRates, extrapolate, extrapolated, limited_rise, shifted
from marine_model.ventilation.static import VentilationModel


def table_2_5() -> VentilationData:
    data = load_vessel("cybership3").ventilation
    assert data is not None
    return data


DATA = table_2_5()
D, RHO = 0.25, 1000.0
# 2.3.3 samples at 125 Hz: 0.064 s are 8 samples.
DT = 0.008


def test_losses_come_at_once_and_go_at_the_rise_rate() -> None:
    rates = LossRates(DATA, 2)
    assert [a.tolist() for a in rates.step([1.0, 0.4], [1.0, 0.478], 0.1)] == [[1.0, 0.4], [1.0, 0.478]]
    thrust, torque = rates.step([0.2, 0.6], [0.304, 0.652], 0.1)
    np.testing.assert_allclose(thrust, [0.2, 0.5], rtol=1e-15)
    np.testing.assert_allclose(torque, [0.304, 0.578], rtol=1e-15)
    thrust, _ = rates.step([1.0, 0.55], [1.0, 0.6], 0.25)
    np.testing.assert_allclose(thrust, [0.45, 0.55], rtol=1e-15)
    rates.reset()
    assert rates.step([1.0, 1.0], [1.0, 1.0], 0.1)[0].tolist() == [1.0, 1.0]


@given(wanted=st.lists(st.floats(0.0, 1.0), min_size=2, max_size=30), dt=st.floats(0.001, 1.0))
def test_never_above_the_static_value_nor_faster_than_the_rate(wanted: list[float], dt: float) -> None:
    rates = LossRates(DATA, 1)
    before = None
    for value in wanted:
        (now,), _ = rates.step([value], [value], dt)
        assert now <= value
        if before is not None:
            assert now == limited_rise(value, before, 1.0, dt)
            assert now - before <= dt * (1.0 + 1e-12)
        before = now


def test_bad_input_changes_nothing() -> None:
    rates = LossRates(DATA, 1)
    rates.step([0.5], [0.5], 0.1)
    for arguments, problem in (
        (([0.9, 1.0], [0.9], 0.1), r"thrust_wetted: expected shape \(1,\)"),
        (([0.9], [math.nan], 0.1), "torque_wetted: expected finite"),
        (([0.9], [0.9], 0.0), "expected a number above 0"),
    ):
        with pytest.raises(InputError, match=problem):
            rates.step(*arguments)
    assert rates.step([1.0], [1.0], 0.1)[0] == pytest.approx([0.6])


def test_extrapolation_leads() -> None:
    # Rising at 2 a second, 0.064 s ahead.
    assert extrapolated([1.0, 3.0], [0.8, 3.0], 0.1, 0.064) == pytest.approx([1.128, 3.0])
    assert extrapolate(1.0, 0.8, 0.1, 0.064) == pytest.approx(1.128)
    with pytest.raises(InputError, match="shift: expected at least 0, found -1"):
        extrapolated(1.0, 1.0, 0.1, -1.0)


def test_extrapolation_errs_by_half_the_shift_squared_times_the_second_derivative() -> None:
    omega, shift, dt = 2.0 * math.pi / 7.0, 0.064, 1e-3
    t = np.linspace(0.0, 7.0, 701)
    guess = extrapolated(np.sin(omega * t), np.sin(omega * (t - dt)), dt, shift)
    error = np.abs(guess - np.sin(omega * (t + shift))).max()
    # The slope is that of half a step ago: shift dt / 2 more.
    assert error == pytest.approx(0.5 * shift * (shift + dt) * omega**2, rel=0.01)
    assert error < 0.002


def test_a_record_is_shifted_ahead() -> None:
    t = np.arange(100) * DT
    values = np.sin(t)
    dynamic = shifted(t, values, 8 * DT)
    np.testing.assert_allclose(dynamic[:92], values[8:], rtol=0.0, atol=1e-14)
    # The very last may be on either side of the end by rounding.
    assert np.isnan(dynamic[93:]).all()
    with pytest.raises(InputError, match="time: expected two or more rising"):
        shifted([0.0, 0.0], [1.0, 2.0], 0.1)
    with pytest.raises(InputError, match="quasi_static: expected shape"):
        shifted([0.0, 1.0], [1.0], 0.1)
    with pytest.raises(InputError, match="shift"):
        shifted([0.0, 1.0], [1.0, 2.0], math.nan)


def run(
    submergence_period: float, thrust: float, amplitude: float, power_control: bool, kt: float, seconds: float
) -> tuple[np.ndarray, ...]:
    """A run of 2.3.3: time, h/R, shaft speed, beta_T, beta_Q; K_T0 of P 1020 at P/D = 1 is not printed."""
    model, rates = VentilationModel(DATA), LossRates(DATA, 1)
    rows = []
    torque_factor = 1.0
    for k in range(round(seconds / DT)):
        t = k * DT
        desired = thrust + amplitude * math.sin(2.0 * math.pi / 7.0 * t)  # (2.57), (2.61)
        x = 1.2 + 1.2 * math.sin(2.0 * math.pi / submergence_period * t)  # (2.58), (2.59), (2.62)
        n = math.sqrt(desired / (RHO * D**4 * kt))  # (2.56)
        if power_control:
            # 2 pi n beta_Q K_Q0 rho D^5 n^2 = P_d of (2.60): n = n_d beta_Q^(-1/3), with the torque of the last sample.
            n *= torque_factor ** (-1.0 / 3.0)
        static = model.loss_factors([n], D, 1.0, [x])
        thrust_wetted, torque_wetted = rates.step(static.thrust_wetted, static.torque_wetted, DT)
        torque_factor = float(static.area[0] * torque_wetted[0])
        rows.append((t, x, n, float(static.area[0] * thrust_wetted[0]), torque_factor))
    return tuple(np.array(rows).T)


# Ducted propellers have K_T0 of 0.4 to 0.6 at P/D = 1 (Ka series); the behaviour may not hang on it.
@pytest.mark.parametrize("kt", [0.4, 0.5, 0.6])
@pytest.mark.parametrize(("period", "seconds"), [(10.0, 70.0), (100.0, 100.0)])
def test_shaft_speed_control_under_varying_submergence(kt: float, period: float, seconds: float) -> None:
    _, x, n, thrust, torque = run(period, 230.0, 160.0, False, kt, seconds)
    # Lossless when deep, fully ventilated at full speed near the surface: Figures 2.11 and 2.12.
    assert thrust.max() == pytest.approx(1.0)
    assert thrust[(x < 0.6) & (n > np.quantile(n, 0.9))].max() < 0.3
    assert (thrust <= torque + 1e-12).all()
    # Start of ventilation is faster than its end, which is held to 1/s; area comes on top near the surface.
    rate = np.diff(thrust) / DT
    covered = x[:-1] >= 1.0
    assert rate[covered].max() <= 1.0 + 1e-9
    if period == 10.0:
        assert rate.max() > 0.9
        assert rate.min() < -1.0


@pytest.mark.parametrize("kt", [0.4, 0.5, 0.6])
@pytest.mark.parametrize("thrust_reference", [100.0, 150.0, 200.0])
def test_power_control_races(kt: float, thrust_reference: float) -> None:
    _, x, n, thrust, torque = run(10.0, thrust_reference, 0.0, True, kt, 40.0)
    wanted = math.sqrt(thrust_reference / (RHO * D**4 * kt))
    # Figure 2.13: at constant reference the shaft speed varies widely, up at shallow submergence, as asked when deep.
    assert n[x > 2.3].min() == pytest.approx(wanted, rel=1e-6)
    assert n.max() > 1.25 * wanted
    assert n.max() <= wanted * (0.5 * (0.87 * 0.05 + 0.13)) ** (-1.0 / 3.0)
    assert x[np.argmax(n)] < 0.6
    # Large losses of thrust and of torque at the same time.
    assert torque[np.argmin(thrust)] < 0.6
