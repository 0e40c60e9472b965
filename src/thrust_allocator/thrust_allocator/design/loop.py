"""The design loop of [Ruth] 7.5.4: what every combination of thrusters can do, and how to split them into buses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector
from thrust_allocator.attainable import force_set, largest_ball
from thrust_allocator.singularity import Scaling, lemma_7_2, minimum_gain, scaled_configuration, scaling_of, theorem_7_3

# 4095 combinations; beyond that nobody reads the table, and every further thruster doubles the time.
MOST_THRUSTERS = 12
# Gains that agree to the second decimal, in which [Ruth] prints them, are told apart by nobody.
SAME_GAIN = 0.005

Thrusters = tuple[int, ...]
"""Indices of thrusters, from 0, ascending."""


@dataclass(frozen=True, slots=True)
class Combination:
    """What is left when only these thrusters work: one row of [Ruth] Table 7.1 or 7.2.

    Attributes
    ----------
    thrusters
        Those that work.
    lost
        Index of the thruster that failed if it is the only one, else None.
    rank
        Rank of the scaled configuration matrix; below 3, some generalized force cannot be produced.
    gain
        Minimum gain with the vessel's thrusts, dimensionless; 0 with a rank below 3.
    equal_gain
        The same with every maximum thrust equal to their mean, [Ruth] (7.113).
    scaled_ball
        Radius of the largest ball of attainable scaled generalized force, dimensionless. As large as ``gain`` or
        larger where reverse thrust is as strong as forward thrust, [Ruth] Theorem 7.3.
    ball
        Radius of the largest attainable ball of generalized force, N and N m alike.
    """

    thrusters: Thrusters
    lost: int | None
    rank: int
    gain: float
    equal_gain: float
    scaled_ball: float
    ball: float


@dataclass(frozen=True, slots=True)
class Split:
    """Thrusters divided between two power buses; gains are those of the worse bus alone, after the other is lost."""

    buses: tuple[Thrusters, Thrusters]
    gain: float
    equal_gain: float


@dataclass(frozen=True, slots=True)
class BusLoss:
    """What is left after the loss of one power bus of the vessel file; None if nothing is."""

    bus: str
    left: Combination | None


@dataclass(frozen=True, slots=True)
class BallBounds:
    """Radius of the attainable ball with all thrusters, N and N m alike: bounds of the source and exact value.

    Attributes
    ----------
    printed
        Lemma 7.2, [Ruth] (7.108), for freely rotating thrusters; Theorem 7.3, (7.78), for fixed ones.
    without_root
        Lemma 7.2 without its factor 1 / sqrt(2), which is not needed; None for fixed thrusters.
    reversible
        Exact, with reverse thrust as strong as forward thrust, as the source has it.
    exact
        Exact, with the vessel's limits.
    """

    printed: float
    without_root: float | None
    reversible: float
    exact: float


@dataclass(frozen=True, slots=True)
class Study:
    """Result of the design loop; thrusters rotate freely but for ``azimuth`` not None.

    Attributes
    ----------
    azimuth
        Directions of all thrusters, shape (n,), rad, or None.
    combinations
        Every combination: all, then one less, and so on.
    splits
        Every split into two buses, best first by ``equal_gain``; none for fixed thrusters.
    ball
        The ball with all thrusters.
    """

    azimuth: FloatArray | None
    combinations: tuple[Combination, ...]
    splits: tuple[Split, ...]
    ball: BallBounds

    def of(self, thrusters: Sequence[int]) -> Combination:
        """Return the row of a combination. Raises InputError."""
        wanted = tuple(sorted(thrusters))
        for row in self.combinations:
            if row.thrusters == wanted:
                return row
        raise InputError(f"thrusters: expected some of the vessel's, found {list(thrusters)}")

    def best_splits(self, equal_thrust: bool) -> tuple[Split, ...]:
        """Return the splits with the largest gain of the worse bus; several if they agree to the second decimal.

        None if every split leaves a bus that cannot produce some generalized force.
        """
        gains = [split.equal_gain if equal_thrust else split.gain for split in self.splits]
        best = max(gains, default=0.0)
        if best <= 0.0:
            return ()
        return tuple(split for split, gain in zip(self.splits, gains, strict=True) if gain >= best - SAME_GAIN)


def study_rows(vessel: Vessel, azimuth: ArrayLike | None = None) -> Iterator[Combination]:
    """Work out the rows of a study one by one, all thrusters first; for `study` and for showing progress.

    Parameters
    ----------
    vessel
        The vessel.
    azimuth
        Directions of all thrusters, shape (n,), rad: [Ruth] Table 7.1. None: they rotate freely, Table 7.2.

    Raises
    ------
    InputError
        If the angles have the wrong shape or are not finite, or there are more than ``MOST_THRUSTERS``.
    """
    n = len(vessel.thrusters)
    if n > MOST_THRUSTERS:
        raise InputError(f"vessel: expected at most {MOST_THRUSTERS} thrusters for all combinations, found {n}")
    angles = None if azimuth is None else _angles(vessel, azimuth)
    own, equal = scaling_of(vessel), scaling_of(vessel, equal_thrust=True)
    for count in range(n, 0, -1):
        for thrusters in combinations(range(n), count):
            yield _row(vessel, thrusters, angles, own, equal)


def study(vessel: Vessel, azimuth: ArrayLike | None = None, rows: Sequence[Combination] | None = None) -> Study:
    """Return steps 2 to 4 of the design loop, [Ruth] Figure 7.3.

    Parameters
    ----------
    vessel, azimuth
        As in `study_rows`.
    rows
        What `study_rows` gave, if it has been called.

    Raises
    ------
    InputError
        As `study_rows`.
    """
    found = tuple(study_rows(vessel, azimuth) if rows is None else rows)
    angles = None if azimuth is None else _angles(vessel, azimuth)
    splits = () if angles is not None else _splits(len(vessel.thrusters), found)
    return Study(angles, found, splits, _ball(vessel, angles, found[0]))


def bus_losses(vessel: Vessel, found: Study) -> tuple[BusLoss, ...]:
    """Return what is left after the loss of each power bus that the vessel file names; none if it names none."""
    losses = []
    for bus in vessel.power.buses:
        left = [j for j, name in enumerate(vessel.thruster_names) if name not in bus.thrusters]
        losses.append(BusLoss(bus.name, found.of(left) if left else None))
    return tuple(losses)


def _angles(vessel: Vessel, azimuth: ArrayLike) -> FloatArray:
    """Return the angles, those of tunnel thrusters as in the vessel file."""
    angles = finite_vector("azimuth", azimuth, len(vessel.thrusters))
    return np.where(vessel.can_rotate, angles, vessel.fixed_direction)


def _row(vessel: Vessel, thrusters: Thrusters, azimuth: FloatArray | None, own: Scaling, equal: Scaling) -> Combination:
    n = len(vessel.thrusters)
    enabled = [j in thrusters for j in range(n)]
    matrix = scaled_configuration(own, azimuth, enabled)
    forces = force_set(vessel, azimuth, enabled=enabled)
    return Combination(
        thrusters=thrusters,
        lost=next(j for j in range(n) if j not in thrusters) if len(thrusters) == n - 1 else None,
        rank=int(np.linalg.matrix_rank(matrix)),
        gain=minimum_gain(matrix).gain,
        equal_gain=minimum_gain(scaled_configuration(equal, azimuth, enabled)).gain,
        scaled_ball=largest_ball(forces.scaled(own.mean_thrust_max)).radius,
        ball=largest_ball(forces).radius,
    )


def _splits(n: int, rows: Sequence[Combination]) -> tuple[Split, ...]:
    by_thrusters = {row.thrusters: row for row in rows}
    splits = []
    for row in rows:
        # Each split once: the bus with the first thruster is named first.
        if 0 in row.thrusters and len(row.thrusters) < n:
            other = by_thrusters[tuple(j for j in range(n) if j not in row.thrusters)]
            buses = (row.thrusters, other.thrusters)
            splits.append(Split(buses, min(row.gain, other.gain), min(row.equal_gain, other.equal_gain)))
    return tuple(sorted(splits, key=_best_first))


def _best_first(split: Split) -> tuple[float, float, tuple[Thrusters, Thrusters]]:
    # Mirror images differ by rounding, and should come in the order of their numbers.
    return -round(split.equal_gain, 9), -round(split.gain, 9), split.buses


def _ball(vessel: Vessel, azimuth: FloatArray | None, whole: Combination) -> BallBounds:
    scaling = scaling_of(vessel)
    forces = force_set(vessel, azimuth)
    reversible = largest_ball(replace(forces, lower=-forces.upper)).radius
    if azimuth is not None:
        return BallBounds(theorem_7_3(whole.gain, scaling).unscaled, None, reversible, whole.ball)
    printed, without = (lemma_7_2(whole.gain, scaling, as_printed).unscaled for as_printed in (True, False))
    return BallBounds(printed, without, reversible, whole.ball)
