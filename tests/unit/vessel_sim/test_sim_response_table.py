"""The response of a hull tabulated over relative directions: against the box itself, and from computed data."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from marine_model import Vessel, load_vessel
from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.wave_response import WaveResponse, load_wave_response
from support.box_hull import box_of, with_box_hull
from vessel_sim.waves import ComputedHull, HullForm, hull_in_waves
from vessel_sim.waves.components import component_table
from vessel_sim.waves.drift import drift_force
from vessel_sim.waves.hull_form import box_response
from vessel_sim.waves.hull_motion import hull_motion
from vessel_sim.waves.response_table import FUNCTIONS, response_table

Array = NDArray[np.float64]
VESSEL = load_vessel("cybership3")
FORM = box_of(VESSEL)
AT_ORIGIN = (0.0, 0.0)


def box_motions(period: float, b: float) -> Array:
    """Motions of the box per metre at theta = 0 and at theta = pi / 2, shape (2, 6)."""
    surge, sway, heave, roll, pitch, yaw = box_response(
        FORM.box, (2.0 * math.pi / period) ** 2 / GRAVITY, math.cos(b), math.sin(b)
    )
    return np.array([[0.0, 0.0, heave, 0.0, 0.0, yaw], [surge, sway, 0.0, roll, pitch, 0.0]])


def tabulated_motions(hull: HullForm | ComputedHull, period: float, b: float) -> Array:
    """Return the same from the kernel: waves towards ``b``, ship heading north."""
    found = []
    for theta in (0.0, 0.5 * math.pi):
        components = component_table(np.array([2.0 * math.pi / period]), b, 1.0, theta)
        found.append(hull_motion(components, hull.table(components), (0.0, 0.0, 0.0), AT_ORIGIN, 0.0)[0])
    return np.array(found)


@given(b=st.floats(-2.0 * math.pi, 2.0 * math.pi))
@pytest.mark.parametrize(("period", "error"), [(3.0, 2e-9), (0.8, 2e-7), (0.4, 6e-6), (0.16, 6e-4)])
def test_the_table_of_the_box_is_the_box(period: float, error: float, b: float) -> None:
    # A cubic between nodes h = pi / 180 apart errs by h^4 / 384 times the fourth derivative, (k L / 2)^4 of the motion
    # at most: 1.2e-10, 1.8e-7, 4.7e-5 of it at the first three periods. Measured over all directions: 1.5e-9, 1.5e-7
    # and 4.4e-6 m per metre of wave. The last is the shortest period in a sea of 0.8 s: the motion changes its sign
    # from one node to the next, but is 0.007 at most; measured 4.5e-4. Angles are worth their arm.
    arms = np.array([1.0, 1.0, 1.0, FORM.beam, FORM.length, FORM.length])
    difference = (tabulated_motions(FORM, period, b) - box_motions(period, b)) * arms
    assert np.abs(difference).max() < error


@given(b=st.floats(-2.0 * math.pi, 2.0 * math.pi))
def test_the_table_of_the_drift_is_the_formula(b: float) -> None:
    components = component_table(np.array([2.0 * math.pi / 0.8]), b, 0.03, 0.4)
    found = drift_force(components, FORM.table(components), (1.0, 2.0, 0.0), 3.0)
    sin_b, cos_b = math.sin(b), math.cos(b)
    per_square = np.array(FORM.drift) * [cos_b, sin_b * abs(sin_b), 2.0 * sin_b * cos_b]
    # As above with a fourth derivative of 1 to 16: 4e-9 of the largest drift, and some times it where a spline ends and
    # has no slope given; measured 2.1e-8.
    assert np.array(found) == pytest.approx(per_square * 0.03**2, abs=3e-8 * max(FORM.drift) * 0.03**2)


@pytest.mark.parametrize("b", [0.0, math.pi, -math.pi, 0.5, math.pi / 180.0, 1.0])
def test_motion_and_its_slope_are_continuous_in_the_direction(b: float) -> None:
    e = 1e-6
    at = [tabulated_motions(FORM, 0.8, b + k * e) for k in (-2.0, -1.0, 0.0, 1.0, 2.0)]
    # The second derivative is 40 of the motion and less; a jump of the slope by 1e-3 would show.
    assert np.abs(at[3] - at[1]).max() < 20.0 * 2.0 * e
    assert (at[4] - at[3]) / e == pytest.approx((at[1] - at[0]) / e, abs=1e-3)


def computed_box() -> WaveResponse:
    """Return the box as if a potential-flow code had computed it at some directions, without dimensions."""
    # Frequencies about that of 1.3 s, close enough that linear interpolation between them is good to 1e-5.
    frequency = 2.0 * math.pi / 1.3 * math.sqrt(FORM.length / GRAVITY) * np.array([0.999, 1.0, 1.001])
    heading = np.linspace(0.0, math.pi, 37)
    motion = np.zeros((3, 37, 6), dtype=np.complex128)
    drift = np.zeros((3, 37, 3))
    for i, omega in enumerate(frequency * math.sqrt(GRAVITY / FORM.length)):
        for j, b in enumerate(heading):
            at_crest, later = box_motions(2.0 * math.pi / omega, b)
            # a Re[X exp(i theta)]: Re X at theta = 0, -Im X at pi / 2.
            motion[i, j] = (at_crest - 1j * later) * ([1.0] * 3 + [FORM.length] * 3)
            force = np.array(FORM.drift) * [math.cos(b), math.sin(b) ** 2, math.sin(2.0 * b)]
            drift[i, j] = force / (VESSEL.density * GRAVITY * FORM.length * np.array([1.0, 1.0, FORM.length]))
    return WaveResponse(frequency, heading, motion, drift)


@given(b=st.floats(-math.pi, math.pi))
def test_computed_data_come_back_with_dimensions(b: float) -> None:
    computed = ComputedHull(computed_box(), FORM.length, VESSEL.density, drift_factor=0.5)
    # Five degrees apart at 1.3 s: h^4 / 384 (k L / 2)^4 = 4.5e-6 of the motion; a spline: some times it.
    assert tabulated_motions(computed, 1.3, b) == pytest.approx(tabulated_motions(FORM, 1.3, b), abs=1e-4)
    components = component_table(np.array([2.0 * math.pi / 1.3]), b, 0.03, 0.4)
    full = drift_force(components, FORM.table(components), (0.0, 0.0, 0.0), 0.0)
    half = drift_force(components, computed.table(components), (0.0, 0.0, 0.0), 0.0)
    assert np.array(half) == pytest.approx(0.5 * np.array(full), abs=1e-5 * max(FORM.drift) * 0.03**2)


@pytest.mark.parametrize("heading", [[0.0, 1.0, 2.0], [0.1, math.pi], [0.0]])
def test_directions_that_do_not_go_round_are_refused(heading: list[float]) -> None:
    with pytest.raises(InputError, match="direction: expected relative directions from 0 to pi, found"):
        response_table(np.array(heading), np.zeros((1, len(heading), FUNCTIONS)))


@pytest.mark.parametrize("b", [0.3, 1.2, 2.5, -0.8])
def test_in_long_waves_the_computed_hull_moves_as_the_box(b: float) -> None:
    """Two models of the same hull, with the same signs: the water carries both."""
    hull = ComputedHull(load_wave_response("cybership3"), FORM.length, VESSEL.density)
    arms = np.array([1.0, 1.0, 1.0, FORM.beam, FORM.length, FORM.length])
    found, box = tabulated_motions(hull, 8.0, b) * arms, tabulated_motions(FORM, 8.0, b) * arms
    # k L = 0.12. Roll is larger than the slope by its resonance; what a finite k T does differs.
    assert found[:, :5] == pytest.approx(box[:, :5], abs=0.02)
    # Yaw is of the order k L / 2 and goes with the moments of inertia, of which the box has those of its own shape.
    assert found[:, 5] == pytest.approx(box[:, 5], abs=0.04)
    assert np.abs(box).max() > 0.5


def test_a_vessel_names_its_response() -> None:
    data = VESSEL.model_dump() | {"wave_forces": {"response": "cybership3", "drift_factor": 0.5}}
    hull = hull_in_waves(Vessel.model_validate(data))
    assert isinstance(hull, ComputedHull)
    assert hull.drift_factor == 0.5
    assert isinstance(hull_in_waves(with_box_hull(VESSEL)), HullForm)
    with pytest.raises(InputError, match=r"wave_forces\.drift_coefficient: expected it in vessel 'cybership3'"):
        HullForm.of(Vessel.model_validate(data))
