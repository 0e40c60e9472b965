"""One group of axes: volumes of the sets, random demands, a demand that is refused and served, reductions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from dp_tools.compare.group import Group
from dp_tools.compare.papers import examples_for
from dp_tools.compare.polytope import Polytope, determinant_volume, inside
from dp_tools.compare.program import ATTAINED, ConstrainedProgram
from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.feasible import octahedron_load, reduce_by_priority, reduce_proportionally

# Share of a corner of the attainable set at which the demand to look at lies: within it, thrust to spare.
_WITHIN = 0.9
_DIGITS = 3
# Where no paper fits, so many times that demand are reduced: beyond the attainable set.
_BEYOND = 1.25
# Demands between two calls of the progress.
_CHUNK = 250


@dataclass(frozen=True)
class Volumes:
    """Volumes, product of the units of the axes.

    Attributes
    ----------
    exact, exact_by_determinants
        The attainable set, by its convex hull and by the boxes its segments span.
    printed, served
        The octahedra.
    pseudo_inverse
        What the pseudo-inverse gives within limits.
    """

    exact: float
    exact_by_determinants: float
    printed: float
    served: float
    pseudo_inverse: float


@dataclass(frozen=True)
class Shares:
    """Random demands, uniform in the box of the largest forces as printed; every share of all of them.

    Attributes
    ----------
    count
        How many.
    attainable, program
        By the exact set, and by the quadratic program with a slack below 1e-4 of the demand.
    passed, refused_in_vain, passed_in_vain
        By the octahedron as printed; attainable and refused; passed and not attainable.
    served
        By the octahedron of what is served without by-products.
    pseudo_inverse
        Thrusts of the pseudo-inverse within limits.
    largest_miss_inside, smallest_miss_outside
        Slack of the program over the demand, of those within the exact set and outside; None if there are none.
    """

    count: int
    attainable: float
    program: float
    passed: float
    refused_in_vain: float
    passed_in_vain: float
    served: float
    pseudo_inverse: float
    largest_miss_inside: float | None
    smallest_miss_outside: float | None


@dataclass(frozen=True, eq=False)
class Refused:
    """A demand that the octahedron refuses and the quadratic program serves.

    Attributes
    ----------
    demand
        Shape (m,).
    load
        Left side of (3.1) with the largest forces as printed: above 1.
    multiple
        How many times the demand is attainable.
    by_pseudo_inverse, by_program
        Thrusts, shape (k,), N.
    residual
        Demand less what the program gives, shape (m,).
    """

    demand: FloatArray
    load: float
    multiple: float
    by_pseudo_inverse: FloatArray
    by_program: FloatArray
    residual: FloatArray


@dataclass(frozen=True, eq=False)
class Way:
    """What one method makes of a demand.

    Attributes
    ----------
    method
        Its name.
    given
        Generalized force, shape (m,).
    share
        Of the demand, or of the axes that are not kept; None where axes get different shares.
    """

    method: str
    given: FloatArray
    share: float | None


@dataclass(frozen=True, eq=False)
class Reduction:
    """One demand beyond the octahedron, and what methods leave of it."""

    source: str
    demand: FloatArray
    load: float
    ways: tuple[Way, ...]


@dataclass(frozen=True, eq=False)
class GroupStudy:
    """All of one group.

    Attributes
    ----------
    group, exact
        The axes and their attainable set.
    volumes, shares
        See there.
    corner_loads
        How many times the attainable set must grow to reach the largest force of every axis as printed, both ways,
        shape (m,).
    refused
        None with one axis.
    reductions
        Of the papers' demands where they fit, else of one beyond the refused one.
    """

    group: Group
    exact: Polytope
    volumes: Volumes
    shares: Shares
    corner_loads: FloatArray
    refused: Refused | None
    reductions: tuple[Reduction, ...]


def study_group(
    vessel: Vessel,
    group: Group,
    demands: int,
    generator: np.random.Generator,
    advance: Callable[[int], None] = lambda _: None,
) -> GroupStudy:
    """Return the study of a group.

    Parameters
    ----------
    vessel, group
        What to look at.
    demands
        How many random demands.
    generator
        Where they come from.
    advance
        Called with the number of demands done since the last call.
    """
    exact, program = group.attainable(), ConstrainedProgram(vessel, group)
    volumes = Volumes(
        exact.volume,
        determinant_volume(group.columns, group.lower, group.upper),
        group.printed_octahedron().volume,
        group.served_octahedron().volume,
        group.by_pseudo_inverse().volume,
    )
    refused = _refused(group, exact, program)
    papers = examples_for(group.axes, group.printed)
    cases = [(one.source, np.array(one.demand), one.reduced) for one in papers]
    if not cases and refused is not None:
        cases = [(f"{_BEYOND:g} times the demand above", _BEYOND * refused.demand, None)]
    return GroupStudy(
        group,
        exact,
        volumes,
        _shares(group, exact, program, demands, generator, advance),
        exact.load(np.stack([np.diag(group.printed), -np.diag(group.printed)])).max(axis=0),
        refused,
        tuple(_reduction(group, exact, program, *case) for case in cases),
    )


def _shares(
    group: Group,
    exact: Polytope,
    program: ConstrainedProgram,
    count: int,
    generator: np.random.Generator,
    advance: Callable[[int], None],
) -> Shares:
    tau = generator.uniform(-1.0, 1.0, (count, len(group.axes))) * group.printed
    attainable = inside(exact.load(tau))
    passed = inside(octahedron_load(tau, group.printed))
    missed = np.empty(count)
    for i, demand in enumerate(tau):
        missed[i] = program.missed(demand, program.thrusts(demand))
        if (i + 1) % _CHUNK == 0 or i + 1 == count:
            advance(i % _CHUNK + 1)
    return Shares(
        count,
        float(attainable.mean()),
        float((missed < ATTAINED).mean()),
        float(passed.mean()),
        float((attainable & ~passed).mean()),
        float((passed & ~attainable).mean()),
        float(inside(octahedron_load(tau, group.served)).mean()),
        float(inside(group.by_pseudo_inverse().load(tau)).mean()),
        float(missed[attainable].max()) if attainable.any() else None,
        float(missed[~attainable].min()) if not attainable.all() else None,
    )


def _refused(group: Group, exact: Polytope, program: ConstrainedProgram) -> Refused | None:
    """Return the demand near that corner of the attainable set which the octahedron refuses most."""
    loads = octahedron_load(exact.vertices, group.printed)
    corner = exact.vertices[int(np.argmax(np.round(loads, 9)))]
    demand = np.array([float(f"{value:.{_DIGITS}g}") for value in (_WITHIN * corner).tolist()])
    # Rounding of a number that is 0 but for sums of products.
    demand[np.abs(demand) < 1e-9 * group.printed] = 0.0
    load = float(octahedron_load(demand, group.printed))
    if load <= 1.0:
        return None
    thrusts = program.thrusts(demand)
    return Refused(
        demand,
        load,
        1.0 / float(exact.load(demand)),
        group.inverse @ demand,
        thrusts,
        demand - group.columns @ thrusts,
    )


def _reduction(
    group: Group,
    exact: Polytope,
    program: ConstrainedProgram,
    source: str,
    demand: FloatArray,
    printed: tuple[float, float, float] | None,
) -> Reduction:
    m, load = len(demand), float(octahedron_load(demand, group.printed))
    proportional = reduce_proportionally(demand, group.printed)
    multiple = min(1.0, 1.0 / float(exact.load(demand)))
    ways = [Way("proportional, (3.3)", proportional, min(1.0, 1.0 / load))]
    if printed is not None:
        ways.append(Way("as printed", np.array(printed), None))
    ways.append(Way("exact, same direction", multiple * demand, multiple))
    for kept in range(m):
        base = np.where(np.arange(m) == kept, demand, 0.0)
        rest = demand - base
        if not base.any() or not rest.any() or float(exact.load(base)) > 1.0:
            continue
        by_priority = reduce_by_priority(demand, group.printed, np.ones(m), kept)
        other = int(np.argmax(np.abs(rest) / group.printed))
        name = group.axes[kept]
        ways.append(Way(f"{name} kept, (14)", by_priority, float(by_priority[other] / demand[other])))
        share = min(1.0, exact.share_from(base, rest))
        ways.append(Way(f"exact, {name} kept", base + share * rest, share))
    ways.append(Way("quadratic program", group.columns @ program.thrusts(demand), None))
    return Reduction(source, demand, load, tuple(ways))
