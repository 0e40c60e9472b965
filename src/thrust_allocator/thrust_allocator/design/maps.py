"""Which maps of the minimum gain a design needs, [Ruth] Figures 7.4-7.13, for any vessel with two azimuth thrusters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from thrust_allocator.singularity import gain_map, scaling_of

BoundName = Literal["svd", "theorem_7_1", "theorem_7_2"]


@dataclass(frozen=True, slots=True)
class MapCase:
    """One map over the directions of two azimuth thrusters.

    Attributes
    ----------
    axes
        Indices of the thrusters on the horizontal and the vertical axis.
    held
        Direction of all other azimuth thrusters that work, rad; None if there are none.
    lost
        Index of the thruster that has failed, or None.
    equal_thrust
        True: every maximum thrust is the mean of all, [Ruth] (7.113).
    method
        "svd": all thrusters bidirectional. Otherwise azimuth thrusters are unidirectional, and it says which bound.
    source
        Figure of the thesis that shows this for CyberShip III, or empty.
    """

    axes: tuple[int, int]
    held: float | None
    lost: int | None
    equal_thrust: bool
    method: BoundName
    source: str


@dataclass(frozen=True, slots=True)
class GainMap:
    """A map: ``gain[i, k]`` is for ``angles[i]`` (rad) on the horizontal and ``angles[k]`` on the vertical axis."""

    case: MapCase
    angles: FloatArray
    gain: FloatArray

    @property
    def best(self) -> tuple[float, float, float]:
        """Largest gain and where it is, rad and rad; the first of several."""
        i, k = np.unravel_index(int(np.argmax(self.gain)), self.gain.shape)
        return float(self.gain[i, k]), float(self.angles[i]), float(self.angles[k])


def map_cases(vessel: Vessel) -> tuple[MapCase, ...]:
    """Return the maps that [Ruth] 7.6.1-7.6.2 looks at, for any vessel.

    The axes are the last two azimuth thrusters; the other azimuth thrusters are all held at 0, 90 or 180 deg. If one
    of the axes is lost, the last of the others takes its place.

    Raises
    ------
    InputError
        If there are fewer than two azimuth thrusters.
    """
    azimuths = [j for j, can in enumerate(vessel.can_rotate) if can]
    if len(azimuths) < 2:
        raise InputError(
            f"map: expected at least two azimuth thrusters to turn, found {len(azimuths)} on {vessel.name}"
        )
    tunnels = [j for j, can in enumerate(vessel.can_rotate) if not can]
    *others, one, other = azimuths
    axes = (one, other)
    straight, across, astern = (0.0, math.pi / 2, math.pi) if others else (None, None, None)
    sides = ((straight, 0), (across, 1)) if others else ((None, 0),)
    cases = [MapCase(axes, held, None, True, "svd", f"7.{4 + i}") for held, i in sides]
    cases += [MapCase(axes, held, lost, True, "svd", f"7.{6 + i}") for lost in tunnels for held, i in sides]
    for lost in others:
        rest = across if len(others) > 1 else None
        cases.append(MapCase(axes, rest, lost, True, "svd", "7.8"))
    if others:
        rest = across if len(others) > 1 else None
        cases.append(MapCase((others[-1], other), rest, one, True, "svd", "7.9"))
        cases.append(MapCase((others[-1], one), rest, other, True, "svd", ""))
    cases += [MapCase(axes, held, None, False, "svd", f"7.{10 + i}") for held, i in sides]
    for held, figure in ((across, "7.12"), (astern, "7.13")) if others else ((None, "7.12"),):
        cases += [MapCase(axes, held, None, True, method, figure) for method in ("theorem_7_1", "theorem_7_2")]
    return tuple(cases)


def work_out(vessel: Vessel, case: MapCase, points: int = 73) -> GainMap:
    """Return one map.

    Parameters
    ----------
    vessel
        The vessel.
    case
        One of `map_cases`.
    points
        Number of angles on either axis, from -180 to 180 deg, both ends included.
    """
    angles = np.linspace(-math.pi, math.pi, points)
    n = len(vessel.thrusters)
    enabled = np.array([[j != case.lost for j in range(n)]])
    one_way = None if case.method == "svd" else np.array(vessel.can_rotate)
    gain = gain_map(
        scaling_of(vessel, case.equal_thrust),
        case.axes,
        (angles, angles),
        np.full(n, case.held or 0.0),
        enabled,
        one_way,
        case.method,
    )
    return GainMap(case, angles, gain[0])
