"""Wave filtering: the step against the frequency response of the design, and the choice of the hold."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest
from scipy.linalg import expm

from dp_observer import Observer, ObserverInputs, ObserverSettings
from dp_observer.model import ORDER, POSITION, VELOCITY, WAVE, ObserverModel
from marine_model import load_vessel
from marine_model.guards import FloatArray

VESSEL = load_vessel("cybership3")
SAMPLE = VESSEL.measurement.sample_time
HEAD_WAVES = 2 * math.pi / 0.8  # rad/s, Run A


def design(s: complex) -> tuple[complex, complex]:
    """Position and velocity estimate over measured position, in surge at heading zero, straight from (B.6)-(B.14)."""
    g = VESSEL.observer
    w0, lam, zeta = g.wave_frequency[0], g.wave_damping[0], g.notch_damping[0]
    wc = g.cutoff_ratio[0] * w0
    wave = 2 * (zeta - lam) * w0 * (s + wc) / (s**2 + 2 * lam * w0 * s + w0**2)
    bias = g.bias_gain[0] / (s + 1 / g.bias_time_constant[0])
    velocity = (g.velocity_gain[0] + bias) / (g.mass[0][0] * s + g.damping[0][0])
    position = (wc + velocity) / s
    error = 1 / (1 + wave + position)  # y~ / y
    return position * error, velocity * error


def sampled(frequency: float, which: int) -> complex:
    """Response of the design to samples joined by straight lines, seen at the samples.

    Straight lines carry a sampled sinusoid as a sum of sinusoids, each weighted with sinc^2; all of them alias to one.
    """
    total = 0j
    for k in range(-4000, 4001):  # terms fall with |k|^-3 and faster: what is left out is below 1e-7 of the sum
        w = frequency + k * 2 * math.pi / SAMPLE
        x = w * SAMPLE / 2
        total += design(1j * w)[which] * (math.sin(x) / x) ** 2
    return total


def measured_response(frequency: float) -> tuple[complex, complex]:
    """Position and velocity response of the real step, by correlation over whole periods once transients are gone."""
    observer = Observer(VESSEL, ObserverSettings(innovation_limit=1000.0))
    period = round(2 * math.pi / frequency / SAMPLE)
    assert period * SAMPLE * frequency == pytest.approx(2 * math.pi, rel=1e-12)
    settle = 500 * period  # at least 400 s: exp(-0.052 * 400) = 1e-9
    position = velocity = 0j
    count = 20 * period
    for k in range(settle + count):
        fix = np.array([math.sin(frequency * SAMPLE * k), 0.0, 0.0])
        estimate = observer.step(ObserverInputs(fix, np.zeros(3)), SAMPLE)
        if k >= settle:
            turn = cmath.exp(-1j * frequency * SAMPLE * k) * 2j / count
            position += estimate.position[0] * turn
            velocity += estimate.velocity[0] * turn
    return position, velocity


@pytest.mark.parametrize("samples", [4, 8, 40])  # periods of 0.8 s (Run A), 1.6 s and 8 s
def test_step_has_the_frequency_response_of_the_design(samples: int) -> None:
    frequency = 2 * math.pi / (samples * SAMPLE)
    position, velocity = measured_response(frequency)
    # The sum over images is good to 1e-7 and transients to 1e-9, of responses of order 1.
    assert position == pytest.approx(sampled(frequency, 0), abs=1e-6)
    assert velocity == pytest.approx(sampled(frequency, 1), abs=1e-6)


def test_head_waves_are_attenuated_at_least_as_the_design_says() -> None:
    """Speed of the wave motion that is left in the velocity estimate, over the true one, T = 0.8 s."""
    continuous = abs(design(1j * HEAD_WAVES)[1]) / HEAD_WAVES
    step = abs(measured_response(HEAD_WAVES)[1]) / HEAD_WAVES
    assert step == pytest.approx(abs(sampled(HEAD_WAVES, 1)) / HEAD_WAVES, rel=1e-5)
    assert step < continuous  # the lines between samples cut corners: sinc^2 = 0.81 at a quarter of the sampling rate
    assert step == pytest.approx(0.0220, abs=1e-4)  # the figure in docs/dp_observer.md


def test_slow_motion_passes() -> None:
    """A motion of the vessel of 100 s period is followed in position and velocity."""
    frequency = 2 * math.pi / 100.0
    position, velocity = design(1j * frequency)
    assert abs(position - 1) < 0.05
    assert abs(velocity / (1j * frequency) - 1) < 0.2


class Variant:
    """The same observer in its plainest form, with the hold to choose; heading zero."""

    def __init__(self, hold: str) -> None:
        model = ObserverModel(VESSEL.observer)
        model.set_heading(0.0)
        self.hold = hold
        big = np.zeros((ORDER + 6, ORDER + 6))
        big[:ORDER, :ORDER] = model.correction
        big[:ORDER, ORDER : ORDER + 3] = model.injection
        big[ORDER : ORDER + 3, ORDER + 3 :] = np.eye(3)
        self.step_matrix = expm(big * SAMPLE)
        self.state = np.zeros(ORDER)
        self.last = np.zeros(3)

    def step(self, fix: FloatArray) -> FloatArray:
        if self.hold == "straight line":
            start, slope = self.last, (fix - self.last) / SAMPLE
        elif self.hold == "old value":
            start, slope = self.last, np.zeros(3)
        else:
            start, slope = fix, np.zeros(3)
        self.last = fix
        self.state = (self.step_matrix @ np.concatenate([self.state, start, slope]))[:ORDER]
        return self.state


def errors(hold: str) -> tuple[float, float]:
    """Standard deviation of position (m) and velocity error (m/s) in head waves of 0.06 m, while surging slowly."""
    variant = Variant(hold)
    random = np.random.default_rng(1)
    found = []
    for k in range(3000):
        t = k * SAMPLE
        slow, speed = 0.1 * math.sin(0.1 * t), 0.01 * math.cos(0.1 * t)
        # The wave's phase drifts against the samples, as on any real run.
        wave = 0.06 * math.sin((HEAD_WAVES + 0.013) * t)
        noise = random.normal(0.0, VESSEL.measurement.position_noise)
        state = variant.step(np.array([slow + wave + noise, 0.0, 0.0]))
        if t > 200.0:
            found.append((state[POSITION][0] - slow, state[VELOCITY][0] - speed))
    deviation = np.std(found, axis=0)
    return float(deviation[0]), float(deviation[1])


def test_straight_lines_between_fixes_estimate_best() -> None:
    """Why the step joins fixes by straight lines: smaller errors than with either constant hold, in both estimates."""
    line, old, new = errors("straight line"), errors("old value"), errors("new value")
    assert line[0] < 0.95 * min(old[0], new[0])
    assert line[1] < 0.95 * min(old[1], new[1])
    # The figures in docs/dp_observer.md.
    figures = [round(1000 * x, 1) for x in (*line, *old, *new)]
    assert figures == pytest.approx([10.4, 7.4, 12.0, 8.0, 11.9, 8.0], abs=0.1)


def test_step_is_the_straight_line_variant() -> None:
    observer, variant = Observer(VESSEL, ObserverSettings()), Variant("straight line")
    for k in range(50):
        fix = np.array([0.06 * math.sin(HEAD_WAVES * SAMPLE * k), 0.0, 0.0])
        estimate = observer.step(ObserverInputs(fix, np.zeros(3)), SAMPLE)
        if k == 0:
            continue  # the first fix initialises; both start at zero
        state = variant.step(fix)
        np.testing.assert_allclose(estimate.position, state[POSITION], atol=1e-14)
        np.testing.assert_allclose(estimate.wave_frequency_position, state[WAVE], atol=1e-14)
