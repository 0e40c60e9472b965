"""Behaviour of the trials that come with the project: [Ruth] 2.3.3, Figure 2.17, 3.7, and low-level anti-spin."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from dp_tools.open_water.load import load_trial
from dp_tools.open_water.measures import MEASURES, VENTILATED, corrected_mean_power
from dp_tools.open_water.outcome import work_out
from dp_tools.open_water.record import CaseRecord, Record
from dp_tools.open_water.run import run_trial
from dp_tools.open_water.surroundings import Inflow, JonswapWaves, ThrustReference
from dp_tools.open_water.trial import Trial
from marine_model.constants import GRAVITY
from marine_model.guards import FloatArray
from marine_model.ventilation.static import modified_froude_number
from support.open_water_files import TRIALS
from vessel_sim.waves import Jonswap

SHAFT_SPEED_TRIALS = ("ventilation_fast", "ventilation_slow")


@cache
def run(name: str) -> tuple[Trial, Record]:
    trial = load_trial(TRIALS / f"{name}.yaml")
    return trial, run_trial(trial)


def depth_without_loss(trial: Trial, shaft_speed: float, pitch_ratio: float = 1.0) -> float:
    """Return h/R below which the static map has no loss at ``shaft_speed``: F_nh2 falls with depth, the line rises."""
    assert trial.ventilation is not None
    line = trial.ventilation.line("plus", 1.0)
    diameter = trial.propeller.diameter

    def above(x: float) -> float:
        return modified_froude_number(shaft_speed, diameter, pitch_ratio, x) - line(x)

    return float(brentq(above, 0.0, 5.0))


def lasting(condition: FloatArray, time: float, dt: float) -> FloatArray:
    """Return where ``condition`` has held for ``time`` (s)."""
    steps = math.ceil(time / dt)
    held = np.convolve(condition.astype(float), np.ones(steps))[: len(condition)]
    return np.asarray(held > steps - 0.5)


def cycles(record: Record, period: float, start: float) -> list[slice]:
    """Return the whole cycles of submergence after ``start`` (s)."""
    ends = np.arange(start, float(record.t[-1]) + 1e-6, period)
    return [record.window(float(a), float(b)) for a, b in itertools.pairwise(ends)]


@pytest.mark.parametrize("name", SHAFT_SPEED_TRIALS)
def test_no_loss_where_the_propeller_is_deep(name: str) -> None:
    trial, record = run(name)
    case = record.cases["shaft_speed"]
    assert trial.submergence_ratio is not None
    assert trial.ventilation is not None
    # The losses are those of the submergence 0.064 s later.
    ratio = trial.submergence_ratio.at(record.t + trial.ventilation.time_shift)
    enough = depth_without_loss(trial, float(case.shaft_speed.max()))
    assert 1.5 < enough < 2.4  # (2.58)-(2.59) reach deeper, or nothing would be tested
    # Back from total loss at the largest rate of rise, 1 1/s, beta is 1 after a second.
    deep = lasting(ratio > enough, 1.0, trial.time_step)
    assert deep.sum() * trial.time_step > 2.0
    np.testing.assert_allclose(case.thrust_loss[deep], 1.0, atol=0.01)
    # Thrust is the demand but for what the shaft lags behind it, 1/50 s of a sine of 7 s: 2 pi / 350 of its amplitude.
    error = np.abs(case.thrust - case.thrust_demanded)[deep]
    assert float(error.max()) < 1.5 * 2.0 * math.pi / 350.0 * 160.0


@pytest.mark.parametrize("name", SHAFT_SPEED_TRIALS)
def test_losses_begin_and_end_in_every_cycle_of_submergence(name: str) -> None:
    trial, record = run(name)
    assert trial.submergence_ratio is not None
    period = trial.submergence_ratio.period
    assert period is not None
    loss = record.cases["shaft_speed"].thrust_loss
    found = cycles(record, period, period)
    assert len(found) >= 1
    for cycle in found:
        assert float(loss[cycle].min()) < 0.2
        assert float(loss[cycle].max()) > 0.99
    # Full ventilation: beta_Tw at its least, 0.05, with most of the disc wet.
    assert float(loss.min()) < 0.05


@pytest.mark.parametrize("name", ["ventilation_fast", "ventilation_power"])
def test_thrust_is_lost_faster_than_it_comes_back(name: str) -> None:
    trial, record = run(name)
    assert record.submergence_ratio is not None
    # Covered by water, so that beta_T is beta_Tw, whose rise is limited to 1 1/s, (2.52).
    covered = record.submergence_ratio[1:] > 1.1
    for case in record.cases.values():
        rate = np.diff(case.thrust_loss)[covered] / trial.time_step
        assert float(rate.max()) == pytest.approx(1.0, abs=1e-6)
        assert float(rate.min()) < -1.1


def test_shaft_speed_control_keeps_its_speed_while_the_propeller_ventilates() -> None:
    trial, record = run("ventilation_fast")
    case = record.cases["shaft_speed"]
    K_T, _ = trial.propeller.build().coefficients(0.0)
    wanted = np.sqrt(case.thrust_demanded / (float(K_T) * trial.density * trial.propeller.diameter**4))  # (2.56)
    measured = record.window(10.0, 60.0)
    assert float(np.abs(case.shaft_speed - wanted)[measured].max()) < 0.02 * float(wanted.max())
    assert float(case.thrust_loss[measured].min()) < 0.05


def test_power_control_races_when_the_load_falls() -> None:
    trial, record = run("ventilation_power")
    K_T, K_Q = (float(k) for k in trial.propeller.build().coefficients(0.0))
    D, rho = trial.propeller.diameter, trial.density
    for window, thrust in (("low", 100.0), ("middle", 150.0), ("high", 200.0)):
        part = record.window(*trial.windows[window])
        power, speed = record.cases["power"].part(part), record.cases["shaft_speed"].part(part)
        nominal = math.sqrt(thrust / (K_T * rho * D**4))
        wet = power.thrust_loss > 0.999
        np.testing.assert_allclose(power.shaft_speed[wet & (power.torque_loss > 0.999)].min(), nominal, rtol=0.01)
        # P = beta_Q K_Q rho D^5 n^3 holds the power, so n = nominal beta_Q^(-1/3); dynamics and the limit on the ratio
        # of torques, 2, take off some of it.
        fastest = float(power.torque_loss.min()) ** (-1.0 / 3.0) * nominal
        assert 0.85 * fastest < float(power.shaft_speed.max()) < 1.01 * fastest
        assert float(power.shaft_speed.max()) > 1.7 * nominal
        assert float(speed.shaft_speed.max()) < 1.03 * nominal
        # (2.60)
        demand = 2.0 * math.pi * K_Q / (math.sqrt(rho) * D * K_T**1.5) * thrust**1.5
        np.testing.assert_allclose(power.power, demand, rtol=0.02)
        # Racing to full ventilation makes it worse: the faster propeller draws more air. At 100 N it stops short of
        # that, and more turns make up for some of the loss.
        full = float(power.thrust_loss.min()) < 0.05
        assert full == (thrust > 100.0)
        assert (float(power.thrust.mean()) < float(speed.thrust.mean())) == full


def test_a_lower_pitch_ventilates_less() -> None:
    """Figure 2.17, and the same with equal thrust by our propeller."""
    trial, record = run("pitch_comparison")
    measured = record.window(*trial.windows["all"])
    low, high, same = (record.cases[name].part(measured) for name in ("low_pitch", "high_pitch", "same_thrust"))
    # F_nh2 goes with n P/D: 10.7 and 9.7 against 12.0 Hz, at every depth; more than the shaft speeds move about.
    assert (low.shaft_speed * low.pitch_ratio < high.shaft_speed * high.pitch_ratio).all()
    assert (low.thrust_loss >= high.thrust_loss - 1e-9).all()
    assert (same.thrust_loss >= low.thrust_loss - 1e-9).all()
    for case in (low, same):
        assert float((case.thrust_loss < VENTILATED).mean()) < float((high.thrust_loss < VENTILATED).mean())
        assert float(case.thrust.mean()) > 1.1 * float(high.thrust.mean())
    assert float(same.thrust_demanded[0]) == pytest.approx(float(high.thrust_demanded[0]), rel=0.005)


def test_anti_spin_keeps_the_shaft_below_its_limit_and_gets_more_thrust() -> None:
    trial, record = run("anti_spin")
    measured = record.window(*trial.windows["all"])
    plain, guarded = record.cases["plain"].part(measured), record.cases["anti_spin"].part(measured)
    K_T, _ = trial.propeller.build().coefficients(0.0)
    full = math.sqrt(trial.limits.max / (float(K_T) * trial.density * trial.propeller.diameter**4))
    limit = trial.anti_spin.speed_limit * full
    assert float(plain.shaft_speed.max()) > limit > float(guarded.shaft_speed.max())
    assert float(guarded.thrust.mean()) > float(plain.thrust.mean())
    assert float(guarded.power.mean()) < 0.8 * float(plain.power.mean())
    # Wet for a while, nothing is held back.
    wet = lasting(guarded.thrust_loss > 0.999, 2.0, trial.time_step)
    assert wet.any()
    np.testing.assert_allclose(guarded.thrust[wet], guarded.thrust_demanded[wet], rtol=0.02)


def test_section_3_7() -> None:
    trial, record = run("section_3_7")
    measured = record.window(*trial.windows["all"])
    cases = {name: case.part(measured) for name, case in record.cases.items()}
    power = {name: MEASURES["corrected_mean_power"].of(case) for name, case in cases.items()}
    # The thrust is calibrated to this number, as it is printed.
    assert power["shaft_speed"] == pytest.approx(3.00e6, abs=0.005e6)
    # Order of Table 3.4.
    assert power["torque_shaft_speed"] < power["combined"] < power["shaft_speed"] < power["pitch"]
    # "The combined controller and the torque/shaft speed controller have the most correct thrust production".
    off = {name: float(np.abs(case.thrust / case.thrust_demanded - 1.0).mean()) for name, case in cases.items()}
    assert sorted(off, key=off.__getitem__) == ["torque_shaft_speed", "combined", "pitch", "shaft_speed"]
    # What each holds.
    assert float(cases["pitch"].shaft_speed.std()) < 0.002 * 2.0
    assert float(cases["torque_shaft_speed"].torque.std()) < 1e-6 * float(cases["torque_shaft_speed"].torque.mean())
    assert float(cases["combined"].power.std()) < 1e-3 * float(cases["combined"].power.mean())
    for case in cases.values():
        assert (case.thrust_loss == 1.0).all()
    rate = np.abs(np.diff(record.cases["torque_shaft_speed"].pitch_ratio)) / trial.time_step
    assert float(rate.max()) <= 0.2 * (1.0 + 1e-9)


def test_orbital_velocity_has_the_variance_of_its_spectrum() -> None:
    waves = JonswapWaves(spectrum="jonswap", significant_height=2.0, peak_period=5.9, peakedness=3.3, seed=4)
    speed = Inflow(current=1.0, waves=waves, depth=5.0).advance_speed(np.arange(0.0, 7200.0, 0.5))
    density = Jonswap(2.0, 5.9, 3.3).density

    def square(omega: float) -> float:
        return float(density(omega)) * omega**2 * math.exp(-2.0 * omega**2 / GRAVITY * 5.0)

    variance, _ = quad(square, 0.1, 5.0, limit=200)
    # Equal-energy components and two hours: a few per cent of scatter.
    assert float(speed.std()) == pytest.approx(math.sqrt(variance), rel=0.04)
    assert float(speed.mean()) == pytest.approx(1.0, abs=0.01)


def test_positive_advance_speed_only() -> None:
    time = np.linspace(0.0, 100.0, 1001)
    waves = JonswapWaves(spectrum="jonswap", significant_height=2.0, peak_period=5.9, peakedness=3.3)
    free = Inflow(current=0.1, waves=waves, depth=5.0).advance_speed(time)
    held = Inflow(current=0.1, waves=waves, depth=5.0, positive_only=True).advance_speed(time)
    assert float(free.min()) < 0.0
    np.testing.assert_array_equal(held, np.maximum(free, 0.0))


def test_thrust_in_steps() -> None:
    thrust = ThrustReference(steps=((0.0, 10.0), (1.0, 20.0), (2.0, 5.0)))
    np.testing.assert_array_equal(
        thrust.at(np.array([0.0, 0.99, 1.0, 1.5, 2.0, 9.0])), [10.0, 10.0, 20.0, 20.0, 5.0, 5.0]
    )
    assert thrust.extremes == (5.0, 20.0)


def test_corrected_mean_power_by_hand() -> None:
    """(3.68): 3 W on average with a quarter of the thrust asked for, at 4^(3/2) = 8 times as much."""
    found = corrected_mean_power(np.array([2.0, 4.0]), np.array([4.0, 4.0]), np.array([0.5, 1.5]))
    assert found == pytest.approx(24.0, rel=1e-15)


def test_measures_by_hand() -> None:
    series = {
        "thrust_demanded": [0.0, 2.0, 4.0],
        "thrust": [1.0, 1.0, 4.0],
        "shaft_speed": [1.0, 2.0, 6.0],
        "torque": [1.0, 1.0, 1.0],
        "power": [3.0, 6.0, 9.0],
        "pitch_ratio": [0.5, 0.6, 0.7],
        "thrust_loss": [1.0, 0.5, 0.9],
        "torque_loss": [1.0, 1.0, 1.0],
    }
    case = CaseRecord(**{name: np.array(values) for name, values in series.items()})
    expected = {
        "mean_power": 6.0,
        "power_max": 9.0,
        "mean_thrust": 2.0,
        "mean_thrust_over_demand": 1.0,
        "corrected_mean_power": 6.0,
        "thrust_std": math.sqrt(2.0),
        "thrust_sensitivity_mean": 0.75,  # where thrust is asked for
        "thrust_sensitivity_std": 0.25,
        "shaft_speed_mean": 3.0,
        "shaft_speed_max": 6.0,
        "shaft_speed_std": math.sqrt(14.0 / 3.0),
        "pitch_ratio_mean": 0.6,
        "ventilated_share": 1.0 / 3.0,
        "thrust_loss_mean": 0.8,
        "thrust_loss_min": 0.5,
    }
    assert {kind: measure.of(case) for kind, measure in MEASURES.items()} == pytest.approx(expected, rel=1e-12)


def test_a_sweep_is_the_trial_with_another_thrust() -> None:
    trial = load_trial(TRIALS / "section_3_7.yaml")
    assert trial.sweep is not None
    variant = trial.sweep.variants[1]
    sweep = trial.sweep.model_copy(update={"window": (2.0, 4.0), "variants": (variant,)})
    short = trial.model_copy(
        update={"duration": 4.0, "windows": {"all": (2.0, 4.0)}, "close_up": None, "figures": (), "sweep": sweep}
    )
    times: list[float] = []
    outcome = work_out(short, times.append)
    direct = work_out(short.model_copy(update={"thrust": variant.thrust, "sweep": None}))
    powers = [row[0] for row in direct.table.values()]
    assert outcome.sweep[0].title == variant.title
    assert outcome.sweep[0].ratios == pytest.approx([power / powers[0] for power in powers], rel=1e-12)
    assert times == sorted(times)
    assert times[-1] == pytest.approx(8.0)
