"""The exact set over any axes: against linear programming, and group by group."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from marine_model import load_vessel
from marine_model.guards import FloatArray
from thrust_allocator import Allocator
from thrust_allocator.attainable import (
    AxesMargin,
    facets,
    force_set,
    scale_to_boundary,
    zonotope_scale,
    zonotope_volume,
)
from thrust_allocator.attainable import volume as volume_of
from thrust_allocator.feasible.directions import along_direction

UKWIAL, AZIMUTH, MMT300, SHIP = map(load_vessel, ("ukwial", "ukwial_azimuth", "mmt300", "cybership3"))


def largest(B: FloatArray, lower: FloatArray, upper: FloatArray, tau: FloatArray) -> float:
    """Return the largest s with B u = s tau and u within limits, by linear programming."""
    n = B.shape[1]
    found = linprog(
        np.append(np.zeros(n), -1.0),
        A_eq=np.column_stack((B, -tau)),
        b_eq=np.zeros(len(B)),
        bounds=[*zip(lower, upper, strict=True), (0.0, None)],
        method="highs",
    )
    assert found.status == 0
    return float(found.x[-1])


@pytest.mark.parametrize("vessel", [UKWIAL, AZIMUTH, MMT300])
@pytest.mark.parametrize("lost", [None, 0, 4])
def test_against_linear_programming(vessel, lost: int | None) -> None:
    n, m = len(vessel.thrusters), len(vessel.degrees_of_freedom)
    enabled = [j != lost for j in range(n)]
    margin = AxesMargin(vessel, enabled=enabled)
    B = along_direction(vessel.columns, vessel.fixed_direction).T
    lower, upper = vessel.thrust_min * enabled, vessel.thrust_max * enabled
    rng = np.random.default_rng(2)
    # Demands that are attainable at some size: any, and with what is lost out of the way those of the thrusters left.
    for tau in np.vstack((rng.normal(size=(6, m)) * [100, 50, 50, 20], rng.normal(size=(6, n)) * enabled @ B.T)):
        # HiGHS is content at 1e-7.
        assert margin(vessel.fixed_direction, tau).fixed == pytest.approx(
            largest(B, lower, upper, tau), rel=1e-6, abs=1e-9
        )


def test_groups_do_not_know_of_each_other() -> None:
    heave = scale_to_boundary(UKWIAL, None, [0.0, 0.0, 1.0, 0.0])
    assert heave == pytest.approx(500.0)
    both = scale_to_boundary(UKWIAL, None, [1.0, 0.0, 1.0, 0.0])
    assert both == pytest.approx(500.0)
    assert scale_to_boundary(UKWIAL, None, [1.0, 0.0, 0.1, 0.0]) == pytest.approx(874.62, abs=0.01)


def test_turned_margin_of_azimuth_propellers() -> None:
    """Ahead all four give 250 N once turned, at 29 deg 874.6 N."""
    tau = np.array([1.0, 0.0, 0.0, 0.0])
    assert scale_to_boundary(AZIMUTH, None, tau) == pytest.approx(1000.0, rel=1e-9)
    assert scale_to_boundary(AZIMUTH, AZIMUTH.fixed_direction, tau) == pytest.approx(874.62, abs=0.01)
    margin = AxesMargin(AZIMUTH)
    assert margin(AZIMUTH.fixed_direction, np.zeros(4)) == (np.inf, np.inf)


def test_a_ship_is_what_it_was() -> None:
    """The same set by the code for any axes and by that for three."""
    tau, angle = np.array([3.0, 2.0, 1.0]), np.array([0.0, 0.3, -0.5, 1.0])
    general, three = AxesMargin(SHIP), scale_to_boundary(SHIP, angle, tau)
    assert general(angle, tau).fixed == pytest.approx(three, rel=1e-12)
    assert general(angle, tau).turning == pytest.approx(scale_to_boundary(SHIP, None, tau), rel=1e-9)
    forces = force_set(SHIP, angle)
    known = facets(forces.first, forces.lower, forces.upper)
    assert zonotope_scale(known, tau) == pytest.approx(three, rel=1e-12)
    assert zonotope_volume(forces.first, forces.lower, forces.upper) == pytest.approx(volume_of(forces), rel=1e-12)


def test_flat_and_empty_sets() -> None:
    plane = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 1.0], [1.0, 1.0, 0.0, 1.0]])
    known = facets(plane, -np.ones(3), np.ones(3))
    assert zonotope_scale(known, plane[0]) == pytest.approx(2.0)
    assert zonotope_scale(known, np.array([0.0, 1.0, 0.0, 0.0])) == 0.0
    line = facets(plane[:1], np.zeros(1), np.ones(1))
    assert zonotope_scale(line, plane[0]) == 1.0
    assert zonotope_scale(line, -plane[0]) == 0.0
    nothing = facets(plane, np.zeros(3), np.zeros(3))
    assert zonotope_scale(nothing, plane[0]) == 0.0
    assert zonotope_volume(plane, -np.ones(3), np.ones(3)) == 0.0


@pytest.mark.parametrize("vessel", [UKWIAL, AZIMUTH, MMT300])
def test_program_attains_just_what_the_set_says(vessel) -> None:
    """0.999 of the way to the edge is served to the slack of the weights, 1.05 of it is not."""
    m = len(vessel.degrees_of_freedom)
    rng = np.random.default_rng(8)
    for _ in range(3):
        tau = rng.normal(size=m) * [100.0, 30.0, 30.0, 20.0]
        edge = scale_to_boundary(vessel, vessel.fixed_direction, tau)
        for share, served in ((0.999, True), (1.05, False)):
            allocator = Allocator(vessel)
            for _ in range(20):
                result = allocator.step(share * edge * tau, 0.2)
            missed = float(np.abs(result.slack).max() / np.abs(result.tau_desired).max())
            assert (missed < 1e-4) is served
            assert result.margin.fixed == pytest.approx(1.0 / share)
            assert np.isnan(result.gains.global_gain)
            assert np.isnan(result.gain_both_ways.gain)
