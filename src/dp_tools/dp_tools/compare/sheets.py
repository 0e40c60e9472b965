"""What `dp compare` has to say, as tables."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dp_tools.compare.azimuth_study import AngleCase, AzimuthStudy
from dp_tools.compare.group_study import GroupStudy, Reduction, Refused
from dp_tools.compare.portion_study import PLANES, PortionStudy
from dp_tools.compare.program import ATTAINED
from dp_tools.compare.sheet import Row, Sheet, figures, percent
from dp_tools.compare.speed_study import SpeedStudy
from dp_tools.quantities import number
from marine_model import Vessel
from thrust_allocator.methods.cross import AXES

# How much a corner may be out of reach before it is said to be: rounding.
_BEYOND = 1e-9


def group_sheets(vessel: Vessel, study: GroupStudy) -> Iterator[Sheet]:
    """Yield the tables of a group of axes."""
    yield _sets(study)
    if len(study.group.axes) > 1:
        yield _random(study)
    if study.refused is not None:
        yield _served(vessel, study, study.refused)
    for one in study.reductions:
        yield _reduction(study, one)


def azimuth_sheets(study: AzimuthStudy) -> Iterator[Sheet]:
    """Yield the tables of four azimuth propellers."""
    areas = (
        ("asteroid, (16)", study.asteroid_area),
        ("at one common angle, any thrusts", study.together_area),
        ("every propeller at its own angle", study.apart_area),
    )
    shares, kept = study.shares, study.shares.asteroid or 1.0
    found = (shares.asteroid, shares.together, shares.apart)
    yield Sheet(
        f"Surge and sway beside a yaw moment of {number(study.moment)} N m",
        ("area (N²)", "asteroid over it", "of random demands"),
        tuple(
            (name, (f"{area:.4g}", f"{study.asteroid_area / area:.4f}", percent(share)))
            for (name, area), share in zip(areas, found, strict=True)
        ),
        f"The moment takes {number(study.reserved)} N of {number(study.square.thrust_max)} N, (14), and leaves "
        f"{number(study.limit)} N of surge or sway, (15). {shares.count} random demands of both, uniform up to "
        f"{number(4.0 * study.square.thrust_max)} N, (11). Step 2 keeps the present angle for all of the asteroid: "
        f"with {study.present:g}° there, {percent(shares.kept_in_vain / kept)} of it is beyond the pseudo-inverse, and "
        f"{percent(shares.kept_and_short / kept)} beyond any thrusts.",
    )
    yield from (_angle_case(study, case) for case in study.cases)


def portion_sheets(study: PortionStudy) -> Iterator[Sheet]:
    """Yield the table of portions."""
    names = [f"{axis} ({unit})" for axis, unit in zip(AXES, ("N", "N", "N m", "N m"), strict=True)]
    rows: list[Row] = [
        ("attainable", (*(number(x) for x in study.limits), *("" for _ in PLANES), percent(study.attainable)))
    ]
    rows += [
        (
            f"P_x = {row.surge_portion:g}",
            (*(number(x) for x in row.limits), *(f"{x:.4f}" for x in row.area_ratios), percent(row.met)),
        )
        for row in study.rows
    ]
    middle = study.middle
    yield Sheet(
        "Portions, [Kostenko] (6): largest demand by axis, and area over the attainable",
        (*names, *(f"area {one}, {other}" for one, other in PLANES), "of random demands"),
        tuple(rows),
        "P_φ = P_ψ = 1 − P_x. In a plane portions reach a rectangle, and no channel has a say in another. With equal "
        f"portions it covers {percent(middle.area_ratios[0])} and {percent(middle.area_ratios[1])} of what is "
        f"attainable, the most of these, and {percent(middle.met / (study.attainable or 1.0))} of the attainable ones "
        f"of {study.count} random demands, uniform up to the largest attainable of each axis.",
    )


def speed_sheets(study: SpeedStudy) -> Iterator[Sheet]:
    """Yield the tables of a drive."""
    last, demand = study.rows[-1], number(float(study.demands[-1]))
    others = " and others" if study.count > 1 else ""
    name = f"Drive of {study.thruster.replace('_', ' ')}{others}"
    speeds = [f"{row.speed:g} m/s" for row in study.rows]
    yield Sheet(
        f"{name}: largest thrust (N)",
        ("T_max, Table 4", "largest code, Table 2", "largest code, equilibrium"),
        tuple(
            (speed, (f"{row.thrust_max:.1f}", *(f"{x:.2f}" for x in row.at_code_max)))
            for speed, row in zip(speeds, study.rows, strict=True)
        ),
        "Equilibrium: where the torques of motor and propeller meet, (3), which is what the simulator sails with.",
    )
    yield Sheet(
        f"{name}: {demand} N demanded without compensation, (7): short by (N)",
        ("Table 2", "equilibrium"),
        tuple(
            (speed, tuple(f"{x:.2f}".replace("-", "−") for x in row.shortfall))
            for speed, row in zip(speeds, study.rows, strict=True)
        ),
        f"At {last.speed:g} m/s {demand} N fall short by {last.shortfall[0]:.2f} N by Table 2, and by "
        f"{last.shortfall[1]:.2f} N in equilibrium.",
    )
    yield Sheet(
        f"{name}: error with compensation, (8), of demands up to T_max (N)",
        ("largest, Table 2", "rms, Table 2", "largest, equilibrium", "rms, equilibrium"),
        tuple(
            (speed, tuple(f"{x:.2f}" for pair in zip(row.error, row.rms, strict=True) for x in pair))
            for speed, row in zip(speeds, study.rows, strict=True)
        ),
        f"At {last.speed:g} m/s no demand is missed by more than {last.error[0]:.2f} N by Table 2, which is what "
        f"Tables 2 and 4 differ by, and half a code. In equilibrium it is {last.error[1]:.2f} N.",
    )


def _sets(study: GroupStudy) -> Sheet:
    group, volumes = study.group, study.volumes
    unit = " ".join(group.units) if len(group.axes) > 1 else group.units[0]
    rows = (
        ("attainable, exact", volumes.exact),
        ("pseudo-inverse within limits", volumes.pseudo_inverse),
        ("octahedron, (3.1), as printed", volumes.printed),
        ("octahedron of what is served", volumes.served),
    )
    return Sheet(
        f"{group.name}: sets of demands",
        (
            *(f"largest {axis} ({u})" for axis, u in zip(group.axes, group.units, strict=True)),
            f"volume ({unit})",
            "of exact",
        ),
        tuple(
            (name, (*(number(x, 4) for x in most), f"{volume:.4g}", f"{volume / volumes.exact:.4f}"))
            for (name, volume), most in zip(rows, _extents(study), strict=True)
        ),
        _verdict(study),
    )


def _extents(study: GroupStudy) -> tuple[np.ndarray, ...]:
    """Largest demand of every axis alone in each of the sets, the weaker of both ways."""
    group = study.group
    both = np.concatenate([np.eye(len(group.axes)), -np.eye(len(group.axes))])

    def weaker(loads: np.ndarray) -> np.ndarray:
        return np.minimum(*np.split(1.0 / loads, 2))

    return weaker(study.exact.load(both)), weaker(group.by_pseudo_inverse().load(both)), group.printed, group.served


def _verdict(study: GroupStudy) -> str:
    group, shares, volumes = study.group, study.shares, study.volumes
    if len(group.axes) == 1:
        return "One axis by itself: all sets are the same, and the method gives nothing away."
    ratio = volumes.printed / volumes.exact
    beyond = [
        f"{axis} of {number(float(limit), 4)} {unit} needs {load:.3f} times the thrust there is"
        for axis, unit, limit, load in zip(group.axes, group.units, group.printed, study.corner_loads, strict=True)
        if load > 1.0 + _BEYOND
    ]
    words = [
        f"[Garus-F] has (3.1) as 'if and only if'. It is not: the octahedron has {ratio:.4f} of the attainable volume "
        f"and refuses {percent(shares.refused_in_vain / (shares.attainable or 1.0))} of the attainable ones among "
        f"{shares.count} random demands."
    ]
    if beyond:
        words.append(
            "Nor is it a part of the attainable set: by-products of a full axis have to be held by thrusters that "
            f"are not there: {'; '.join(beyond)}."
        )
    elif abs(volumes.pseudo_inverse / volumes.printed - 1.0) < _BEYOND:
        words.append("For the pseudo-inverse alone it holds: its set is the octahedron.")
    return " ".join(words)


def _random(study: GroupStudy) -> Sheet:
    shares = study.shares
    rows = (
        ("attainable, exact", shares.attainable),
        (f"quadratic program, slack below {ATTAINED:g} of the demand", shares.program),
        ("pseudo-inverse within limits", shares.pseudo_inverse),
        ("octahedron, (3.1), as printed", shares.passed),
        ("octahedron of what is served", shares.served),
        ("attainable, and refused by (3.1)", shares.refused_in_vain),
        ("not attainable, and passed by (3.1)", shares.passed_in_vain),
    )
    misses = []
    if shares.largest_miss_inside is not None:
        misses.append(f"at most {shares.largest_miss_inside:.1e} of the demand within the exact set")
    if shares.smallest_miss_outside is not None:
        misses.append(f"at least {shares.smallest_miss_outside:.1e} outside")
    return Sheet(
        f"{study.group.name}: {shares.count} random demands, uniform up to the largest forces as printed",
        ("share",),
        tuple((name, (percent(share),)) for name, share in rows),
        f"Slack of the quadratic program: {', '.join(misses)}.",
    )


def _served(vessel: Vessel, study: GroupStudy, refused: Refused) -> Sheet:
    group = study.group
    rows = tuple(
        (vessel.thruster_names[j].replace("_", " "), (f"{low:g} to {high:g}", number(one, 4), number(other, 4)))
        for j, low, high, one, other in zip(
            group.thrusters,
            group.lower.tolist(),
            group.upper.tolist(),
            refused.by_pseudo_inverse.tolist(),
            refused.by_program.tolist(),
            strict=True,
        )
    )
    demand = _demand(study, refused.demand)
    return Sheet(
        f"{group.name}: {demand}, refused by (3.1) and served",
        ("limits (N)", "pseudo-inverse (N)", "quadratic program (N)"),
        tuple((name.replace("-", "−"), tuple(cell.replace("-", "−") for cell in cells)) for name, cells in rows),
        f"Left side of (3.1): {refused.load:.3f}. The demand is attainable {refused.multiple:.3f} times. Residual of "
        f"the quadratic program: {figures(refused.residual, 2)}.",
    )


def _reduction(study: GroupStudy, one: Reduction) -> Sheet:
    group = study.group
    return Sheet(
        f"{group.name}: {_demand(study, one.demand)} ({one.source})",
        (*(f"{axis} ({unit})" for axis, unit in zip(group.axes, group.units, strict=True)), "share"),
        tuple(
            (way.method, (*(number(float(x), 4) for x in way.given), "" if way.share is None else f"{way.share:.4f}"))
            for way in one.ways
        ),
        f"Left side of (3.1): {one.load:.3f}. Share: of the demand, or of the axes that are not kept. Weights of (14): "
        "1.",
    )


def _angle_case(study: AzimuthStudy, case: AngleCase) -> Sheet:
    reduced = f"{number(case.reduced[0], 4)}, {number(case.reduced[1], 4)} N"
    rows: list[Row] = [
        ("asteroid, (17)", (f"{case.asteroid:.4f}", reduced, f"{case.angle:.1f}°")),
    ]
    if case.printed is not None:
        rows.append(("as printed", ("", f"{figures(case.printed, 3)} N", f"{case.printed_angle:.1f}°")))
    for name, multiple, angle in (
        ("at one common angle, any thrusts", case.together, f"{case.together_angle:.1f}°"),
        ("every propeller at its own angle", case.apart, ""),
        (f"kept at {study.present:g}°, pseudo-inverse", case.pseudo_at, f"{study.present:g}°"),
        (f"kept at {study.present:g}°, any thrusts", case.multiple_at, f"{study.present:g}°"),
    ):
        share = min(1.0, multiple)
        given = f"{number(share * case.surge, 4)}, {number(share * case.sway, 4)} N"
        rows.append((name, (f"{multiple:.4f}", given, angle)))
    return Sheet(
        f"{number(case.surge, 4)} N of surge, {number(case.sway, 4)} N of sway, {number(study.moment)} N m of yaw",
        ("times attainable", "surge, sway given", "angle"),
        tuple(rows),
        f"Kept at {study.present:g}°, |X| / cos α + |Y| / sin α is {number(case.needed_at, 4)} N, against "
        f"{number(study.limit, 4)} N that the method counts with; the pseudo-inverse asks "
        f"{number(case.largest_at, 4)} N of one propeller of {number(study.square.thrust_max, 4)} N.",
    )


def _demand(study: GroupStudy, demand: np.ndarray) -> str:
    units = study.group.units
    return ", ".join(f"{number(x, 3)} {unit}" for x, unit in zip(demand.tolist(), units, strict=True))
