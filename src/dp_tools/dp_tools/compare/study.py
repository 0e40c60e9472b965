"""All that `dp compare` works out of a vessel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dp_tools.compare.azimuth_study import AzimuthStudy, square_of, study_azimuth
from dp_tools.compare.group import Group, groups_of
from dp_tools.compare.group_study import GroupStudy, study_group
from dp_tools.compare.portion_study import PortionStudy, cross_with_limit, study_portions
from dp_tools.compare.speed_study import SpeedStudy, drives_of, study_speed
from marine_model import Vessel
from marine_model.errors import InputError

# Streams of random numbers: one for every part, so that none changes with another.
_AZIMUTH, _PORTIONS, _GROUPS = range(3)


@dataclass(frozen=True, eq=False)
class Comparison:
    """A vessel and its studies.

    Attributes
    ----------
    vessel, demands, seed
        What was asked for.
    groups
        Coupled axes, thrusters along their fixed directions.
    azimuth
        Four azimuth propellers; None if it has no such.
    portions
        A cross of marching thrusters; None if it has none.
    speeds
        Drives that take codes.
    """

    vessel: Vessel
    demands: int
    seed: int
    groups: tuple[GroupStudy, ...]
    azimuth: AzimuthStudy | None
    portions: PortionStudy | None
    speeds: tuple[SpeedStudy, ...]


def groups_to_compare(vessel: Vessel, demands: int, seed: int) -> tuple[Group, ...]:
    """Return the groups of axes of ``vessel``, once it is clear that they can be looked at.

    Raises
    ------
    InputError
        If ``demands`` is not above 0, ``seed`` is below 0, or a thruster pushes one way only.
    """
    for name, value, least in (("--demands", demands, 1), ("--seed", seed, 0)):
        if value < least:
            raise InputError(f"{name}: expected {least} or more, found {value}")
    return groups_of(vessel)


def compare_vessel(
    vessel: Vessel,
    groups: Sequence[Group],
    demands: int,
    seed: int,
    advance: Callable[[int], None] = lambda _: None,
) -> Comparison:
    """Return the comparison of a vessel.

    Parameters
    ----------
    vessel
        The vessel.
    groups, demands, seed
        From :func:`groups_to_compare`, and its arguments: random demands for each part, and their seed.
    advance
        Called with the number of demands done since the last call; there are ``demands`` for each group.
    """
    studies = tuple(
        study_group(vessel, group, demands, np.random.default_rng([seed, _GROUPS, i]), advance)
        for i, group in enumerate(groups)
    )
    square, cross = square_of(vessel), cross_with_limit(vessel)
    # The axes of a cross hang together, or it would be none.
    portions = (
        None
        if cross is None
        else study_portions(
            *cross, studies[0].group, studies[0].exact, demands, np.random.default_rng([seed, _PORTIONS])
        )
    )
    azimuth = None if square is None else study_azimuth(square, demands, np.random.default_rng([seed, _AZIMUTH]))
    speeds = tuple(study_speed(*one) for one in drives_of(vessel))
    return Comparison(vessel, demands, seed, studies, azimuth, portions, speeds)
