"""Fixed or rotating by the filtered demand: [Ruth] (6.3)-(6.5), Table 6.3."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.gains import FixedRotatingGains
from thrust_allocator.mode_supervisor import AzimuthMode, ModeState, next_mode

SHIPPED = load_vessel("cybership3").allocator.fixed_rotating
assert SHIPPED is not None
GAINS = SHIPPED
AUTO, FIXED, VARIABLE = AzimuthMode.AUTO, AzimuthMode.FIXED, AzimuthMode.VARIABLE
DT = 0.2

forces = st.floats(-20.0, 20.0)


def run(state: ModeState, mode: AzimuthMode, force: float, steps: int, gains: FixedRotatingGains = GAINS) -> ModeState:
    for _ in range(steps):
        state = next_mode(state, mode, gains, force, 0.0, DT)
    return state


def test_it_begins_fixed() -> None:
    assert ModeState().rotating is False


@given(forces, forces, st.floats(0.0, 20.0), st.floats(0.001, 10.0), st.integers(1, 20))
def test_the_filter_is_exact_for_any_step(surge: float, sway: float, start: float, dt: float, parts: int) -> None:
    size = math.hypot(surge, sway)
    expected = size + (start - size) * math.exp(-GAINS.filter_frequency * dt)
    state = ModeState(mean_force=start)
    for _ in range(parts):
        state = next_mode(state, AUTO, GAINS, surge, sway, dt / parts)
    assert state.mean_force == pytest.approx(expected, abs=1e-12)  # 20 roundings of numbers up to 30


def test_a_step_of_the_demand_switches_when_the_closed_form_says() -> None:
    # 1 - exp(-omega t) times 4 N passes 1.7 N at t = -ln(1 - 1.7 / 4) / 0.2.
    passes = -math.log1p(-1.7 / 4.0) / GAINS.filter_frequency
    steps = math.ceil(passes / DT)
    assert not run(ModeState(), AUTO, 4.0, steps - 1).rotating
    assert run(ModeState(), AUTO, 4.0, steps) == ModeState(True, pytest.approx(1.7, abs=0.1), 0.0)


@pytest.mark.parametrize(
    ("rotating", "mean", "expected"),
    [
        (False, 1.69, False),
        (False, 1.71, True),
        (True, 1.31, True),
        (True, 1.29, False),
        (False, 1.29, False),
        (True, 1.71, True),
    ],
)
def test_hysteresis(rotating: bool, mean: float, expected: bool) -> None:
    state = next_mode(ModeState(rotating, mean), AUTO, GAINS, mean, 0.0, DT)
    assert state.rotating is expected
    assert state.since_switch == (math.inf if rotating == expected else 0.0)


@pytest.mark.parametrize(("dt", "samples"), [(0.2, 25), (0.1, 50), (0.05, 100)])  # the last two add up to less than 5
def test_dwell_in_samples(dt: float, samples: int) -> None:
    state = next_mode(ModeState(False, 3.0), AUTO, GAINS, 3.0, 0.0, dt)
    assert state.rotating
    for _ in range(samples - 1):
        state = next_mode(state._replace(mean_force=0.5), AUTO, GAINS, 0.5, 0.0, dt)
        assert state.rotating
    assert next_mode(state._replace(mean_force=0.5), AUTO, GAINS, 0.5, 0.0, dt) == ModeState(False, 0.5, 0.0)


def test_direction_of_the_demand_does_not_matter() -> None:
    for surge, sway in ((3.0, 4.0), (-3.0, 4.0), (0.0, -5.0), (5.0, 0.0)):
        assert next_mode(ModeState(), AUTO, GAINS, surge, sway, 1e9).mean_force == pytest.approx(5.0)


def test_waves_of_run_g_come_through_with_2_5_percent() -> None:
    """Waves of 0.8 s, mean 2 N, amplitude 1 N: the reason written beside the filter frequency."""
    state, dt = ModeState(mean_force=2.0), 0.01
    found = []
    for k in range(8000):
        state = next_mode(state, AUTO, GAINS, 2.0 + math.sin(2.0 * math.pi * k * dt / 0.8), 0.0, dt)
        found.append(state.mean_force)
    last = found[-800:]
    assert 0.5 * (max(last) - min(last)) == pytest.approx(0.2 / math.hypot(0.2, 2.0 * math.pi / 0.8), rel=0.02)
    assert state.rotating


@pytest.mark.parametrize("mode", [FIXED, VARIABLE])
def test_the_operator_decides_at_once_and_the_filter_goes_on(mode: AzimuthMode) -> None:
    wanted = mode is VARIABLE
    state = run(ModeState(not wanted, 1.5, 0.0), mode, 1.5, 1)
    assert state == ModeState(wanted, pytest.approx(1.5), 0.0)
    state = run(state, mode, 4.0, 100)
    assert state.rotating is wanted
    assert state.mean_force == pytest.approx(4.0 - 2.5 * math.exp(-0.2 * 20.0))
    assert state.since_switch == pytest.approx(20.0)


def test_auto_after_the_operator_keeps_what_there_is() -> None:
    state = run(run(ModeState(), VARIABLE, 1.5, 100), AUTO, 1.5, 100)
    assert state.rotating  # 1.5 N is within the hysteresis
    assert state.since_switch > 20.0
    # A change by the operator begins the dwell time.
    state = run(run(ModeState(False, 0.2), VARIABLE, 0.2, 1), AUTO, 0.2, 24)
    assert state.rotating
    assert not run(state, AUTO, 0.2, 1).rotating


@given(
    st.lists(st.tuples(st.floats(0.0, 6.0), st.integers(1, 60)), min_size=1, max_size=8), st.sampled_from([0.1, 0.2])
)
def test_no_two_switches_within_the_dwell_time(demand: list[tuple[float, int]], dt: float) -> None:
    quick = GAINS.model_copy(update={"filter_frequency": 5.0})  # so that the dwell time has something to hold back
    state, switches, now = ModeState(), [], 0.0
    for force, steps in demand:
        for _ in range(steps):
            now += dt
            after = next_mode(state, AUTO, quick, force, 0.0, dt)
            if after.rotating != state.rotating:
                switches.append(now)
            state = after
    assert all(later - earlier >= quick.dwell_time - 1e-9 for earlier, later in itertools.pairwise(switches))


@pytest.mark.parametrize(
    ("word", "mode"), [("fixed", FIXED), ("variable", VARIABLE), ("rotating", VARIABLE), ("auto", AUTO)]
)
def test_words(word: str, mode: AzimuthMode) -> None:
    assert AzimuthMode.parse(word) is mode


def test_other_words_are_refused() -> None:
    message = r"azimuth_mode: expected fixed, variable \(or rotating\) or auto, found 'Auto'"
    with pytest.raises(InputError, match=message):
        AzimuthMode.parse("Auto")


def test_auto_needs_its_numbers() -> None:
    with pytest.raises(InputError, match=r"auto needs allocator\.fixed_rotating in the vessel file"):
        next_mode(ModeState(), AUTO, None, 1.0, 0.0, DT)
    assert next_mode(ModeState(), VARIABLE, None, 1.0, 0.0, DT) == ModeState(True, 0.0, 0.0)


@pytest.mark.parametrize(
    ("surge", "sway", "dt", "message"),
    [
        (math.nan, 0.0, DT, "demand: expected finite forces, found nan and 0.0"),
        (0.0, math.inf, DT, "demand: expected finite forces, found 0.0 and inf"),
        (0.0, 0.0, 0.0, "dt: expected a number above 0, found 0.0"),
        (0.0, 0.0, math.nan, "dt: expected a finite number, found nan"),
    ],
)
def test_what_is_not_a_number_is_refused(surge: float, sway: float, dt: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        next_mode(ModeState(), AUTO, GAINS, surge, sway, dt)
