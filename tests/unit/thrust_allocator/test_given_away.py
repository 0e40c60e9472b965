"""What methods give away against the exact set: the figures of docs/underwater_allocation.md."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest

from marine_model import load_vessel
from support.repository import ROOT
from thrust_allocator.attainable import facets, scale_to_boundary, zonotope_scale, zonotope_volume
from thrust_allocator.feasible import axis_limits, octahedron_volume, served_limits
from thrust_allocator.feasible.directions import along_direction
from thrust_allocator.feasible.garus_azimuth import asteroid_area

PAGE = (ROOT / "docs" / "underwater_allocation.md").read_text(encoding="utf-8")
UKWIAL, AZIMUTH, MMT300 = map(load_vessel, ("ukwial", "ukwial_azimuth", "mmt300"))


def told(row: str) -> list[float]:
    """Return the numbers of the row of the page that begins with ``row``."""
    (line,) = [line for line in PAGE.splitlines() if line.startswith(f"| {row} |")]
    return [float(cell) for cell in line.strip("| ").split("|")[1:]]


def test_octahedron_of_symmetrical_thrusters() -> None:
    for vessel in (UKWIAL, AZIMUTH):
        B = along_direction(vessel.columns, vessel.fixed_direction).T[[0, 1, 3], :4]
        most = vessel.thrust_max[:4]
        share = octahedron_volume(served_limits(B, most)) / zonotope_volume(B.T, -most, most)
        assert share == pytest.approx(2.0 / 3.0, rel=1e-9)  # directions of 12 digits
    assert told("`ukwial`, `ukwial_azimuth` at 29 deg: surge, sway, yaw") == [0.667]


def test_octahedron_of_the_cross() -> None:
    """There the printed corners are not attainable; the served ones are, and are all that the exact set has there."""
    B, most = along_direction(MMT300.columns, MMT300.fixed_direction).T, MMT300.thrust_max
    printed, served = axis_limits(B, most), served_limits(B, most)
    known = facets(B.T, -most, most)
    reach = np.array([zonotope_scale(known, axis) for axis in np.eye(4)])
    np.testing.assert_allclose(served, reach, rtol=1e-9)
    assert (printed[2], reach[2]) == pytest.approx((65.8, 57.9), abs=0.06)
    share = octahedron_volume(served) / zonotope_volume(B.T, -most, most)
    assert told("`mmt300`: surge, heave, pitch, yaw") == [pytest.approx(share, abs=5e-4)]


def test_octahedron_with_a_lost_thruster() -> None:
    B = along_direction(UKWIAL.columns, UKWIAL.fixed_direction).T
    most = np.array([0.0, 250.0, 250.0, 250.0, 250.0, 250.0])
    surge = scale_to_boundary(UKWIAL, None, [1.0, 0.0, 0.0, 0.0], enabled=[False, *[True] * 5])
    assert (axis_limits(B, most)[0], surge) == pytest.approx((656.0, 437.3), abs=0.1)
    assert served_limits(B, most)[0] == pytest.approx(surge, rel=1e-9)


def test_asteroid_against_propellers_with_angles_of_their_own() -> None:
    """Section of the exact set at 50 N m: the boundary by bisection along 46 rays of a quarter."""
    rays = np.linspace(0.0, pi / 2.0, 46)
    reach = []
    for ray in rays.tolist():
        low, high = 0.0, 1200.0
        while high - low > 0.1:
            middle = 0.5 * (low + high)
            inside = scale_to_boundary(AZIMUTH, None, [middle * cos(ray), middle * sin(ray), 0.0, 50.0]) >= 1.0
            low, high = (middle, high) if inside else (low, middle)
        reach.append(low)
    halves = 0.5 * np.array(reach) ** 2
    area = 4.0 * float((0.5 * (halves[1:] + halves[:-1]) * np.diff(rays)).sum())
    (share,) = told("every propeller at an angle of its own: exact set")
    assert asteroid_area(750.0) / area == pytest.approx(share, abs=1e-3)


@pytest.mark.parametrize("surge", [0.25, 0.5, 0.6, 0.75])
def test_portions_against_the_exact_set(surge: float) -> None:
    delta, most = radians(22.5), 42.0
    ahead, yaw = 4.0 * cos(delta) * surge * most, 2.0 * sin(delta) * (1.0 - surge) * most
    # Heave and pitch: a parallelogram of T_B and q, with determinant L_s + L_b.
    pair = 1.8 * (2.0 * most) * (2.0 * yaw)
    B = along_direction(MMT300.columns, MMT300.fixed_direction)
    share = 2.0 * ahead * 2.0 * yaw * pair / zonotope_volume(B, MMT300.thrust_min, MMT300.thrust_max)
    assert told(f"{surge:g}") == pytest.approx([share, ahead, yaw], abs=0.05)
    assert told(f"{surge:g}")[0] == pytest.approx(share, abs=5e-4)
