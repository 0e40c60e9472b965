"""Reference generator, [Ruth] B.3.2."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from dp_controller.reference_generator import LONGEST_STEP, ReferenceGenerator
from dp_controller.second_order import transition
from dp_controller.vectors import ZERO, Triple
from support.controller_rig import VESSEL

FREQUENCY = 0.5
WIDE = (1e9, 1e9, 1e9)


def to(generator: ReferenceGenerator, target: Triple, dt: float) -> None:
    count = generator.steps_in(dt)
    for _ in range(count):
        generator.step(target, ZERO, target, ZERO, dt / count)


@pytest.mark.parametrize("damping", [0.2, 0.7, 0.999999, 1.0, 1.000001, 1.5, 4.0])
@pytest.mark.parametrize("dt", [1e-3, 0.2, 1.0, 7.0])
def test_transition_is_the_matrix_exponential(damping: float, dt: float) -> None:
    system = np.array([[0.0, 1.0], [-(FREQUENCY**2), -2.0 * damping * FREQUENCY]])
    expected = scipy.linalg.expm(system * dt)
    # expm is good to some ulp of 1; near damping 1 the poles differ by 1e-3, the quotient sinh(x)/x is exact to 1e-13.
    assert np.array(transition(FREQUENCY, damping, dt)).reshape(2, 2) == pytest.approx(expected, abs=1e-12)


def test_step_of_the_vessel_file_follows_the_closed_form() -> None:
    gains = VESSEL.controller.reference
    assert (gains.frequency, gains.damping, gains.velocity_max[0]) == (0.5, 1.0, 0.1)  # B.3.2
    generator = ReferenceGenerator(gains.frequency, gains.damping, gains.velocity_max)
    # 0.3 m asks for w / 2 * 0.3 = 0.075 m/s at most: below the limit all the way.
    time = 0.0
    for dt in [0.2] * 50 + [0.1, 0.37, 1.9, 0.01] * 5:
        to(generator, (0.3, -0.2, 0.1), dt)
        time += dt
        left = (1.0 + 0.5 * time) * math.exp(-0.5 * time)
        speed = 0.25 * time * math.exp(-0.5 * time)
        # Rounding of some hundred operations on numbers below 1.
        assert generator.position == pytest.approx((0.3 * (1 - left), -0.2 * (1 - left), 0.1 * (1 - left)), abs=1e-13)
        assert generator.velocity == pytest.approx((0.3 * speed, -0.2 * speed, 0.1 * speed), abs=1e-13)


def test_present_velocity_is_taken_over_and_decays_as_the_closed_form() -> None:
    generator = ReferenceGenerator(FREQUENCY, 1.0, WIDE)
    generator.reset((1.0, 0.0, 0.0), (0.08, 0.0, 0.0))
    for k in range(1, 50):
        to(generator, (1.0, 0.0, 0.0), 0.2)
        t = 0.2 * k
        assert generator.position[0] == pytest.approx(1.0 + 0.08 * t * math.exp(-0.5 * t), abs=1e-13)


def test_long_leg_is_sailed_straight_at_the_limit_without_overshoot() -> None:
    generator = ReferenceGenerator(FREQUENCY, 1.0, (0.1, 0.1, 0.1))
    fastest = 0.0
    for _ in range(1000):
        to(generator, (6.0, 3.0, 0.0), 0.2)
        north, east, _ = generator.position
        assert east == pytest.approx(0.5 * north, abs=1e-12)
        assert north <= 6.0
        assert max(abs(v) for v in generator.velocity) <= 0.1
        fastest = max(fastest, generator.velocity[0])
    assert fastest == pytest.approx(0.1, rel=1e-3)  # surge is at its limit, sway at half of it
    assert generator.position == pytest.approx((6.0, 3.0, 0.0), abs=1e-9)


def test_limits_hold_in_the_body_frame_of_the_reference_heading() -> None:
    # East is ahead here: the surge limit rules, not that of sway.
    generator = ReferenceGenerator(FREQUENCY, 1.0, (0.2, 0.01, 0.1))
    east = (0.0, 20.0, math.pi / 2)
    generator.reset((0.0, 0.0, math.pi / 2), ZERO)
    for _ in range(100):
        to(generator, east, 0.2)
    assert generator.velocity[1] == pytest.approx(0.2, rel=1e-3)
    assert generator.body_velocity()[1] == pytest.approx(0.0, abs=1e-12)


def test_a_lower_limit_holds_at_once() -> None:
    generator = ReferenceGenerator(FREQUENCY, 1.0, (0.1, 0.1, 0.1))
    for _ in range(50):
        to(generator, (6.0, 3.0, 2.0), 0.2)
    generator.velocity_max = (0.02, 0.02, 0.01)
    assert max(abs(v) for v in generator.body_velocity()[:2]) <= 0.02 + 1e-15  # one rounding
    assert abs(generator.velocity[2]) <= 0.01


def test_a_moving_target_within_limits_is_followed_exactly() -> None:
    generator = ReferenceGenerator(FREQUENCY, 1.0, (0.1, 0.1, 0.1))
    generator.reset(ZERO, (0.05, 0.0, 0.0))
    # A target that speeds up and slows down: once on it, the reference stays on it.
    for k in range(200):
        t0, t1 = 0.2 * k, 0.2 * (k + 1)

        def target(t: float) -> tuple[Triple, Triple]:
            return (0.05 * t, 0.02 * (1 - math.cos(t)), 0.0), (0.05, 0.02 * math.sin(t), 0.0)

        generator.step(*target(t0), *target(t1), 0.2)
        assert generator.position == pytest.approx(target(t1)[0], abs=1e-12)
        assert generator.velocity == pytest.approx(target(t1)[1], abs=1e-12)


positions = st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(-7, 7))
velocities = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1))
limits = st.tuples(st.floats(0.02, 1), st.floats(0.02, 1), st.floats(0.02, 1))


@settings(max_examples=60, deadline=None)
@given(
    start=positions,
    velocity=velocities,
    target=positions,
    limit=limits,
    damping=st.floats(0.4, 3.0),
    dt=st.floats(0.02, 0.99),
)
def test_limits_are_never_exceeded_and_the_target_is_reached(
    start: Triple, velocity: Triple, target: Triple, limit: Triple, damping: float, dt: float
) -> None:
    generator = ReferenceGenerator(FREQUENCY, damping, limit)
    generator.reset(start, velocity)
    slowest_pole = FREQUENCY * (damping - math.sqrt(max(damping**2 - 1.0, 0.0)))
    farthest = math.dist(start, target) + 2.0
    patience = 3.0 * farthest / min(limit) + 30.0 / (slowest_pole * min(1.0, damping))
    for _ in range(int(patience / dt) + 1):
        before = generator.position
        to(generator, target, dt)
        # One rounding in the scaling and one in the rotation.
        assert all(abs(v) <= m * (1 + 1e-12) for v, m in zip(generator.body_velocity(), limit, strict=True))
        moved = [b - a for a, b in zip(before, generator.position, strict=True)]
        # Positions of 30 m are known to 1e-14: what is moved in a step to 1e-12 of a metre a second.
        assert math.hypot(moved[0], moved[1]) <= dt * math.hypot(limit[0], limit[1]) + 1e-12
        assert abs(moved[2]) <= dt * limit[2] + 1e-12
        # At rest on the target, ten times nearer than is asked for below: from here on every step is the same.
        if math.dist(generator.position, target) < 1e-5 and max(map(abs, generator.velocity)) < 1e-9:
            break
    assert generator.position == pytest.approx(target, abs=1e-4)


@settings(max_examples=60, deadline=None)
@given(
    distance=st.floats(0.01, 50),
    limit=st.floats(0.01, 1),
    damping=st.floats(1.0, 3.0),
    dt=st.floats(0.02, LONGEST_STEP / FREQUENCY),
)
def test_no_overshoot_from_rest_when_damped(distance: float, limit: float, damping: float, dt: float) -> None:
    generator = ReferenceGenerator(FREQUENCY, damping, (limit, limit, limit))
    steps = int((distance / limit + 40.0 * damping) / dt)
    highest = 0.0
    for _ in range(min(steps, 20000)):
        to(generator, (distance, 0.0, 0.0), dt)
        highest = max(highest, generator.position[0])
    assert highest <= distance * (1 + 1e-12)


def test_long_steps_are_divided() -> None:
    generator = ReferenceGenerator(FREQUENCY, 1.0, WIDE)
    assert generator.steps_in(0.2) == 1
    assert generator.steps_in(1.0) == 1
    assert generator.steps_in(1.01) == 2
    assert generator.steps_in(10.0) == 10
