"""Section ``underwater`` of a vessel file: what it means, and what is no body."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.integrate import quad

from marine_model import load_vessel
from marine_model.constants import GRAVITY
from marine_model.errors import DocumentError
from marine_model.load import vessel_path
from marine_model.underwater import UnderwaterBody

NAMES = ("ukwial", "ukwial_azimuth", "mmt300")
BODY = UnderwaterBody(
    buoyancy=1960.0,
    centre_of_gravity=(0.1, -0.2, 0.3),
    centre_of_buoyancy=(0.0, 0.0, -0.1),
    inertia=((40.0, 0.0, 0.0), (0.0, 60.0, 0.0), (0.0, 0.0, 70.0)),
    added_mass=(100.0, 180.0, 220.0, 8.0, 15.0, 14.0),
    linear_damping=(20.0,) * 6,
    quadratic_damping=(0.0,) * 6,
)


def refusal(folder: Path, name: str, *changes: tuple[tuple[Any, ...], Any]) -> str:
    content = yaml.safe_load(vessel_path(name).read_text(encoding="utf-8"))
    for place, value in changes:
        part = content
        for key in place[:-1]:
            part = part[key]
        part[place[-1]] = value
    path = folder / "vehicle.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    with pytest.raises(DocumentError) as caught:
        load_vessel(path)
    return str(caught.value)


def test_mass_matrix_is_the_momentum_of_a_body_that_turns_about_its_origin() -> None:
    """p = m (v + w x r_g), and about the origin I_o w + r_g x m v."""
    r, v, w = np.array([0.1, -0.2, 0.3]), np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.7, -0.4])
    momentum = BODY.rigid_body_mass(200.0) @ np.concatenate([v, w])
    linear = 200.0 * (v + np.cross(w, r))
    angular = np.array(BODY.inertia) @ w + np.cross(r, 200.0 * v)
    np.testing.assert_allclose(momentum, np.concatenate([linear, angular]), rtol=1e-12)
    np.testing.assert_array_equal(
        BODY.total_mass(200.0) - BODY.rigid_body_mass(200.0), np.diag([100.0, 180.0, 220.0, 8.0, 15.0, 14.0])
    )


def test_righting_moment() -> None:
    assert BODY.righting_moment(200.0) == pytest.approx(200.0 * GRAVITY * 0.3 + 1960.0 * 0.1, rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_shipped_bodies_are_bodies(name: str) -> None:
    vessel = load_vessel(name)
    body = vessel.underwater
    assert body is not None
    mass = body.total_mass(vessel.hull.mass)
    np.testing.assert_array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass)[0] > 0.0
    assert body.righting_moment(vessel.hull.mass) > 0.0
    # Not heavier than the water in a box around it.
    hull = vessel.hull
    assert body.buoyancy < vessel.density * GRAVITY * hull.length * hull.beam * hull.draught


def test_what_is_no_body_is_refused(tmp_path: Path) -> None:
    inertia = ("underwater", "inertia")
    text = refusal(tmp_path, "ukwial", (inertia, [[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    assert "underwater: inertia must be symmetric" in text
    text = refusal(tmp_path, "ukwial", (inertia, [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]))
    assert "underwater: inertia must be positive definite" in text
    text = refusal(tmp_path, "ukwial", (("underwater", "centre_of_gravity"), [0.0, 0.0, 0.5]))
    assert "underwater.inertia: expected more than the mass has in its centre of gravity" in text
    text = refusal(tmp_path, "ukwial", (("underwater", "buoyancy"), 2.0))
    assert "underwater.buoyancy: expected the weight of hull.mass, " in text
    assert "within 10%, found 2.0 N" in text
    text = refusal(
        tmp_path,
        "ukwial",
        (("underwater", "linear_damping", 1), 0.0),
        (("underwater", "quadratic_damping", 1), 0.0),
    )
    assert "underwater.linear_damping.1: expected above 0 here or in quadratic_damping, found 0" in text
    text = refusal(tmp_path, "ukwial", (("underwater", "added_mass"), [1.0, 1.0, 1.0]))
    assert "underwater.added_mass" in text


def test_what_nothing_rights_is_refused(tmp_path: Path) -> None:
    top_heavy = (("underwater", "centre_of_buoyancy"), [0.0, 0.0, 0.2])
    text = refusal(tmp_path, "ukwial", top_heavy)
    assert "nothing else rights it in roll and pitch, found a moment of" in text
    assert "nothing else rights it in roll, found" in refusal(tmp_path, "mmt300", top_heavy)


def ellipsoid(length: float, beam: float, height: float) -> tuple[list[float], list[float]]:
    """Added mass over displaced mass, and added inertia over displaced mass: Lamb, art. 114, 115."""
    axes = np.array([length, beam, height]) / 2.0

    def factor(i: int) -> float:
        """Lamb's alpha_0, beta_0, gamma_0."""

        def part(x: float) -> float:
            return float(np.prod(axes) / ((axes[i] ** 2 + x) * np.sqrt(np.prod(axes**2 + x))))

        return float(quad(part, 0.0, np.inf)[0])

    a = [factor(i) for i in range(3)]
    squares = axes**2
    turning = []
    for i, j in ((1, 2), (0, 2), (0, 1)):
        difference, total, slope = squares[i] - squares[j], squares[i] + squares[j], a[j] - a[i]
        round_about = abs(difference) < 1e-12
        turning.append(0.0 if round_about else difference**2 * slope / (2 * difference - total * slope) / 5.0)
    return [x / (2.0 - x) for x in a], turning


def test_a_sphere_carries_half_of_its_water() -> None:
    along, turning = ellipsoid(1.0, 1.0, 1.0)
    np.testing.assert_allclose(along, 0.5, rtol=1e-9)
    assert turning == [0.0] * 3


@pytest.mark.parametrize("name", NAMES)
def test_estimates_are_those_of_the_formulas_that_the_files_name(name: str) -> None:
    vessel = load_vessel(name)
    hull, body = vessel.hull, vessel.underwater
    assert body is not None
    size = np.array([hull.length, hull.beam, hull.draught])
    along, turning = ellipsoid(*size)
    offset = hull.mass * np.array(body.centre_of_gravity)[2] ** 2 * np.array([1.0, 1.0, 0.0])
    across = size[[1, 0, 0]] ** 2 + size[[2, 2, 1]] ** 2
    if name == "mmt300":
        water, scale = vessel.density * np.pi / 6.0 * size.prod(), 1.0
        inertia = hull.mass * across / 20.0
        cylinder = 0.5 * vessel.density * 1.1 * hull.beam * hull.length
        drag = [*(cylinder,) * 2, *(cylinder * hull.length**3 / 32.0,) * 2]
        quadratic = np.array(body.quadratic_damping)[[1, 2, 4, 5]]
        # The balance at 2 m/s with T_max of Table 4.
        left = 4.0 * 24.8 * np.cos(np.radians(22.5))
        assert body.quadratic_damping[0] * 4.0 + body.linear_damping[0] * 2.0 == pytest.approx(left, rel=0.002)
        assert body.fins is not None
        helmbold = 2.0 * np.pi * 2.0 / (2.0 + np.sqrt(2.0**2 + 4.0))
        assert body.fins.sway == pytest.approx(0.5 * vessel.density * 0.08 * helmbold, rel=0.002)
        assert body.fins.heave == body.fins.sway
    else:
        # Of the proportions of the hull and the displaced volume: lengths go with the third root.
        water = hull.mass
        scale = (water / (vessel.density * np.pi / 6.0 * size.prod())) ** (2.0 / 3.0)
        inertia = hull.mass * across / 12.0
        half = 0.5 * vessel.density * 1.05
        length, beam, height = size.tolist()
        turned = [length * (height**4 + beam**4), beam * (length**4 + height**4), height * (length**4 + beam**4)]
        drag = [half * a for a in (beam * height, length * height, length * beam)] + [half * t / 32.0 for t in turned]
        quadratic = np.array(body.quadratic_damping)
    # The files are written to three digits, or one decimal.
    np.testing.assert_allclose(body.added_mass[:3], np.array(along) * water, rtol=0.005, atol=0.05)
    np.testing.assert_allclose(body.added_mass[3:], np.array(turning) * water * scale, rtol=0.005, atol=0.05)
    np.testing.assert_allclose(np.diag(body.inertia), inertia + offset, rtol=0.005, atol=0.05)
    np.testing.assert_allclose(quadratic, drag, rtol=0.005)
    np.testing.assert_allclose(body.linear_damping, 0.1 * np.array(body.quadratic_damping), rtol=0.02, atol=0.03)
