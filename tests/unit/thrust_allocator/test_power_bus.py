"""Rows that limit the power of a bus, [Ruth] (4.50)-(4.55)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from thrust_allocator.plan.polygon import rotating_corners, rotating_rows
from thrust_allocator.plan.windows import step_window
from thrust_allocator.power import BusRowKind, bus_row, phase_back, tangent_excess, total_power
from thrust_allocator.power.bus import TANGENT_EXCESS, line_above, power_of

VESSEL = load_vessel("cybership3")
M = VESSEL.propellers.power_per_thrust_3_2
C1, C2 = VESSEL.allocator.approach_fraction, VESSEL.allocator.zero_region
STEP = VESSEL.thrust_rate * VESSEL.measurement.sample_time
TURN = VESSEL.azimuth_rate * VESSEL.measurement.sample_time
BUS_A = VESSEL.bus_members[0].copy()
ALL = np.ones(4)


def windows(thrust, rotating=None) -> tuple[np.ndarray, np.ndarray]:
    least = VESSEL.thrust_min if rotating is None else np.where(rotating > 0.0, 0.0, VESSEL.thrust_min)
    pairs = [
        step_window(float(t), float(low), float(high), float(d), C1)
        for t, low, high, d in zip(thrust, least, VESSEL.thrust_max, STEP, strict=True)
    ]
    return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])


def row(thrust, limit, *, member=ALL, rotating=None, azimuth=None, safe=True, window=None, turn=None):
    """Return x part, y part, bound, kind, lower, upper."""
    thrust = np.array(thrust, dtype=float)
    rotating = np.zeros(4) if rotating is None else rotating
    azimuth = np.zeros(4) if azimuth is None else azimuth
    lower, upper = windows(thrust, rotating) if window is None else window
    turn = TURN if turn is None else turn
    x, y = np.empty(4), np.empty(4)
    bound, kind = bus_row(M, member, rotating, thrust, azimuth, lower, upper, -turn, turn, C2, limit, C1, safe, x, y)
    return x, y, bound, BusRowKind(kind), lower, upper


fixed_thrusts = st.tuples(
    *(st.floats(float(low), float(high)) for low, high in zip(VESSEL.thrust_min, VESSEL.thrust_max, strict=True))
).map(np.array)
shares = st.tuples(*[st.floats(0.0, 1.0)] * 4).map(np.array)


def test_gradient_by_finite_differences() -> None:
    """Of sum m (T_x^2 + T_y^2)^(3/4) for a rotating thruster, of m |T|^(3/2) for a fixed one."""
    thrust, azimuth = np.array([-0.3, 4.0, 7.0, 9.0]), np.array([math.pi / 2.0, 2.0, 0.5, -2.5])
    rotating = np.array([0.0, 1.0, 1.0, 1.0])
    x, y, bound, kind, _, _ = row(thrust, 1e3, rotating=rotating, azimuth=azimuth, safe=False)
    assert kind is BusRowKind.TANGENT

    def power(tx: np.ndarray, ty: np.ndarray) -> float:
        return float(M @ (tx**2 + ty**2) ** 0.75)

    tx = np.where(rotating > 0.0, thrust * np.cos(azimuth), thrust)
    ty = np.where(rotating > 0.0, thrust * np.sin(azimuth), 0.0)
    h = 1e-6
    for j in range(4):
        d = h * np.eye(4)[j]
        # Central differences are wrong by h^2 and by rounding over h, 1e-9 of 50 W.
        assert x[j] == pytest.approx((power(tx + d, ty) - power(tx - d, ty)) / (2.0 * h), rel=1e-6)
        if rotating[j] > 0.0:
            assert y[j] == pytest.approx((power(tx, ty + d) - power(tx, ty - d)) / (2.0 * h), rel=1e-6)
    assert y[0] == 0.0
    # At T_0 the row says P(T_0) <= P_bus: (4.53) with all its terms.
    assert x @ tx + y @ ty - bound == pytest.approx(power(tx, ty) - 1e3)


def test_the_example_of_the_thesis() -> None:
    """From 50 % of the thrust to 70 %: power rises by 66 %, the linearisation says 60 %."""
    thrust = np.array([0.0, 0.0, 6.75, 0.0])
    x = row(thrust, 1e3, safe=False)[0]
    before, after = power_of(M[2], 6.75), power_of(M[2], 1.4 * 6.75)
    assert after / before - 1.0 == pytest.approx(0.66, abs=0.005)
    assert x[2] * 0.4 * 6.75 / before == pytest.approx(0.60, abs=1e-12)
    # Other thrusters are at zero, where the row says nothing of them.
    np.testing.assert_array_equal(x[[0, 1, 3]], 0.0)


@given(thrust=fixed_thrusts, share=shares, limit=st.floats(0.01, 50.0))
def test_safe_row_of_fixed_thrusters_never_exceeds(thrust: np.ndarray, share: np.ndarray, limit: float) -> None:
    x, _, bound, kind, lower, upper = row(thrust, limit)
    answer = lower + share * (upper - lower)
    if kind is BusRowKind.SAFE:
        # Above the power everywhere, and by no more than m h^(3/2) a thruster, h half of the window.
        above = limit - bound + x @ answer - total_power(M, answer)
        assert above >= -1e-12 * limit - 1e-12
        assert above <= float(M @ (0.5 * (upper - lower)) ** 1.5) + 1e-9
    if kind is BusRowKind.SAFE and x @ answer <= bound:
        assert total_power(M, answer) <= limit + 1e-9


def corners(lower: float, upper: float, turn: float, azimuth: float) -> list[tuple[float, float, float]]:
    return list(rotating_rows(azimuth, -turn, turn, lower, upper, C2))


@given(
    thrust=st.floats(0.0, 13.5),
    turn=st.floats(0.0, math.pi / 3.0),
    azimuth=st.floats(-math.pi, math.pi),
    point=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
)
def test_safe_row_of_a_rotating_thruster_is_above_in_its_whole_polygon(
    thrust: float, turn: float, azimuth: float, point: tuple[float, float]
) -> None:
    thrusts = np.array([0.0, 0.0, thrust, 0.0])
    rotating = np.array([0.0, 0.0, 1.0, 0.0])
    member = rotating
    x, y, bound, kind, lower, upper = row(
        thrusts, 1e3, member=member, rotating=rotating, azimuth=np.full(4, azimuth), turn=np.full(4, turn)
    )
    assert kind is BusRowKind.SAFE
    rows = corners(lower[2], upper[2], turn, azimuth)
    # A point of the polygon: from its inside towards anywhere, as far as the rows allow.
    inside = 0.5 * (lower[2] + upper[2]) * 0.9 * np.array([math.cos(azimuth), math.sin(azimuth)])
    if not all(a * inside[0] + b * inside[1] <= c for a, b, c in rows):
        inside = 0.999 * upper[2] * np.array([math.cos(azimuth), math.sin(azimuth)])
    if not all(a * inside[0] + b * inside[1] <= c for a, b, c in rows):
        return  # a polygon of next to no size
    way = 20.0 * np.array(point)
    reach = min(
        [1.0]
        + [
            (c - a * inside[0] - b * inside[1]) / (a * way[0] + b * way[1])
            for a, b, c in rows
            if a * way[0] + b * way[1] > 1e-9
        ]
    )
    z = inside + reach * way
    linear = 1e3 - bound + x[2] * z[0] + y[2] * z[1]
    assert linear >= power_of(M[2], math.hypot(*z)) - 1e-9


def test_vertices_are_those_of_the_polygon() -> None:
    """Each lies on two of its lines and within the others."""
    upper, turn, azimuth = 9.0, 0.3, 0.7
    points = np.empty((5, 2))
    ahead, side = np.array([math.cos(azimuth), math.sin(azimuth)]), np.array([-math.sin(azimuth), math.cos(azimuth)])
    rows = corners(-0.004, upper, turn, azimuth)
    assert rotating_corners(0.0, -turn, turn, -0.004, upper, C2, points) == 5
    for x, y in points:
        z = x * ahead + y * side
        residuals = sorted(abs(a * z[0] + b * z[1] - c) for a, b, c in rows)
        assert residuals[1] < 1e-12
        assert all(a * z[0] + b * z[1] <= c + 1e-12 for a, b, c in rows)


points_1d = st.lists(st.tuples(st.floats(-5.0, 5.0), st.floats(0.0, 9.0)), min_size=2, max_size=5)


@given(points=points_1d, at=st.floats(-6.0, 6.0), slope=st.floats(-5.0, 5.0))
def test_line_above_is_above_and_lowest(points: list[tuple[float, float]], at: float, slope: float) -> None:
    x, y = np.array(points).T.copy()
    s, offset = line_above(x, y, at)
    scale = 1e-9 * (1.0 + abs(s) * 5.0 + np.abs(y).max())
    assert (offset + s * x >= y - scale).all()
    inset = 1e-3 * (x.max() - x.min())
    at = min(max(at, x.min() + inset), x.max() - inset)
    other = (y - slope * x).max() + slope * at
    assert offset + s * at <= other + scale


@given(before=st.floats(-3.0, 3.0), change=st.floats(-1.0, 1.0))
def test_tangent_excess_of_a_fixed_thruster(before: float, change: float) -> None:
    slope = 1.5 * math.copysign(math.sqrt(abs(before)), before)
    excess = abs(before + change) ** 1.5 - abs(before) ** 1.5 - slope * change
    assert -1e-12 <= excess <= TANGENT_EXCESS * abs(change) ** 1.5 + 1e-12


@given(before=st.floats(0.0, 3.0), size=st.floats(0.0, 1.0), angle=st.floats(-math.pi, math.pi))
def test_tangent_excess_in_the_plane(before: float, size: float, angle: float) -> None:
    z = before + size * math.cos(angle), size * math.sin(angle)
    excess = math.hypot(*z) ** 1.5 - before**1.5 - 1.5 * math.sqrt(before) * (z[0] - before)
    assert -1e-12 <= excess <= TANGENT_EXCESS * size**1.5 + 1e-12


def test_tangent_excess_is_reached() -> None:
    before = (2.0 - math.sqrt(2.0)) / 4.0
    excess = (1.0 - before) ** 1.5 - before**1.5 + 1.5 * math.sqrt(before)
    assert excess == pytest.approx(TANGENT_EXCESS, rel=1e-14)
    assert tangent_excess(M, BUS_A, STEP) == pytest.approx(TANGENT_EXCESS * float((M * BUS_A) @ STEP**1.5))


@given(thrust=fixed_thrusts, share=shares, limit=st.floats(0.01, 50.0))
def test_tangent_row_exceeds_by_no_more_than_its_bound_and_phase_back_by_nothing(
    thrust: np.ndarray, share: np.ndarray, limit: float
) -> None:
    x, _, bound, kind, lower, upper = row(thrust, limit, safe=False)
    answer = lower + share * (upper - lower)
    if total_power(M, answer) <= limit:  # what is allowed is never cut off
        assert x @ answer <= bound + 1e-9
    if kind is BusRowKind.TANGENT and x @ answer <= bound:
        assert total_power(M, answer) <= limit + tangent_excess(M, ALL, STEP) + 1e-9
        out = np.empty(4)
        phase_back(M, ALL, answer, lower, upper, limit, out)
        nearest = np.clip(0.0, lower, upper)
        assert total_power(M, out) <= max(limit, total_power(M, nearest)) * (1.0 + 1e-9)


@given(
    thrust=fixed_thrusts,
    limit=st.one_of(st.just(0.0), st.floats(0.0, 60.0)),
    rotates=st.booleans(),
    safe=st.booleans(),
)
def test_a_row_can_always_be_met(thrust: np.ndarray, limit: float, rotates: bool, safe: bool) -> None:
    """Some point of the windows satisfies it, with the width that c_1 leaves."""
    rotating = np.array([0.0, 1.0, 1.0, 1.0]) if rotates else np.zeros(4)
    if rotates:
        thrust = np.abs(thrust)
        thrust[0] = min(thrust[0], 0.58)
    x, y, bound, kind, lower, upper = row(thrust, limit, rotating=rotating, safe=safe)
    now = np.clip(thrust, lower, upper)
    slope = np.where(rotating > 0.0, np.hypot(x, y) * np.sign(x), x)  # azimuth is 0 here
    least = np.minimum(slope * lower, slope * upper).sum()
    if rotates:  # the lower end may lie a little astern
        least -= float(np.abs(slope) @ (C2 * (upper - lower)))
    assert least <= bound + 1e-12 * (1.0 + abs(bound))
    if kind is BusRowKind.RELAXED:
        assert limit < total_power(M, now) + 1e-9
        # It asks for c_1 of the reach, or more.
        assert bound <= slope @ now + C1 * (least - slope @ now) + 1e-9 * (1.0 + abs(bound)) or rotates


def test_relaxed_row_leads_back_below_the_limit() -> None:
    """All thrusters at full thrust, and the bus loses most of its power."""
    thrust = VESSEL.thrust_max.copy()
    limit = 2.0
    kinds = []
    for _ in range(40):
        x, _, bound, kind, lower, upper = row(thrust, limit, member=BUS_A)
        kinds.append(kind)
        # The allocator wants full thrust: go as far up as the row allows, by the same share of every window.
        top, bottom = np.where(x > 0.0, upper, lower), np.where(x > 0.0, lower, upper)
        over = float(x @ top) - bound
        share = min(max(over / max(float(x @ (top - bottom)), 1e-30), 0.0), 1.0)
        thrust = top + share * (bottom - top)
        if kind is not BusRowKind.SAFE:
            out = np.empty(4)
            phase_back(M, BUS_A, thrust, lower, upper, limit, out)
            thrust = out
    assert kinds[0] is BusRowKind.RELAXED
    power = total_power(M * BUS_A, thrust)
    assert power <= limit * (1.0 + 1e-9)
    assert power > 0.5 * limit  # and does not stay far below it
    # 13.5 N at 2.7 N a sample: five samples from full thrust to none, and one for what c_1 leaves.
    assert BusRowKind.RELAXED not in kinds[6:]


def test_other_buses_have_no_part_in_a_row() -> None:
    x, y, _, _, _, _ = row([0.3, 4.0, 7.0, 9.0], 5.0, member=BUS_A, rotating=np.array([0.0, 1.0, 1.0, 1.0]))
    np.testing.assert_array_equal(x[[1, 3]], 0.0)
    np.testing.assert_array_equal(y[[1, 3]], 0.0)
    assert x[0] != 0.0
    assert x[2] != 0.0
