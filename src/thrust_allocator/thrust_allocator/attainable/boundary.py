"""How far the attainable set reaches in one direction, as machine code.

With h the support function of a set that holds the origin, s d is in the set if and only if s n'd <= h(n) for every
n. For a zonotope it is enough to try the normals of its facets; otherwise the smallest h(n) with n'd = 1 is looked for.
"""

from __future__ import annotations

import math

import numpy as np

from marine_model.compiled import compiled
from marine_model.guards import FloatArray

# A set thinner than this part of its size is flat; so is a direction that leaves a flat set by less.
FLAT = 1e-10
DIRECTION = 1e-9
# A reach below this part of the size of the set is none: rounding of sums is 1e-16 of it.
NOTHING = 1e-11
# A direction that leaves a facet through the origin by less (sine of the angle) lies in it; 90 deg comes out so.
ALONG = 1e-12
# Weight of the barrier in the last round, as part of the size of the set: the error of the reach for each thruster.
LAST_BARRIER = 1e-13
BARRIER_STEP = 0.02
# Damped Newton on a self-concordant function needs a few steps a round; the cap is for rounding at the end.
MOST_STEPS = 200


@compiled
def basis(columns: FloatArray) -> tuple[int, FloatArray]:
    """Return the dimension of the span of columns (k, 3) and a right-handed orthonormal basis (3, 3), span first.

    Gram-Schmidt with the longest rest first; rests below ``FLAT`` of the longest column count as none.
    """
    k = columns.shape[0]
    rest = columns.copy()
    axes = np.zeros((3, 3))
    longest = 0.0
    rank = 0
    for r in range(3):
        best, at = 0.0, -1
        for j in range(k):
            size = math.sqrt(rest[j, 0] ** 2 + rest[j, 1] ** 2 + rest[j, 2] ** 2)
            if size > best:
                best, at = size, j
        if r == 0:
            longest = best
        if at < 0 or best <= FLAT * longest:
            break
        # Once more against the axes found, so that a short rest is at right angles to them to the last digit.
        for i in range(3):
            axes[r, i] = rest[at, i] / best
        for p in range(r):
            dot = axes[r, 0] * axes[p, 0] + axes[r, 1] * axes[p, 1] + axes[r, 2] * axes[p, 2]
            for i in range(3):
                axes[r, i] -= dot * axes[p, i]
        size = math.sqrt(axes[r, 0] ** 2 + axes[r, 1] ** 2 + axes[r, 2] ** 2)
        for i in range(3):
            axes[r, i] /= size
        for j in range(k):
            dot = rest[j, 0] * axes[r, 0] + rest[j, 1] * axes[r, 1] + rest[j, 2] * axes[r, 2]
            for i in range(3):
                rest[j, i] -= dot * axes[r, i]
        rank += 1
    if rank == 1:
        across_of(axes[0], axes[1])
    if rank == 1 or rank == 2:
        cross(axes[0], axes[1], axes[2])
    return rank, axes


@compiled
def across_of(axis: FloatArray, out: FloatArray) -> None:
    """Write a unit vector at right angles to the unit vector ``axis`` into ``out``."""
    small = 0
    for i in range(1, 3):
        if abs(axis[i]) < abs(axis[small]):
            small = i
    size = math.sqrt(1.0 - axis[small] ** 2)
    for i in range(3):
        out[i] = ((1.0 if i == small else 0.0) - axis[small] * axis[i]) / size


@compiled
def cross(one: FloatArray, two: FloatArray, out: FloatArray) -> None:
    """Write the vector product into ``out``."""
    out[0] = one[1] * two[2] - one[2] * two[1]
    out[1] = one[2] * two[0] - one[0] * two[2]
    out[2] = one[0] * two[1] - one[1] * two[0]


@compiled
def within_span(rank: int, axes: FloatArray, direction: FloatArray) -> bool:
    """Return whether a unit ``direction`` lies in the span of the first ``rank`` axes."""
    out = 0.0
    for r in range(rank, 3):
        dot = axes[r, 0] * direction[0] + axes[r, 1] * direction[1] + axes[r, 2] * direction[2]
        out += dot * dot
    return out <= DIRECTION * DIRECTION


@compiled
def segments_support(generators: FloatArray, lower: FloatArray, upper: FloatArray, normal: FloatArray) -> float:
    """Return the support function of a zonotope: sum of max(lower a, upper a) with a = generator . normal."""
    total = 0.0
    for j in range(generators.shape[0]):
        a = generators[j, 0] * normal[0] + generators[j, 1] * normal[1] + generators[j, 2] * normal[2]
        total += upper[j] * a if a > 0.0 else lower[j] * a
    return total


@compiled
def _tighten(
    generators: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    direction: FloatArray,
    normal: FloatArray,
    reach: float,
) -> float:
    """Return the smaller of ``reach`` and what the half-space of ``normal``, turned towards direction, allows."""
    along = normal[0] * direction[0] + normal[1] * direction[1] + normal[2] * direction[2]
    if along < 0.0:
        along = -along
        for i in range(3):
            normal[i] = -normal[i]
    if along * along <= ALONG * ALONG * (normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2):
        return reach
    support: float = segments_support(generators, lower, upper, normal)
    if support < reach * along:
        reach = support / along
    return reach


@compiled
def zonotope_reach(generators: FloatArray, lower: FloatArray, upper: FloatArray, direction: FloatArray) -> float:
    """Return the largest s >= 0 with s direction in the zonotope {generators' u, lower <= u <= upper}.

    In closed form: the least of h(n) / n'direction over the normals of its facets, which are vector products of pairs
    of generators (edges in the plane if it is flat). Any n gives a bound that holds, so that a normal spoilt by
    rounding (of a facet that is nearly a line) does no harm.

    Parameters
    ----------
    generators
        Shape (k, 3), rows comparable in size (moments divided by a length).
    lower, upper
        Shape (k,), lower <= 0 <= upper.
    direction
        Shape (3,), not zero.
    """
    k = generators.shape[0]
    length = math.sqrt(direction[0] ** 2 + direction[1] ** 2 + direction[2] ** 2)
    unit = direction / length
    # Generators as long as the thruster is strong, so that a lost one is none.
    columns = np.empty((k, 3))
    low, high = np.empty(k), np.empty(k)
    size = 0.0
    for j in range(k):
        span = upper[j] - lower[j]
        for i in range(3):
            columns[j, i] = generators[j, i] * span
        low[j] = lower[j] / span if span > 0.0 else 0.0
        high[j] = upper[j] / span if span > 0.0 else 0.0
        size += math.sqrt(columns[j, 0] ** 2 + columns[j, 1] ** 2 + columns[j, 2] ** 2)
    rank, axes = basis(columns)
    if rank == 0 or not within_span(rank, axes, unit):
        return 0.0
    reach = 2.0 * size
    normal = np.empty(3)
    if rank == 1:
        normal[:] = axes[0]
        reach = _tighten(columns, low, high, unit, normal, reach)
    elif rank == 2:
        for j in range(k):
            cross(axes[2], columns[j], normal)
            reach = _tighten(columns, low, high, unit, normal, reach)
    else:
        for j in range(k):
            for p in range(j):
                cross(columns[j], columns[p], normal)
                reach = _tighten(columns, low, high, unit, normal, reach)
    if reach <= NOTHING * size:
        return 0.0
    return reach / length


@compiled
def usable_one_way(columns: FloatArray, one_way: FloatArray, unit: FloatArray) -> bool:
    """Strike out one-way thrusters that are of no use in a direction; return whether anything is attainable in it.

    With a disc, everything but one-way thrusters spans a plane or all space. From a plane they lead to one side or to
    both. A direction within the plane has no use for them if they all lead to one side; one out of it needs one on its
    side.

    Parameters
    ----------
    columns
        Columns of all thrusters, two each, shape (2 n, 3); those struck out are set to zero.
    one_way
        Shape (n,), 1.0 for a thruster whose thrust is never negative, -1.0 for never positive, else 0.0.
    unit
        Direction, shape (3,), of length 1.
    """
    k = one_way.shape[0]
    both = columns.copy()
    for j in range(k):
        if one_way[j] != 0.0:
            both[2 * j, :] = 0.0
    rank, axes = basis(both)
    if rank == 3:
        return True
    up, down = False, False
    for j in range(k):
        if one_way[j] != 0.0:
            out = 0.0
            square = 0.0
            for i in range(3):
                out += one_way[j] * axes[2, i] * columns[2 * j, i]
                square += columns[2 * j, i] ** 2
            up |= out > DIRECTION * math.sqrt(square)
            down |= out < -DIRECTION * math.sqrt(square)
    out = axes[2, 0] * unit[0] + axes[2, 1] * unit[1] + axes[2, 2] * unit[2]
    if out > DIRECTION:
        return up
    if out < -DIRECTION:
        return down
    if up != down:
        for j in range(k):
            if one_way[j] != 0.0:
                out = 0.0
                square = 0.0
                for i in range(3):
                    out += axes[2, i] * columns[2 * j, i]
                    square += columns[2 * j, i] ** 2
                if out * out > DIRECTION * DIRECTION * square:
                    columns[2 * j, :] = 0.0
    return True


@compiled
def turning_reach(
    first: FloatArray,
    second: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    turns: FloatArray,
    direction: FloatArray,
) -> tuple[float, FloatArray]:
    """Return the largest s >= 0 with s direction in a sum of segments and discs, and the normal of the boundary there.

    Minimises h(n) over n'direction = 1, two unknowns, by an interior-point method. With a = (first . n, second . n) a
    disc of radius r has the support r |a|; it is replaced by the largest value of u'a + mu log(r^2 - |u|^2), which has
    the closed form u = a r^2 / (mu + w), w = sqrt(mu^2 + r^2 |a|^2), and a segment likewise about its
    middle. These are self-concordant, so that damped Newton steps converge, and the optimum is off by mu a thruster
    at most. Radii grow by mu, so that there is an inside even if the origin is on the boundary. What is returned is
    h(n) itself, not its replacement, the lowest found: it is never too small.

    Parameters
    ----------
    first, second, lower, upper
        As in ``ForceSet``; rows comparable in size.
    turns
        Shape (n,), 1.0 where the thruster turns, else 0.0.
    direction
        Shape (3,), not zero.

    Returns
    -------
    reach, normal
        s, and n (3,) with n'direction = 1 and h(n) = s; zeros where the direction is out of reach for want of span.
    """
    k = first.shape[0]
    length = math.sqrt(direction[0] ** 2 + direction[1] ** 2 + direction[2] ** 2)
    unit = direction / length
    columns = np.empty((2 * k, 3))
    middle, one_way = np.zeros(k), np.zeros(k)  # middle of a segment in half lengths
    any_one_way = False
    size = 0.0
    for j in range(k):
        radius = upper[j]
        if turns[j] == 0.0:
            radius = 0.5 * (upper[j] - lower[j])
            if radius > 0.0:
                middle[j] = 0.5 * (upper[j] + lower[j]) / radius
                one_way[j] = 1.0 if lower[j] == 0.0 else (-1.0 if upper[j] == 0.0 else 0.0)
                any_one_way |= one_way[j] != 0.0
        for i in range(3):
            columns[2 * j, i] = first[j, i] * radius
            columns[2 * j + 1, i] = second[j, i] * radius
            size += columns[2 * j, i] ** 2 + columns[2 * j + 1, i] ** 2
    size = math.sqrt(size)
    normal, centre = np.zeros(3), np.zeros(3)
    if size == 0.0:
        return 0.0, normal
    columns /= size
    if any_one_way and not usable_one_way(columns, one_way, unit):
        return 0.0, normal
    for j in range(k):
        for i in range(3):
            centre[i] += middle[j] * columns[2 * j, i]
    rank, axes = basis(columns)
    if not within_span(rank, axes, unit):
        return 0.0, normal
    # Within the span, n = unit + y[0] across[0] + y[1] across[1].
    across = np.zeros((2, 3))
    free = rank - 1
    if rank == 3:
        across_of(unit, across[0])
        cross(unit, across[0], across[1])
    elif rank == 2:
        cross(axes[2], unit, across[0])
    # a = constant + slope y, for either column of every thruster.
    constant, slope = np.zeros(2 * k), np.zeros((2 * k, 2))
    tilt = np.zeros(2)
    base = 0.0
    for i in range(3):
        base += centre[i] * unit[i]
        for q in range(2):
            tilt[q] += centre[i] * across[q, i]
    for c in range(2 * k):
        for i in range(3):
            constant[c] += columns[c, i] * unit[i]
            for q in range(2):
                slope[c, q] += columns[c, i] * across[q, i]
    y0, y1 = 0.0, 0.0
    best, best0, best1 = math.inf, 0.0, 0.0
    mu = 0.1
    for _ in range(MOST_STEPS):
        value = base + tilt[0] * y0 + tilt[1] * y1
        g0, g1 = tilt[0], tilt[1]
        h00, h01, h11 = 0.0, 0.0, 0.0
        grown = (1.0 + mu) ** 2
        for j in range(k):
            c = 2 * j
            a = constant[c] + slope[c, 0] * y0 + slope[c, 1] * y1
            b = constant[c + 1] + slope[c + 1, 0] * y0 + slope[c + 1, 1] * y1
            square = a * a + b * b
            value += math.sqrt(square)
            w = math.sqrt(mu * mu + grown * square)
            f = grown / (mu + w)
            e = f / w
            p0 = slope[c, 0] * a + slope[c + 1, 0] * b
            p1 = slope[c, 1] * a + slope[c + 1, 1] * b
            g0 += f * p0
            g1 += f * p1
            h00 += f * (slope[c, 0] ** 2 + slope[c + 1, 0] ** 2 - e * p0 * p0)
            h01 += f * (slope[c, 0] * slope[c, 1] + slope[c + 1, 0] * slope[c + 1, 1] - e * p0 * p1)
            h11 += f * (slope[c, 1] ** 2 + slope[c + 1, 1] ** 2 - e * p1 * p1)
        if value < best:
            best, best0, best1 = value, y0, y1
        if free < 2:
            h01, h11 = 0.0, 1.0
        if free < 1:
            h00 = 1.0
        determinant = h00 * h11 - h01 * h01
        if not determinant > 0.0:
            break
        d0 = (h11 * g0 - h01 * g1) / determinant
        d1 = (h00 * g1 - h01 * g0) / determinant
        square = g0 * d0 + g1 * d1
        if not square >= 0.0:
            break
        decrement = math.sqrt(square / mu)
        step = 1.0 if decrement < 0.25 else 1.0 / (1.0 + decrement)
        y0 -= step * d0
        y1 -= step * d1
        if decrement < 0.5:
            if mu <= LAST_BARRIER:
                break
            mu = max(BARRIER_STEP * mu, LAST_BARRIER)
    if best <= NOTHING:
        best = 0.0
    for i in range(3):
        normal[i] = (unit[i] + best0 * across[0, i] + best1 * across[1, i]) / length
    return best * size / length, normal
