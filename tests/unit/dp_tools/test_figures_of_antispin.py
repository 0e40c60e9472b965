"""Figures for Runs C, D and E on signals whose answers are known: spectra, terms of the controller, torque losses."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError
from scipy.signal import welch

from dp_tools.figures import Figure, compute_figures
from dp_tools.figures.spectrum import SpectralEnergyRatio
from dp_tools.plot_specs.spectra import Spectra
from dp_tools.run_data import RunData, Series
from dp_tools.scenario import Scenario, load_scenario
from dp_tools.spectra import band_energies, spectrum
from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from support.repository import SCENARIOS
from support.synthetic_run import synthetic_run

STEP = 0.02  # s, 50 Hz
SAMPLE = 0.2
WINDOWS = {"first": [0.0, 60.0], "second": [60.0, 120.0], "third": [120.0, 180.0], "fourth": [180.0, 240.0]}
PORT = 2


@pytest.fixture(scope="module")
def vessel() -> Vessel:
    return load_vessel("cybership3")


@pytest.fixture(scope="module")
def run(vessel: Vessel) -> RunData:
    return synthetic_run(vessel, 240.0)


def measured(run: RunData, vessel: Vessel, *specs: dict[str, Any], events: tuple[dict[str, Any], ...] = ()) -> Any:
    named = [{"name": f"figure_{i}", "title": "T"} | spec for i, spec in enumerate(specs)]
    scenario = Scenario.model_validate(
        {
            "name": "trial",
            "title": "Trial",
            "description": "",
            "vessel": "cybership3",
            "duration": 240.0,
            "windows": WINDOWS,
            "events": list(events),
            "figures": named,
        }
    )
    return compute_figures(run, scenario, vessel)


def with_series(run: RunData, **series: Series) -> RunData:
    return dataclasses.replace(run, series={**run.series, **series})


def in_windows(t: NDArray[np.float64], *values: float) -> NDArray[np.float64]:
    """Return one value in each of the four windows."""
    return np.select([t < end - 5e-7 for _, end in WINDOWS.values()], values)


def sine(amplitude: float | NDArray[np.float64], frequency: float, count: int = 12000) -> Series:
    t = np.arange(count) * STEP
    return Series(t, (3.0 + amplitude * np.sin(2.0 * math.pi * frequency * t + 0.4))[:, None])


# Spectra -------------------------------------------------------------------------------------------------------------


@given(st.floats(0.01, 100.0), st.floats(1.0, 24.0))  # nearer to zero the mean that is taken off takes some along
@settings(max_examples=50, deadline=None)
def test_a_sine_in_the_middle_of_the_band_has_half_the_square_of_its_amplitude(
    amplitude: float, frequency: float
) -> None:
    energies = band_energies(sine(amplitude, frequency, 1500), frequency, 0.5)
    # Half a step (0.0625 Hz) off the grid the four frequencies in the band hold 0.9994 of it.
    assert energies == pytest.approx(0.5 * amplitude**2, rel=2e-3)


def test_a_sine_on_the_grid_of_frequencies_is_exact() -> None:
    """1.25 Hz is ten whole periods in a segment of 8 s: a Hann window puts all of it into three frequencies."""
    assert band_energies(sine(2.0, 1.25, 2000), 1.25, 0.5) == pytest.approx(2.0, rel=1e-9)
    # Far outside of the band there is nothing of it but the feet of the window: rounding.
    assert band_energies(sine(2.0, 1.25, 2000), 2.5, 0.5) == pytest.approx(0.0, abs=1e-9)


def test_their_mean_is_the_estimate_of_welch() -> None:
    rng = np.random.default_rng(1)
    series = Series(np.arange(3000) * STEP, rng.normal(size=(3000, 1)))
    frequencies, density = welch(series.values[:, 0], fs=50.0, nperseg=400, noverlap=300)
    inside = (frequencies >= 0.999) & (frequencies <= 1.501)
    assert band_energies(series, 1.25, 0.5).mean() == pytest.approx(float(density[inside].sum() * frequencies[1]))
    ours = spectrum(series, 8.0)
    assert ours[0] == pytest.approx(frequencies)
    assert ours[1] == pytest.approx(density)


def test_white_noise_has_its_share_of_the_band() -> None:
    """Variance 1 over 0 to 25 Hz: the frequencies from 1 to 1.5 Hz, in steps of 0.125 Hz, hold 5 * 0.125 / 25."""
    rng = np.random.default_rng(2)
    series = Series(np.arange(200000) * STEP, rng.normal(size=(200000, 1)))
    # 500 segments' worth of independent data, five bins each: 2 % scatter; three times that.
    assert band_energies(series, 1.25, 0.5).mean() == pytest.approx(0.025, rel=0.06)


def test_what_a_band_needs() -> None:
    with pytest.raises(InputError, match=r"window: expected at least 400 samples for a band of 0.5 Hz, found 399"):
        band_energies(sine(1.0, 1.25, 399), 1.25, 0.5)
    with pytest.raises(InputError, match=r"band: expected it between 0 and 25 Hz, found 24.9 Hz \+- 0.25 Hz"):
        band_energies(sine(1.0, 1.25), 24.9, 0.5)
    with pytest.raises(InputError, match=r"band: expected it between 0 and 25 Hz, found 0.1 Hz"):
        band_energies(sine(1.0, 1.25), 0.1, 0.5)
    with pytest.raises(InputError, match="window: expected at least 2 samples, found 1"):
        spectrum(sine(1.0, 1.25, 1), 8.0)
    gap = sine(1.0, 1.25)
    gap.values[7] = math.nan
    with pytest.raises(InputError, match="signal: expected finite numbers"):
        band_energies(gap, 1.25, 0.5)


def test_energy_at_the_wave_frequency_by_window(run: RunData, vessel: Vessel) -> None:
    t = np.arange(12000) * STEP
    loud = in_windows(t, 2.0, 0.4, 2.0, 0.4)
    torque = sine(loud, 1.25).values * np.eye(4)[PORT]
    power = sine(loud, 1.25).values * np.array([1.0, 1.0, 0.0, 0.0])  # amplitudes add up to 4.0, 0.8
    data = with_series(run, motor_torque=Series(t, torque), power=Series(t, power))
    band = {"frequency": 1.25, "bandwidth": 0.5}
    of_power = {"signal": "total_power"} | band
    of_torque = {"signal": "motor_torque", "thruster": "azimuth_port"} | band
    sides = {"baseline": ["first", "third"], "compared": ["second", "fourth"]}
    figures: tuple[Figure, ...] = measured(
        data,
        vessel,
        {"kind": "spectral_energy", "window": "first"} | of_power,
        {"kind": "spectral_energy", "window": "second"} | of_torque,
        {"kind": "spectral_energy_ratio", "baseline": "first", "compared": "second"} | of_power,
        {"kind": "spectral_energy_ratio"} | sides | of_torque,
    )
    # 60 s are 75 whole periods, so every segment is the same sine.
    assert [figure.value for figure in figures] == pytest.approx([8.0, 0.08, 0.04, 0.04])
    assert [figure.unit for figure in figures] == ["W^2", "N^2 m^2", "1", "1"]
    assert figures[2].low == pytest.approx(0.04)
    assert figures[2].high == pytest.approx(0.04)


def test_a_thruster_belongs_to_the_torque_only(run: RunData, vessel: Vessel) -> None:
    base = {"kind": "spectral_energy", "window": "first", "frequency": 1.25, "bandwidth": 0.5}
    for wrong in ({"signal": "motor_torque"}, {"signal": "total_power", "thruster": "azimuth_port"}):
        with pytest.raises(ValidationError, match="thruster: expected one with motor_torque only"):
            measured(run, vessel, base | wrong)


# Power, thrust, force, position: one side against the other ----------------------------------------------------------


def test_windows_of_a_side_count_together(run: RunData, vessel: Vessel) -> None:
    t = np.arange(12000) * STEP
    power = in_windows(t, 4.0, 3.0, 6.0, 1.0)[:, None] * np.array([1.0, 0.0, 0.0, 0.0])
    sides = {"baseline": ["first", "third"], "compared": ["second", "fourth"]}
    mean, std, single = measured(
        with_series(run, power=Series(t, power)),
        vessel,
        {"kind": "mean_power_change"} | sides,
        {"kind": "power_std_change"} | sides,
        {"kind": "mean_power_change", "baseline": "first", "compared": "second"},
    )
    assert mean.value == pytest.approx(2.0 / 5.0 - 1.0)
    assert std.value == pytest.approx(0.0)  # 3 and 1 scatter about 2 as 4 and 6 about 5
    assert single.value == pytest.approx(-0.25)


def test_a_manoeuvre_has_no_interval_from_one_run(run: RunData, vessel: Vessel) -> None:
    power = {"kind": "mean_power", "window": "first"}
    steady, transient = measured(run, vessel, power, power | {"transient": True})
    assert transient.value == steady.value
    assert steady.low is not None
    assert (transient.low, transient.high) == (None, None)


def test_every_window_of_a_side_must_be_there() -> None:
    spec = {"name": "x", "kind": "mean_power_change", "title": "X", "baseline": ["a", "b"], "compared": "c"}
    scenario = Scenario.model_validate(
        {"name": "t", "title": "T", "description": "", "vessel": "cybership3", "duration": 1.0, "figures": [spec]}
    )
    assert scenario.figures[0].windows() == (("baseline", "a"), ("baseline", "b"), ("compared", "c"))
    with pytest.raises(ValidationError):
        Scenario.model_validate(scenario.model_dump() | {"figures": [spec | {"baseline": []}]})


def test_force_and_position_error_of_one_side_against_the_other(run: RunData, vessel: Vessel) -> None:
    t = np.arange(1200) * SAMPLE
    zero = np.zeros_like(t)
    surge = in_windows(t, -4.0, -3.0, -4.0, -3.0)
    north = in_windows(t, 0.1, 0.05, 0.1, 0.05) * np.where(np.arange(1200) % 2, 1.0, -1.0)
    data = with_series(
        run,
        tau_desired=Series(t, np.column_stack([surge, zero, zero])),
        estimate_position=Series(t, np.column_stack([north, zero, zero])),
        reference_position=Series(t, np.zeros((1200, 3))),
    )
    sides = {"baseline": "first", "compared": "second"}
    force, error = measured(
        data,
        vessel,
        {"kind": "force_level_change", "force": "tau_desired", "axis": "surge"} | sides,
        {"kind": "position_error_change", "axis": "north", "statistic": "rms"} | sides,
    )
    assert force.value == pytest.approx(-0.25)
    assert error.value == pytest.approx(-0.5)


def test_largest_error_counts_from_the_newest_event(run: RunData, vessel: Vessel) -> None:
    t = np.arange(1200) * SAMPLE
    north = np.where(np.isclose(t, 73.0), -0.3, np.where(np.isclose(t, 20.0), 0.2, 0.0))
    data = with_series(
        run,
        estimate_position=Series(t, np.column_stack([north, 0.0 * t, 0.0 * t])),
        reference_position=Series(t, np.zeros((1200, 3))),
    )
    spec = {"kind": "largest_error_delay", "axis": "north", "window": "second"}
    events = tuple({"at": at, "setpoint": [0.0, 0.0, 0.0]} for at in (10.0, 70.0, 100.0))
    (figure,) = measured(data, vessel, spec, events=events)
    assert (figure.value, figure.unit) == (pytest.approx(3.0), "s")
    (none,) = measured(data, vessel, spec, events=events[2:])
    assert none.value is None


def test_torque_loss_is_what_the_drivers_remember(run: RunData, vessel: Vessel) -> None:
    t = np.arange(12000) * STEP
    losses = 1.0 - in_windows(t, 0.5, 0.2, 0.5, 0.2)[:, None] * np.eye(4)[PORT]
    port = {"thruster": "azimuth_port"}
    level, change, other = measured(
        with_series(run, beta_q2=Series(t, losses)),
        vessel,
        {"kind": "torque_loss_level", "window": "first"} | port,
        {"kind": "torque_loss_change", "baseline": "first", "compared": "second"} | port,
        {"kind": "torque_loss_level", "window": "first", "thruster": "azimuth_bow"},
    )
    assert level.value == pytest.approx(0.5)
    assert change.value == pytest.approx(0.8 / 0.5 - 1.0)
    assert other.value == 1.0


# Terms of the controller ---------------------------------------------------------------------------------------------


def excursion(run: RunData, *integral_crossings: float) -> RunData:
    """In each window: proportional below zero, above from 20 s to 40 s; integral below zero until its crossing."""
    t = np.arange(1200) * SAMPLE
    since = t % 60.0
    proportional = np.where((since > 20.0 - 1e-6) & (since < 40.0), 3.0, -1.0)
    crossing = in_windows(t, *integral_crossings)
    integral = np.where(since > crossing - 1e-6, 2.0, -4.0)
    zero = np.zeros_like(t)
    return with_series(
        run,
        proportional=Series(t, np.column_stack([proportional, zero, zero])),
        integral=Series(t, np.column_stack([integral, zero, zero])),
    )


def test_when_terms_change_sign(run: RunData, vessel: Vessel) -> None:
    data = excursion(run, 32.0, 25.0, 10.0, 99.0)
    sign = {"kind": "sign_change", "axis": "surge", "term": "integral"}
    shift = {"kind": "sign_change_shift", "axis": "surge", "term": "integral"}
    figures = measured(
        data,
        vessel,
        *(sign | {"window": window} for window in WINDOWS),
        shift | {"baseline": "first", "compared": "second"},
        shift | {"baseline": ["first", "third"], "compared": "second"},
        shift | {"baseline": "first", "compared": "fourth"},
        sign | {"term": "proportional", "window": "second"},
        shift | {"term": "proportional", "baseline": "first", "compared": "second"},
    )
    values = [figure.value for figure in figures]
    assert values[:3] == pytest.approx([32.0, 25.0, 10.0])
    assert values[3] is None
    assert values[4:6] == pytest.approx([-7.0, 4.0])
    assert values[6] is None
    assert values[7:] == pytest.approx([20.0, 0.0])
    assert {figure.unit for figure in figures} == {"s"}


def test_levels_of_a_term(run: RunData, vessel: Vessel) -> None:
    data = excursion(run, 30.0, 45.0, 0.0, 60.0)
    term = {"kind": "control_term_level", "term": "integral", "axis": "surge"}
    change = {"kind": "control_term_change", "term": "integral", "axis": "surge"}
    largest, rms, of_rms, of_largest = measured(
        data,
        vessel,
        term | {"window": "first", "statistic": "max"},
        term | {"window": "first", "statistic": "rms"},
        change | {"baseline": "first", "compared": "third", "statistic": "rms"},
        change | {"baseline": ["first", "third"], "compared": "third", "statistic": "max"},
    )
    assert (largest.value, largest.unit) == (4.0, "N")
    assert rms.value == pytest.approx(math.sqrt(0.5 * (16.0 + 4.0)))
    assert of_rms.value == pytest.approx(2.0 / math.sqrt(10.0) - 1.0)
    assert of_largest.value == pytest.approx(2.0 / 3.0 - 1.0)  # mean of 4 and 2


def test_a_band_goes_with_the_scale_of_the_vessel() -> None:
    """1:30 to 1:1: times by sqrt(30), so that the waves of Run D stay in the middle of the band and of its picture."""
    full = load_scenario(SCENARIOS / "run_d.yaml", load_vessel("cybership3_full_scale"))
    (ratio,) = (figure for figure in full.figures if figure.name == "energy_power")
    assert isinstance(ratio, SpectralEnergyRatio)
    # The clock of the full scale is 5e-9 slow: its time step is whole nanoseconds.
    assert (ratio.frequency, ratio.bandwidth) == pytest.approx((1.25 / math.sqrt(30.0), 0.25 / math.sqrt(30.0)))
    picture = next(plot for plot in full.plots if isinstance(plot, Spectra))
    assert picture.segment == pytest.approx(16.0 * math.sqrt(30.0))
    assert (picture.up_to, *picture.marked) == pytest.approx(tuple(f / math.sqrt(30.0) for f in (5.0, 1.25, 2.5)))
