"""How far the attainable set reaches: against linear and second-order cone programs, and by its own properties."""

from __future__ import annotations

import math

import clarabel
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.optimize import linprog

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.thruster_configuration import generalized_force
from thrust_allocator.attainable import ForceSet, ThrustMargin, force_set, scale_to_boundary
from thrust_allocator.attainable.boundary import turning_reach, zonotope_reach
from thrust_allocator.attainable.margin import reach

VESSELS = [load_vessel("cybership3"), load_vessel("cybership3_ch7")]
VESSEL = VESSELS[0]
N = 4
angles = st.lists(st.floats(-math.pi, math.pi), min_size=N, max_size=N).map(np.array)
masks = st.lists(st.booleans(), min_size=N, max_size=N)
forces_3 = (
    st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=3).map(np.array).filter(lambda d: np.abs(d).max() > 1e-3)
)
# Machine code is compiled within the first example.
slow_start = settings(deadline=None, max_examples=200)


def by_linear_program(generators: FloatArray, lower: FloatArray, upper: FloatArray, direction: FloatArray) -> float:
    k = len(generators)
    answer = linprog(
        np.append(np.zeros(k), -1.0),
        A_eq=np.column_stack([generators.T, -direction]),
        b_eq=np.zeros(3),
        bounds=[*zip(lower, upper, strict=True), (0.0, None)],
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    assert answer.status == 0
    return float(answer.x[-1])


def by_cone_program(forces: ForceSet, direction: FloatArray) -> float:
    n = len(forces.upper)
    rows, right, cones = [np.column_stack([forces.first.T, forces.second.T, -direction])], [np.zeros(3)], []
    cones.append(clarabel.ZeroConeT(3))
    unit = np.eye(2 * n + 1)
    for j in range(n):
        if forces.turns[j]:
            rows.append(-np.vstack([np.zeros(2 * n + 1), unit[j], unit[n + j]]))
            right.append(np.array([forces.upper[j], 0.0, 0.0]))
            cones.append(clarabel.SecondOrderConeT(3))
        else:
            rows.append(np.vstack([unit[j], -unit[j], unit[n + j], -unit[n + j]]))
            right.append(np.array([forces.upper[j], -forces.lower[j], 0.0, 0.0]))
            cones.append(clarabel.NonnegativeConeT(4))
    options = clarabel.DefaultSettings()
    options.verbose = False
    options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = 1e-11  # or as near as it gets: almost solved
    cost = np.append(np.zeros(2 * n), -1.0)
    nothing = sparse.csc_matrix((2 * n + 1, 2 * n + 1))
    matrix = sparse.csc_matrix(np.vstack(rows))
    answer = clarabel.DefaultSolver(nothing, cost, matrix, np.concatenate(right), cones, options).solve()
    assert str(answer.status) in ("Solved", "AlmostSolved")
    return float(answer.x[-1])


def random_direction(random: np.random.Generator, generators: FloatArray) -> FloatArray:
    """Anything, along the axes, or something that the generators give."""
    kind = random.integers(3)
    if kind == 0:
        return random.normal(size=3)
    if kind == 1:
        direction = random.integers(-1, 2, 3).astype(float)
        return direction if direction.any() else np.array([0.0, 0.0, 1.0])
    return random.normal(size=len(generators)) @ generators


@pytest.mark.parametrize("kind", ["anything", "right angles", "whole numbers", "flat"])
def test_zonotope_against_linear_programs(kind: str) -> None:
    random = np.random.default_rng(7)
    for _ in range(300):
        k = int(random.integers(1, 9))
        generators = random.normal(size=(k, 3))
        if kind == "right angles":
            angle, (x, y) = random.integers(0, 8, k) * np.pi / 4, random.integers(-2, 3, (2, k)) / 2
            generators = np.column_stack([np.cos(angle), np.sin(angle), x * np.sin(angle) - y * np.cos(angle)])
        elif kind == "whole numbers":
            generators = random.integers(-1, 2, (k, 3)).astype(float)
        elif kind == "flat":
            generators[:, 0] = 0.0
        # Some thrusters give nothing, some cannot reverse.
        upper = random.uniform(0.0, 5.0, k) * (random.random(k) < 0.9)
        lower = -random.uniform(0.0, 5.0, k) * (random.random(k) < 0.6)
        direction = random_direction(random, generators)
        if not direction.any():
            continue
        found = zonotope_reach(generators, lower, upper, direction)
        expected = by_linear_program(generators, lower, upper, direction)
        # Forces are of size 10; HiGHS is asked for 1e-10.
        assert found * np.linalg.norm(direction) == pytest.approx(expected * np.linalg.norm(direction), abs=1e-8)


@pytest.mark.parametrize("one_way", [False, True])
@pytest.mark.parametrize("kind", ["anywhere", "right angles"])
def test_turning_thrusters_against_cone_programs(kind: str, one_way: bool) -> None:
    random = np.random.default_rng(11)
    for _ in range(250):
        n = int(random.integers(1, 7))
        x, y = random.normal(size=(2, n)) if kind == "anywhere" else random.integers(-2, 3, (2, n)) / 2
        angle = random.uniform(-4.0, 4.0, n) if kind == "anywhere" else random.integers(0, 8, n) * np.pi / 4
        turns = random.random(n) < 0.6
        turns[0] = True
        ones, none = np.ones(n), np.zeros(n)
        polar = np.column_stack([np.cos(angle), np.sin(angle), x * np.sin(angle) - y * np.cos(angle)])
        first = np.where(turns[:, None], np.column_stack([ones, none, -y]), polar)
        second = np.where(turns[:, None], np.column_stack([none, ones, x]), 0.0)
        upper = random.uniform(0.0, 5.0, n) * (random.random(n) < 0.9) * 10.0 ** random.uniform(-3.0, 0.0, n)
        upper[0] += 1.0
        lower = -random.uniform(0.0, 5.0, n) * (random.random(n) < (0.6 if one_way else 2.0))
        direction = random_direction(random, first)
        if not direction.any():
            continue
        found, _ = turning_reach(first, second, lower, upper, turns.astype(float), direction)
        expected = by_cone_program(ForceSet(first, second, lower, upper, turns, 1.0), direction)
        # What Clarabel gets to where a thruster is a thousandth of the others.
        assert found * np.linalg.norm(direction) == pytest.approx(expected * np.linalg.norm(direction), abs=2e-7)


@slow_start
@given(direction=forces_3, enabled=masks.filter(any))
def test_turning_reach_is_proved_by_its_normal(direction: FloatArray, enabled: list[bool]) -> None:
    """h(n) with n'direction = 1 is an upper bound whoever found n, and the answer is that bound."""
    forces = force_set(VESSEL, enabled=enabled)
    scale, normal = reach(forces, direction)
    if scale > 0.0 and forces.turns[enabled].any():
        # Moments and forces differ by a lever arm of about 1 m; sums of a few tens of newtons.
        assert normal @ direction == pytest.approx(1.0, abs=1e-9)
        assert float(forces.support(normal)) == pytest.approx(scale, rel=1e-9)


def test_pure_thrust_of_a_single_azimuth_thruster_is_its_limit() -> None:
    enabled = [False, True, False, False]
    for angle in np.linspace(-3.0, 3.0, 13):
        force = generalized_force(VESSEL.lever_x, VESSEL.lever_y, np.array([0, 1.0, 0, 0]), np.full(4, angle))
        assert scale_to_boundary(VESSEL, None, force, enabled=enabled) == pytest.approx(8.7, rel=1e-11)
        assert scale_to_boundary(VESSEL, [0, angle, 0, 0], force, enabled=enabled) == pytest.approx(8.7, rel=1e-11)
        assert scale_to_boundary(VESSEL, [0, angle, 0, 0], -force, enabled=enabled) == pytest.approx(4.7, rel=1e-11)
        assert scale_to_boundary(VESSEL, None, force + np.array([0.0, 0.0, 0.01]), enabled=enabled) == 0.0


def test_surge_when_all_point_ahead() -> None:
    """Moments must balance: 13 N of each aft thruster, and all of the bow azimuth, which gives no moment."""
    assert scale_to_boundary(VESSEL, np.zeros(N), [1.0, 0.0, 0.0]) == pytest.approx(8.7 + 2.0 * 13.0, rel=1e-12)
    # When they turn, the bow may make up for the moment of port's last 0.5 N.
    turning = scale_to_boundary(VESSEL, None, [1.0, 0.0, 0.0])
    assert 8.7 + 2.0 * 13.0 < turning < 8.7 + 13.5 + 13.0


def test_no_thruster_at_all_and_dead_directions() -> None:
    assert scale_to_boundary(VESSEL, None, [1.0, 0.0, 0.0], enabled=[False] * N) == 0.0
    assert scale_to_boundary(VESSEL, None, [1.0, 0.0, 0.0], thrust_limit_scale=[0.0] * N) == 0.0
    assert scale_to_boundary(VESSEL, [0.0] * N, [1.0, 0.0, 0.0], enabled=[False] * N) == 0.0
    # All athwartships give no surge, although cos(pi / 2) is not quite zero.
    assert scale_to_boundary(VESSEL, np.full(N, np.pi / 2), [1.0, 0.0, 0.0]) == 0.0
    assert scale_to_boundary(VESSEL, np.full(N, np.pi / 2), [0.0, 1.0, 0.0]) > 1.0
    assert scale_to_boundary(VESSEL, None, [1.0, 0.0, 0.0], enabled=[True, False, False, False]) == 0.0


@pytest.mark.parametrize("azimuth", [None, [0.0] * N])
@pytest.mark.parametrize(
    ("direction", "message"),
    [
        ([0.0, 0.0, 0.0], "direction: expected a generalized force other than zero"),
        ([1.0, 0.0], r"direction: expected shape \(3,\), found \(2,\)"),
        ([1.0, np.nan, 0.0], "direction: expected finite numbers"),
        ([np.inf, 0.0, 0.0], "direction: expected finite numbers"),
        ("ahead", "direction: expected 3 numbers"),
    ],
)
def test_bad_directions_are_refused(azimuth: list[float] | None, direction: list[float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        scale_to_boundary(VESSEL, azimuth, direction)


def test_bad_states_are_refused() -> None:
    ahead = [1.0, 0.0, 0.0]
    with pytest.raises(InputError, match=r"azimuth: expected shape \(4,\), found \(3,\)"):
        scale_to_boundary(VESSEL, [0.0] * 3, ahead)
    with pytest.raises(InputError, match="azimuth: expected finite numbers"):
        scale_to_boundary(VESSEL, [0.0, np.nan, 0.0, 0.0], ahead)
    with pytest.raises(InputError, match="enabled: expected 4 bools"):
        scale_to_boundary(VESSEL, None, ahead, enabled=[True] * 3)
    with pytest.raises(InputError, match="enabled: expected 4 bools"):
        scale_to_boundary(VESSEL, None, ahead, enabled=[1, 1, 0, 1])  # type: ignore[list-item]
    with pytest.raises(InputError, match="thrust_limit_scale: expected numbers from 0 to 1"):
        scale_to_boundary(VESSEL, None, ahead, thrust_limit_scale=[1.0, 1.0, 1.0, 1.5])
    with pytest.raises(InputError, match=r"thrust_limit_scale: expected shape \(4,\)"):
        ThrustMargin(VESSEL, thrust_limit_scale=[1.0])


@slow_start
@given(azimuth=angles, direction=forces_3, enabled=masks)
def test_given_angles_are_within_what_turning_gives(
    azimuth: FloatArray, direction: FloatArray, enabled: list[bool]
) -> None:
    fixed = scale_to_boundary(VESSEL, azimuth, direction, enabled=enabled)
    turning = scale_to_boundary(VESSEL, None, direction, enabled=enabled)
    assert fixed <= turning * (1.0 + 1e-9) + 1e-9


@slow_start
@given(azimuth=angles, direction=forces_3)
def test_the_boundary_is_attainable_and_what_lies_beyond_is_not(azimuth: FloatArray, direction: FloatArray) -> None:
    # Steps of 0.1 rad: a set thinner than what HiGHS takes for feasible (1e-7) has no outside for it.
    azimuth = np.round(azimuth, 1)
    forces = force_set(VESSEL, azimuth)
    edge = scale_to_boundary(VESSEL, azimuth, direction) * direction
    for factor, attainable in ((1.0, True), (1.001, False)):
        answer = linprog(
            np.zeros(N),
            A_eq=forces.first.T,
            b_eq=factor * edge,
            bounds=list(zip(VESSEL.thrust_min, VESSEL.thrust_max, strict=True)),
        )
        if np.linalg.norm(edge) > 0.1:
            assert (answer.status == 0) is attainable


@slow_start
@given(azimuth=angles, direction=forces_3, factor=st.floats(1e-6, 1e6))
def test_scaling_of_the_direction(azimuth: FloatArray, direction: FloatArray, factor: float) -> None:
    for angle in (azimuth, None):
        here = scale_to_boundary(VESSEL, angle, direction)
        there = scale_to_boundary(VESSEL, angle, factor * direction)
        # Both within 1e-11 of the whole thrust of 36 N; directions are longer than 1e-3 N.
        assert factor * there == pytest.approx(here, rel=1e-9, abs=1e-6)


@slow_start
@given(azimuth=angles, direction=forces_3, fraction=st.floats(0.01, 1.0))
def test_scaling_of_the_limits(azimuth: FloatArray, direction: FloatArray, fraction: float) -> None:
    for angle in (azimuth, None):
        whole = scale_to_boundary(VESSEL, angle, direction)
        part = scale_to_boundary(VESSEL, angle, direction, thrust_limit_scale=[fraction] * N)
        assert part == pytest.approx(fraction * whole, rel=1e-9, abs=1e-6)


def mirrored(vessel: Vessel) -> Vessel:
    document = vessel.model_dump()
    for thruster in document["thrusters"]:
        x, y, z = thruster["position"]
        thruster["position"] = (x, -y, z)
        if thruster["type"] == "tunnel":
            thruster["direction"] *= -1.0
    return Vessel.model_validate(document)


@slow_start
@given(azimuth=angles, direction=forces_3, enabled=masks)
def test_port_and_starboard_mirror(azimuth: FloatArray, direction: FloatArray, enabled: list[bool]) -> None:
    other = mirrored(VESSEL)
    flip = np.array([1.0, -1.0, -1.0])
    for here, there in ((azimuth, -azimuth), (None, None)):
        one = scale_to_boundary(VESSEL, here, direction, enabled=enabled)
        two = scale_to_boundary(other, there, flip * direction, enabled=enabled)
        assert one == pytest.approx(two, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("vessel", VESSELS, ids=lambda vessel: vessel.name)
def test_every_small_force_is_attainable(vessel: Vessel) -> None:
    """[Ruth] Theorem 7.3 with limits as wide both ways, and Lemma 7.2 without the factor that is not needed."""
    random = np.random.default_rng(3)
    document = vessel.model_dump()
    for thruster in document["thrusters"]:
        thruster["thrust"]["min"] = -thruster["thrust"]["max"]
    even = Vessel.model_validate(document)
    length, thrust = np.hypot(vessel.lever_x, vessel.lever_y).mean(), vessel.thrust_max.mean()
    torque_scale = np.array([1.0, 1.0, 1.0 / length])
    for _ in range(40):
        azimuth = random.uniform(-np.pi, np.pi, N)
        for angle in (azimuth, None):
            forces = force_set(even, angle)
            columns = np.concatenate([forces.first, forces.second])
            limits = np.concatenate([forces.upper, forces.upper])
            scaled = (columns * limits[:, None] * torque_scale / thrust).T
            gain = np.linalg.svd(scaled, compute_uv=False)[2]
            for _ in range(20):
                direction = random.normal(size=3)
                tau = gain * direction / np.linalg.norm(direction) * thrust / torque_scale
                assert scale_to_boundary(even, angle, tau) >= 1.0 - 1e-9


@slow_start
@given(azimuth=angles, tau=forces_3, enabled=masks, stuck=masks)
def test_margin_of_a_step_is_the_same_by_the_fast_way(
    azimuth: FloatArray, tau: FloatArray, enabled: list[bool], stuck: list[bool]
) -> None:
    margin = ThrustMargin(VESSEL, enabled=enabled)(azimuth, tau)
    # Lever arms are divided by their mean before or after the product: rounding, of 1e-11 of the whole thrust at most.
    expected = scale_to_boundary(VESSEL, azimuth, tau, enabled=enabled)
    assert margin.fixed == pytest.approx(expected, rel=1e-9, abs=1e-6)
    expected = scale_to_boundary(VESSEL, None, tau, enabled=enabled)
    assert margin.turning == pytest.approx(max(expected, margin.fixed), rel=1e-9, abs=1e-6)
    can_rotate = [can and not is_stuck for can, is_stuck in zip(VESSEL.can_rotate, stuck, strict=True)]
    some = ThrustMargin(VESSEL, enabled=enabled, can_rotate=can_rotate)(azimuth, tau)
    assert margin.fixed == some.fixed
    assert some.fixed <= some.turning <= margin.turning * (1.0 + 1e-9) + 1e-9


def test_margin_says_whether_a_demand_is_attainable() -> None:
    margin = ThrustMargin(VESSEL)
    azimuth = VESSEL.fixed_direction
    tau = generalized_force(VESSEL.lever_x, VESSEL.lever_y, 0.5 * VESSEL.thrust_max, azimuth)
    assert margin(azimuth, tau).fixed >= 2.0 - 1e-12
    assert margin(azimuth, np.array([40.0, 0.0, 0.0])).turning < 1.0
    assert margin(azimuth, np.zeros(3)) == (math.inf, math.inf)
