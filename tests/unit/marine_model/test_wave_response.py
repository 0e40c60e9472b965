"""Wave response: the loader and its refusals, interpolation, and the shipped data against limits and symmetry."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad

from marine_model import load_vessel
from marine_model.errors import DocumentError, InputError, UnknownNameError
from marine_model.load import vessel_path
from marine_model.wave_response import WaveResponse, load_wave_response, wave_response_names
from marine_model.wave_response.columns import HEADER
from marine_model.wave_response.load import FOLDER

SHIPPED = wave_response_names()
shipped = pytest.mark.parametrize("name", SHIPPED)
SURGE, SWAY, HEAVE, ROLL, PITCH, YAW = range(6)


def rows(frequencies: list[float], headings: list[float]) -> list[str]:
    """Lines whose further numbers are all different."""
    numbers = iter(range(100, 100_000))
    return [
        ",".join([f"{f}", f"{h:.10f}", *(f"{next(numbers) / 1000}" for _ in range(15))])
        for f in frequencies
        for h in headings
    ]


LINES = ["# a comment", "#", HEADER, *rows([0.5, 1.0, 2.0], [0.0, 1.0, np.pi])]


def write(folder: Path, lines: list[str], name: str = "hull.csv") -> Path:
    path = folder / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_a_file_is_folded_into_frequency_by_heading(tmp_path: Path) -> None:
    found = load_wave_response(write(tmp_path, LINES))
    np.testing.assert_array_equal(found.frequency, [0.5, 1.0, 2.0])
    np.testing.assert_array_equal(found.heading, [0.0, 1.0, np.pi])
    assert found.motion.shape == (3, 3, 6)
    assert found.drift.shape == (3, 3, 3)
    pairs = 0.1 + 0.002 * np.arange(6)  # numbers rise by 0.001, the real part of a mode before its imaginary part
    np.testing.assert_allclose(found.motion[0, 0], pairs + 1j * (pairs + 0.001), rtol=1e-14)
    np.testing.assert_array_equal(found.drift[0, 0], [0.112, 0.113, 0.114])
    np.testing.assert_array_equal(found.drift[1, 2], [0.187, 0.188, 0.189])  # five lines of 15 numbers further
    with pytest.raises(ValueError, match="read-only"):
        found.drift[0, 0, 0] = 1.0


def replaced(line: int, old: str, new: str) -> list[str]:
    """``LINES`` with another text in one line, counted from 1."""
    changed = list(LINES)
    assert old in changed[line - 1]
    changed[line - 1] = changed[line - 1].replace(old, new, 1)
    return changed


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (LINES[:2], ":3: header: expected 'frequency,heading,surge_real.*', found 'nothing'"),
        (replaced(3, "heading", "angle"), ":3: header: expected .*found 'frequency,angle"),
        (LINES[:3], ":4: expected a line for every frequency and heading, found none"),
        (replaced(5, "0.115", "many"), ":5: surge_real: expected a number, found 'many'"),
        (replaced(5, "0.115", "nan"), ":5: surge_real: expected a finite number, found nan"),
        (replaced(6, "0.144", "inf"), ":6: drift_yaw: expected a finite number, found inf"),
        (replaced(6, ",0.144", ""), ":6: expected 17 numbers, found 16"),
        ([*LINES[:5], "", *LINES[5:]], ":6: expected 17 numbers, found 1"),
        ([*LINES[:5], "# here", *LINES[5:]], ":6: expected 17 numbers, found 1"),
        (LINES[:-1], ":10: heading: expected the 3 headings of the first frequency"),
        (replaced(8, "1.0000000000", "1.1"), ":7: heading: expected the 3 headings of the first frequency"),
        (replaced(6, "3.14", "3.13"), ":4: heading: expected to rise from 0 to pi, found 0.0 to 3.13"),
        (LINES[:6], ":4: frequency: expected at least two that rise from above 0, found 0.5"),
        (
            [*LINES[:6], *LINES[9:], *LINES[6:9]],
            ":10: frequency: expected at least two that rise from above 0, found 1.0",
        ),
        ([*LINES[:3], *rows([-0.5, 1.0], [0.0, np.pi])], ":4: frequency: expected .* found -0.5"),
    ],
)
def test_what_is_refused(tmp_path: Path, lines: list[str], message: str) -> None:
    path = write(tmp_path, lines)
    with pytest.raises(DocumentError, match=re.escape(str(path)) + message):
        load_wave_response(path)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"expected a path or one of .*cybership3.*found 'titanic'"):
        load_wave_response("titanic")
    with pytest.raises(UnknownNameError, match=r"no such file: .*none\.csv"):
        load_wave_response(tmp_path / "none.csv")
    binary = tmp_path / "hull.csv"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DocumentError, match=r"hull\.csv: cannot be read"):
        load_wave_response(binary)


# The vessel file.


def vessel_with(folder: Path, forces: str) -> Path:
    text = vessel_path("cybership3").read_text(encoding="utf-8")
    text = re.sub(r"(?ms)^wave_forces:\n.*?(?=^#|^\w)", f"wave_forces:\n{forces}\n", text)
    path = folder / "ship.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_vessel_names_its_data_file(tmp_path: Path) -> None:
    write(tmp_path, LINES)
    vessel = load_vessel(vessel_with(tmp_path, "  response: hull.csv\n  drift_factor: 1.1"))
    assert vessel.on_surface()[1].drift_factor == 1.1
    assert vessel.wave_response is not None
    np.testing.assert_array_equal(vessel.wave_response.frequency, [0.5, 1.0, 2.0])
    assert vessel.wave_response is vessel.wave_response
    by_name = load_vessel(vessel_with(tmp_path, "  response: cybership3"))
    assert by_name.wave_response is not None
    assert len(by_name.wave_response.frequency) > 3


def test_a_box_has_no_data_file(tmp_path: Path) -> None:
    assert load_vessel(vessel_with(tmp_path, "  drift_coefficient: [0.5, 0.9, 0.0]")).wave_response is None


@pytest.mark.parametrize(
    ("forces", "message"),
    [
        ("  response: none.csv", "wave_forces.response: wave response: no such file: .*none.csv"),
        ("  response: titanic", "wave_forces.response: .*expected a path or one of .*cybership3"),
        ("  drift_factor: 1.0", "wave_forces: expected either drift_coefficient or response, found neither"),
        (
            "  response: cybership3\n  drift_coefficient: [0.5, 0.9, 0.0]",
            "wave_forces: expected either drift_coefficient or response, found both",
        ),
        (
            "  drift_coefficient: [0.5, 0.9, 0.0]\n  drift_factor: 1.2",
            "wave_forces.drift_factor: expected none beside drift_coefficient, found one",
        ),
        ("  response: cybership3\n  drift_factor: 0.0", "wave_forces.drift_factor: Input should be greater than 0"),
    ],
)
def test_wave_forces_that_are_refused(tmp_path: Path, forces: str, message: str) -> None:
    with pytest.raises(DocumentError, match=r"ship\.yaml:\d+: " + message):
        load_vessel(vessel_with(tmp_path, forces))


def test_a_vessel_that_extends_one_may_go_back_to_the_box(tmp_path: Path) -> None:
    base = vessel_with(tmp_path, "  response: cybership3")
    over = tmp_path / "over.yaml"
    forces = "wave_forces: {response: null, drift_coefficient: [0.5, 0.9, 0.0]}"
    over.write_text(f"extends: {base.name}\nname: over\n{forces}\n", encoding="utf-8")
    assert load_vessel(over).wave_response is None


# Interpolation.


@given(share=st.floats(0.0, 1.0))
def test_between_frequencies_the_response_is_linear(share: float) -> None:
    response = load_wave_response("cybership3")
    low, high = response.frequency[10], response.frequency[11]
    motion, drift = response.at([low + share * (high - low)])
    # Rounding of numbers up to some 20.
    np.testing.assert_allclose(motion[0], (1 - share) * response.motion[10] + share * response.motion[11], atol=1e-12)
    np.testing.assert_allclose(drift[0], (1 - share) * response.drift[10] + share * response.drift[11], atol=1e-12)


@shipped
def test_the_response_is_continuous_and_ends_as_it_should(name: str) -> None:
    response = load_wave_response(name)
    motion, drift = response.at(response.frequency)
    np.testing.assert_allclose(motion, response.motion, atol=1e-12)
    np.testing.assert_allclose(drift, response.drift, atol=1e-12)
    lowest, highest = response.frequency[[0, -1]]
    for edge in (lowest, highest):
        inside, outside = response.at([edge * (1 - 1e-9), edge * (1 + 1e-9)])[0]
        np.testing.assert_allclose(inside, outside, atol=1e-6)
    still, push = response.at([0.0])
    np.testing.assert_allclose(still[0, :, SURGE], 1j * np.cos(response.heading), atol=1e-15)
    np.testing.assert_allclose(still[0, :, SWAY], 1j * np.sin(response.heading), atol=1e-15)
    np.testing.assert_array_equal(still[0, :, HEAVE], -1.0)
    np.testing.assert_array_equal(still[0, :, ROLL:], 0.0)
    np.testing.assert_array_equal(push, 0.0)
    far, same = response.at([10.0 * highest])
    np.testing.assert_allclose(far[0], response.motion[-1] / 100.0, rtol=1e-12)
    np.testing.assert_array_equal(same[0], response.drift[-1])


@pytest.mark.parametrize("wrong", [[-0.1], [np.nan], [np.inf], [[1.0]]])
def test_frequencies_that_are_refused(wrong: list[float]) -> None:
    with pytest.raises(InputError, match="frequency: expected finite numbers of at least 0"):
        load_wave_response("cybership3").at(wrong)


# The shipped data. Numbers are written to five decimals.

DECIMALS = 1e-5


def said(name: str, pattern: str) -> float:
    """A number out of the comments of a data file."""
    found = re.search(pattern, (FOLDER / f"{name}.csv").read_text(encoding="utf-8"))
    assert found is not None, pattern
    return float(found.group(1))


@shipped
def test_in_long_waves_the_hull_goes_with_the_water(name: str) -> None:
    """As the box does: particle displacement averaged over the draught, slopes of the surface, and a yaw that follows.

    The yaw of a slender hull is the slope of the sway of the water, -k a sin b cos b; a hull of some breadth resists
    it, and a box turns (L^2 - B^2) / (L^2 + B^2) of it.
    """
    response = load_wave_response(name)
    kl = response.frequency[0] ** 2
    assert kl < 0.1
    b = response.heading
    x = response.motion[0]
    draught = said(name, r"T ([\d.]+) m") / said(name, r"L ([\d.]+) m")
    slenderness = said(name, r"B ([\d.]+) m") / said(name, r"L ([\d.]+) m")
    depth = -np.expm1(-kl * draught) / (kl * draught)
    # Of the order of kL times the share of beam or draught in the length; and (kL)^2 / 24 from the finite length.
    close = 0.25 * kl
    np.testing.assert_allclose(x[:, SURGE], 1j * depth * np.cos(b), atol=close)
    np.testing.assert_allclose(x[:, SWAY], 1j * depth * np.sin(b), atol=close)
    np.testing.assert_allclose(x[:, HEAVE], -depth, atol=close)
    # Slopes, which the resonance of roll raises by (frequency over natural frequency)^2 and the depth lowers.
    np.testing.assert_allclose(x[:, PITCH], 1j * kl * np.cos(b), atol=0.1 * kl)
    np.testing.assert_allclose(x[:, ROLL], -1j * kl * np.sin(b), atol=0.1 * kl)
    turned = (1 - slenderness**2) / (1 + slenderness**2)
    np.testing.assert_allclose(x[:, YAW], -kl * turned * np.sin(b) * np.cos(b), atol=0.1 * kl)


@shipped
def test_fore_and_aft_symmetry(name: str) -> None:
    response = load_wave_response(name)
    np.testing.assert_allclose(response.heading[::-1], np.pi - response.heading, atol=1e-9)
    mirrored = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
    np.testing.assert_allclose(response.motion[:, ::-1] * mirrored, response.motion, atol=2 * DECIMALS)
    np.testing.assert_allclose(response.drift[:, ::-1] * mirrored[[0, 1, 5]], response.drift, atol=2 * DECIMALS)


@shipped
def test_symmetry_to_port_and_starboard(name: str) -> None:
    response = load_wave_response(name)
    middle = len(response.heading) // 2
    assert response.heading[middle] == pytest.approx(np.pi / 2)
    for end in (0, -1):
        np.testing.assert_allclose(response.motion[:, end, [SWAY, ROLL, YAW]], 0.0, atol=DECIMALS)
        np.testing.assert_allclose(response.drift[:, end, 1:], 0.0, atol=DECIMALS)
    np.testing.assert_allclose(response.drift[:, middle, [0, 2]], 0.0, atol=DECIMALS)


def waterline_slope(name: str) -> tuple[float, float]:
    """Breadth over length, and exponent n, of the half breadth (B / 2) (1 - |xi|^n)."""
    waterplane = said(name, r"C_W ([\d.]+)")
    beam = said(name, r"B ([\d.]+) m") / said(name, r"L ([\d.]+) m")
    return beam, waterplane / (1.0 - waterplane)


@shipped
def test_short_waves_are_reflected_by_the_waterline(name: str) -> None:
    """Faltinsen's limit: 1/2 rho g a^2 sin^2 of the angle between waves and waterline, along its normal.

    Beam seas: a wall would take 1/2 rho g L a^2. The sides are not quite walls, and the last wave of the table, an
    eighth of the length, is not yet short: a tenth. In head seas only the ends count, and they are as short as this
    wave and not upright: a fifth.
    """
    beam, n = waterline_slope(name)
    response = load_wave_response(name)
    last = response.drift[-1]

    def slope(xi: float) -> float:
        return float(beam * n * xi ** (n - 1.0))

    side, _ = quad(lambda xi: 1.0 / (1.0 + slope(xi) ** 2), 0.0, 1.0)
    end, _ = quad(lambda xi: slope(xi) ** 3 / (1.0 + slope(xi) ** 2), 0.0, 1.0)
    assert last[len(last) // 2, 1] == pytest.approx(0.5 * side, rel=0.1)
    assert last[-1, 0] == pytest.approx(-0.5 * end, rel=0.2)


@shipped
def test_drift_goes_with_the_waves_and_no_further_than_total_reflection(name: str) -> None:
    response = load_wave_response(name)
    b = response.heading
    along = response.drift[..., 0] * np.cos(b) + response.drift[..., 1] * np.sin(b)
    assert along.min() > -20 * DECIMALS
    # A wall as wide as the ship looks from there reflects 1/2 rho g a^2 of its width; heave and pitch at resonance send
    # out more.
    beam, _ = waterline_slope(name)
    width = np.abs(np.sin(b)) + beam * np.abs(np.cos(b))
    assert (along[response.frequency > 5.0] <= 0.5 * width).all()


@shipped
def test_the_resonances_are_resolved(name: str) -> None:
    """A straight line between the neighbours of a frequency predicts what is there."""
    response = load_wave_response(name)
    for values, largest in ((response.motion, 0.06), (response.drift, 0.06)):
        f = response.frequency
        share = ((f[1:-1] - f[:-2]) / (f[2:] - f[:-2]))[:, None, None]
        missed = np.abs((1 - share) * values[:-2] + share * values[2:] - values[1:-1])
        # Interpolation over twice the distance misses four times as much as that over one.
        assert (missed.max(axis=(0, 1)) / 4.0 <= largest * np.abs(values).max(axis=(0, 1))).all()


def by_symmetry(response: WaveResponse, i: int) -> NDArray[np.float64]:
    return np.concatenate([response.drift[i], response.drift[i, -2:0:-1] * [1.0, -1.0, -1.0]])


@shipped
def test_no_direction_drives_a_ship_that_is_pushed_from_all_sides(name: str) -> None:
    """The mean over all headings of the force in body axes is zero for a hull symmetric both ways."""
    response = load_wave_response(name)
    for i in range(len(response.frequency)):
        np.testing.assert_allclose(by_symmetry(response, i).mean(axis=0), 0.0, atol=1e-4)
