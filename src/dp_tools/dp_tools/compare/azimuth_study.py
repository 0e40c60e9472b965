"""Four azimuth propellers: the asteroid of [Garus-A] beside what they can give."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, radians, sin

import numpy as np

from dp_tools.compare.azimuth_sets import apart, area_of, best_together, load_together, outline_together
from dp_tools.compare.papers import (
    AZIMUTH_ANGLE_DEGREES,
    AZIMUTH_COUNTEREXAMPLE,
    AZIMUTH_EXAMPLE,
    AZIMUTH_LIMIT,
    is_azimuth_example,
)
from dp_tools.compare.polytope import Polytope, inside
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.feasible import AzimuthSquare, next_angle
from thrust_allocator.feasible.garus_azimuth import (
    asteroid_area,
    asteroid_load,
    force_limit,
    largest_moment,
    load_at,
    reserved_thrust,
)
from thrust_allocator.methods.azimuth import azimuth_square

# The paper reserves 50 N m of the 200 N m that its propellers give at any angle.
_RESERVED_PART = 0.25
_BEARINGS = 7200


@dataclass(frozen=True)
class AngleShares:
    """Random demands of surge and sway, uniform in the square of the largest force (11); shares of all of them.

    Attributes
    ----------
    count
        How many.
    asteroid, together, apart
        Within the asteroid; at a common angle; each propeller at its own.
    kept_in_vain
        Within the asteroid, and not given by the pseudo-inverse at the angle of the example, which step 2 keeps.
    kept_and_short
        The same by any thrusts.
    """

    count: int
    asteroid: float
    together: float
    apart: float
    kept_in_vain: float
    kept_and_short: float


@dataclass(frozen=True)
class AngleCase:
    """One demand, and what is left of it beside the reserved moment.

    Attributes
    ----------
    name, surge, sway
        N.
    asteroid, together, apart
        How many times the demand can be given.
    angle, together_angle
        Of (18), and the best one for any thrusts, deg.
    reduced
        tau' of the algorithm, N.
    printed, printed_angle
        The same in print, N and deg; None where nothing is printed.
    needed_at, largest_at
        At the angle of the example, N: |X| / cos a + |Y| / sin a, for which the method has tau_1max, and the largest
        thrust of the pseudo-inverse with the whole moment.
    pseudo_at, multiple_at
        How many times the demand can be given there: by the pseudo-inverse, and by any thrusts within limits.
    """

    name: str
    surge: float
    sway: float
    asteroid: float
    together: float
    apart: float
    angle: float
    together_angle: float
    reduced: tuple[float, float]
    printed: tuple[float, float] | None
    printed_angle: float | None
    needed_at: float
    largest_at: float
    pseudo_at: float
    multiple_at: float


@dataclass(frozen=True, eq=False)
class AzimuthStudy:
    """All of four azimuth propellers.

    Attributes
    ----------
    square
        The propellers.
    moment, reserved, limit
        Reserved yaw moment, N m; f_tau3 of (14) and tau_1max of (15), N.
    present, room
        The angle that demands are looked at with, deg, and what the moment leaves there by the pseudo-inverse, N.
    together_outline
        Boundary of the set at a common angle, shape (k, 2), N.
    apart_set
        Set with an angle for each.
    asteroid_area, together_area, apart_area
        N^2.
    shares, cases
        See there.
    """

    square: AzimuthSquare
    moment: float
    reserved: float
    limit: float
    present: float
    room: float
    together_outline: FloatArray
    apart_set: Polytope
    asteroid_area: float
    together_area: float
    apart_area: float
    shares: AngleShares
    cases: tuple[AngleCase, ...]


def square_of(vessel: Vessel) -> AzimuthSquare | None:
    """Return the four azimuth propellers that (7) asks for; None if the vessel has no such, or controls other axes."""
    if not {"surge", "sway", "yaw"} <= set(vessel.degrees_of_freedom):
        return None
    try:
        return azimuth_square(vessel)
    except InputError:
        return None


def study_azimuth(square: AzimuthSquare, demands: int, generator: np.random.Generator) -> AzimuthStudy:
    """Return the study of four propellers, with as many random ``demands`` from ``generator``."""
    moment = _RESERVED_PART * largest_moment(square, 0.0)
    reserved = reserved_thrust(square, moment, 0.0)
    limit = force_limit(square, reserved, 0.0)
    present = AZIMUTH_ANGLE_DEGREES
    outline = outline_together(square, moment, np.linspace(0.0, 2.0 * np.pi, _BEARINGS, endpoint=False))
    each = apart(square, moment)
    shares = _shares(square, moment, limit, each, demands, generator)
    scale = limit / AZIMUTH_LIMIT
    surge, sway, _ = AZIMUTH_EXAMPLE.demand
    kept_surge, kept_sway = AZIMUTH_COUNTEREXAMPLE
    points = (("example", scale * surge, scale * sway), ("step 2", scale * kept_surge, scale * kept_sway))
    as_printed = is_azimuth_example(square.thrust_max, square.distance, square.bearing)
    cases = tuple(
        _case(square, moment, limit, each, name, one, other, as_printed and name == "example")
        for name, one, other in points
    )
    return AzimuthStudy(
        square,
        moment,
        reserved,
        limit,
        present,
        _room(square, moment, radians(present)),
        outline,
        each,
        asteroid_area(limit),
        area_of(outline),
        each.volume,
        shares,
        cases,
    )


def _room(square: AzimuthSquare, moment: float, angle: float) -> float:
    """Return what ``moment`` (N m) leaves for |X| / cos a + |Y| / sin a at ``angle`` (rad) by the pseudo-inverse, N."""
    return 4.0 * square.thrust_max - moment / (square.distance * sin(angle + square.bearing))


def _shares(
    square: AzimuthSquare, moment: float, limit: float, each: Polytope, count: int, generator: np.random.Generator
) -> AngleShares:
    tau = generator.uniform(-1.0, 1.0, (count, 2)) * 4.0 * square.thrust_max
    surge, sway = tau.T
    in_asteroid = inside(np.array([asteroid_load(one, other, limit) for one, other in tau.tolist()]))
    angle = radians(AZIMUTH_ANGLE_DEGREES)
    room = _room(square, moment, angle)
    by_method = inside(np.array([load_at(one, other, angle, room) for one, other in tau.tolist()]))
    by_any = inside(load_together(square, moment, surge, sway, angle))
    return AngleShares(
        count,
        float(in_asteroid.mean()),
        float(inside(best_together(square, moment, surge, sway)[0]).mean()),
        float(inside(each.load(tau)).mean()),
        float((in_asteroid & ~by_method).mean()),
        float((in_asteroid & ~by_any).mean()),
    )


def _case(
    square: AzimuthSquare,
    moment: float,
    limit: float,
    each: Polytope,
    name: str,
    surge: float,
    sway: float,
    printed: bool,
) -> AngleCase:
    present = radians(AZIMUTH_ANGLE_DEGREES)
    choice = next_angle(surge, sway, present, limit, limit, 0.0)
    load, angle = best_together(square, moment, np.array(surge), np.array(sway))
    needed = load_at(surge, sway, present, 1.0)
    room = _room(square, moment, present)
    return AngleCase(
        name,
        surge,
        sway,
        1.0 / choice.load,
        1.0 / float(load),
        1.0 / float(each.load(np.array([surge, sway]))),
        degrees(choice.angle),
        degrees(float(angle)),
        (choice.surge, choice.sway),
        AZIMUTH_EXAMPLE.reduced[:2] if printed and AZIMUTH_EXAMPLE.reduced is not None else None,
        AZIMUTH_ANGLE_DEGREES if printed else None,
        needed,
        needed / 4.0 + square.thrust_max - room / 4.0,
        room / needed,
        1.0 / float(load_together(square, moment, np.array(surge), np.array(sway), present)),
    )
