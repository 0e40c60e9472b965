"""The torque that a code means: equilibrium of motor and propeller, [Kostenko] (1)-(3), against Table 2."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from marine_model import load_vessel
from marine_model.code_maps import CodeDrive
from marine_model.errors import DocumentError, InputError
from support.marching_thruster import DENSITY, MODEL, SPEEDS, TESTED_CODES, drive, drive_data

DRIVE = drive()
THRUST = DRIVE.thrust_from_code


def points() -> list[tuple[int, int, float, float]]:
    """Code, column of the speed, shaft speed and torque that Tables 1 and 2 mean, where code and speed give thrust.

    (4) gives the thrust, (1) with K_T the shaft speed, (1) with K_M the torque.
    """
    found = []
    for code in TESTED_CODES:
        for i, speed in enumerate(SPEEDS):
            thrust = THRUST.thrust(code, speed)
            if thrust > 0.0:
                n = brentq(lambda n: float(MODEL.forces(n, speed, DENSITY)[0]) - thrust, 0.5, 60.0, xtol=1e-13)  # noqa: B023
                found.append((code, i, n, float(MODEL.forces(n, speed, DENSITY)[1])))
    return found


POINTS = points()


def equilibrium(of: CodeDrive, code: int, speed: float) -> float:
    """Return the shaft speed at which (3) holds."""
    return float(brentq(lambda n: of.torque(code, n) - float(MODEL.forces(n, speed, DENSITY)[1]), 0.01, 60.0))


def residuals(of: CodeDrive) -> list[tuple[float, float]]:
    """Largest and rms of thrust in equilibrium less that of Table 2, at every speed, over codes that give thrust."""
    found = []
    for i, speed in enumerate(SPEEDS):
        errors = [
            float(MODEL.forces(equilibrium(of, code, speed), speed, DENSITY)[0]) - THRUST.thrust(code, speed)
            for code, column, _, _ in POINTS
            if column == i
        ]
        found.append((float(np.abs(errors).max()), math.sqrt(float(np.mean(np.square(errors))))))
    return found


def test_torque_of_a_code_falls_with_the_shaft_speed() -> None:
    """The shape that comes out: nearly straight lines that fall by 0.037 to 0.045 N m/Hz from code 50 on.

    A drive whose torque belongs to the code alone would have lines that do not fall.
    """
    slopes = {}
    for code in TESTED_CODES:
        n, torque = np.array([(n, torque) for c, _, n, torque in POINTS if c == code]).T
        if len(n) > 2:
            slopes[code], intercept = np.polyfit(n, torque, 1)
            assert np.abs(slopes[code] * n + intercept - torque).max() < 0.019  # N m, of 0.1 to 0.7
    for code, slope in slopes.items():
        if code >= 50:
            assert -0.045 < slope < -0.037
    assert slopes[40] < -0.09  # three points close to the dead zone: there (4) and (2) do not go together
    # As a number: code 127, at rest 28.20 Hz and 0.732 N m, at 2 m/s 33.03 Hz and 0.527 N m.
    at_127 = {i: (n, torque) for code, i, n, torque in POINTS if code == 127}
    assert at_127[0] == pytest.approx((28.20, 0.7317), abs=6e-3)
    assert at_127[4] == pytest.approx((33.03, 0.5274), abs=6e-3)


def test_the_droop_in_the_file_is_the_least_squares_one() -> None:
    """Of all 50 points, with the lines held to the point at rest: 0.0430186 N m/Hz."""
    rest = {code: (n, torque) for code, i, n, torque in POINTS if i == 0}
    assert len(POINTS) == 50
    n, torque = np.array([(n - rest[code][0], torque - rest[code][1]) for code, _, n, torque in POINTS]).T
    droop = -float(n @ torque) / float(n @ n)
    assert droop == pytest.approx(0.0430186, abs=5e-8)
    assert drive_data().torque_droop == round(droop, 4)


def test_at_rest_a_code_has_the_thrust_of_4_exactly() -> None:
    for code in TESTED_CODES:
        n = equilibrium(DRIVE, code, 0.0)
        assert n == pytest.approx(DRIVE.rest_shaft_speed(code), rel=1e-9)
        assert float(MODEL.forces(n, 0.0, DENSITY)[0]) == pytest.approx(THRUST.thrust(code, 0.0), rel=1e-8)


def test_thrust_in_equilibrium_against_table_2() -> None:
    """Largest and rms, N, at 0, 0.5, 1, 1.5 and 2 m/s, as they come out; the same without the droop."""
    found = residuals(DRIVE)
    assert [largest for largest, _ in found] == pytest.approx([0.0, 0.377, 0.717, 0.169, 0.437], abs=1e-3)
    assert [rms for _, rms in found] == pytest.approx([0.0, 0.317, 0.618, 0.093, 0.334], abs=1e-3)
    constant = residuals(drive_data().model_copy(update={"torque_droop": 0.0}).build(MODEL, DENSITY))
    assert [largest for largest, _ in constant] == pytest.approx([0.0, 2.75, 5.89, 8.39, 11.40], abs=6e-3)


def test_thrust_in_equilibrium_over_all_codes() -> None:
    """Every code that Table 2 gives thrust: largest difference, N, at 0, 0.5, 1, 1.5 and 2 m/s, near the dead zone."""
    found = []
    for speed in SPEEDS:
        codes = range(math.ceil(THRUST.dead_zone(speed)), 128)
        thrust = [float(MODEL.forces(equilibrium(DRIVE, code, speed), speed, DENSITY)[0]) for code in codes]
        found.append(max(abs(T - THRUST.thrust(code, speed)) for T, code in zip(thrust, codes, strict=True)))
    assert found == pytest.approx([0.0, 0.395, 0.871, 0.236, 0.440], abs=1e-3)


def test_a_motor_at_a_voltage_would_do_as_well() -> None:
    """M = a N - b n, both fitted, for comparison: what a motor at a voltage of a code's share would have."""
    codes, _, n, torque = np.array(POINTS).T
    terms = np.stack([codes, -n], axis=1)
    (a, b), *_ = np.linalg.lstsq(terms, torque, rcond=None)
    assert [a, b] == pytest.approx([0.01377, 0.03669], abs=1e-5)
    assert np.abs(terms @ (a, b) - torque).max() == pytest.approx(0.0607, abs=1e-4)
    errors: dict[int, list[float]] = {i: [] for i in range(len(SPEEDS))}
    for code, i, _, _ in POINTS:
        speed = SPEEDS[i]

        def left(n: float, code: int = code, speed: float = speed) -> float:
            return a * code - b * n - float(MODEL.forces(n, speed, DENSITY)[1])

        thrust = float(MODEL.forces(brentq(left, 0.01, 60.0), speed, DENSITY)[0])
        errors[i].append(thrust - THRUST.thrust(code, speed))
    assert [np.abs(e).max() for e in errors.values()] == pytest.approx([0.796, 0.376, 0.592, 0.291, 0.302], abs=1e-3)


def test_torque_is_odd_and_falls_back_without_a_shaft_speed() -> None:
    for code in (0, 5, 50, 127):
        for n in (-40.0, 0.0, 12.5, 40.0):
            assert DRIVE.torque(-code, -n) == -DRIVE.torque(code, n)
        for lost in (math.nan, math.inf):
            assert DRIVE.torque(code, lost) == DRIVE.torque(code, DRIVE.rest_shaft_speed(code))
    # By hand at 127 and 30 Hz: T = 42.484 N, M_0 = 0.0171 / 0.139 * 0.14 T = 0.73170, n_0 = 28.197.
    assert DRIVE.torque(127, 30.0) == pytest.approx(0.73170 - 0.0430 * (30.0 - 28.197), abs=5e-5)
    # In the dead zone the motor asks for nothing but stands against being turned.
    assert DRIVE.torque(10, 0.0) == 0.0
    assert DRIVE.torque(10, 2.0) == pytest.approx(-0.086, rel=1e-12)


def test_a_drive_needs_numbers_that_make_sense() -> None:
    maps = (DRIVE.thrust_from_code, DRIVE.code_from_thrust, DRIVE.rest_code_from_thrust)
    with pytest.raises(InputError, match="torque_droop: expected a number not below 0, found -1"):
        CodeDrive(*maps, MODEL, DENSITY, -1.0)
    with pytest.raises(InputError, match="density: expected a number above 0"):
        CodeDrive(*maps, MODEL, 0.0)


def test_a_vessel_file_names_the_file_of_its_drives(tmp_path) -> None:
    file = tmp_path / "mine.yaml"
    text = "extends: mmt300\nthrusters:\n  - name: upper\n    drive: {file: at_drive_50x14.yaml}\n"
    file.write_text(text, encoding="utf-8")
    vessel = load_vessel(file)
    assert vessel.thrusters[0].drive == drive_data()
    (tmp_path / "own.yaml").write_text("code_max: 127\nspeed: [0.0]\n", encoding="utf-8")
    file.write_text(text.replace("at_drive_50x14.yaml", "own.yaml"), encoding="utf-8")
    with pytest.raises(DocumentError, match=r"own\.yaml:\d+: thrusters\.0\.drive\."):
        load_vessel(file)
    file.write_text(text.replace("{file: at_drive_50x14.yaml}", "{file: nowhere.yaml}"), encoding="utf-8")
    with pytest.raises(DocumentError, match=r"mine\.yaml:4: thrusters\.0\.drive\.file: expected a file beside"):
        load_vessel(file)
    file.write_text(text.replace("{file: at_drive_50x14.yaml}", "{file: 3}"), encoding="utf-8")
    with pytest.raises(DocumentError, match="expected a file name, found 3"):
        load_vessel(file)
