"""Froude's law on vessels."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.froude import FroudeLaw, scaled
from marine_model.section_text import section_text
from marine_model.yaml_document import read_yaml

# Numbers are written to 12 digits: the largest relative error of one is 5e-12.
_DIGITS = 1e-11
# 0.5 ns in the time step of 0.02 s, and a factor 2 for what is derived from it.
_STEP = 1e-9 / 0.02


@pytest.fixture(scope="module")
def model() -> Vessel:
    return load_vessel("cybership3")


@pytest.fixture(scope="module")
def ship() -> Vessel:
    return load_vessel("cybership3_full_scale")


def test_thrusts_of_table_4_2(ship: Vessel) -> None:
    """[Ruth] Table 4.2 prints 16, 235, 365 and 351 kN: 30^3 times its model's, with the density of fresh water kept."""
    assert [round(float(thrust) * 1e-3) for thrust in ship.thrust_max] == [16, 235, 364, 351]
    # 364.5 kN exactly, printed as 365.
    np.testing.assert_array_equal(ship.thrust_max, [15660.0, 234900.0, 364500.0, 351000.0])
    assert ship.density == 1000.0


def test_turning_rate_of_section_4_5(ship: Vessel) -> None:
    """[Ruth] 4.5: 0.21 rad a sample of 0.2 s is 11 deg/s at full scale."""
    assert [round(rate) for rate in np.degrees(ship.azimuth_rate)] == [0, 11, 11, 11]


def test_factors() -> None:
    law = FroudeLaw(30.0)
    root = math.sqrt(30.0)
    assert law.time == pytest.approx(root)
    for unit, factor in (
        ("m", 30.0),
        ("N", 30.0**3),
        ("N m", 30.0**4),
        ("W", 30.0**3.5),
        ("kg m^2", 30.0**5),
        ("Hz", 1.0 / root),
        ("N s/m", 30.0**2 * root),
        ("rad", 1.0),
    ):
        assert law.factor(unit) == pytest.approx(factor, rel=1e-14), unit


def test_vectors_and_matrices_by_element() -> None:
    law = FroudeLaw(4.0)
    assert law.value((1.0, 1.0, 1.0), "m, m, rad") == (4.0, 4.0, 1.0)
    assert law.value(((1.0, 2.0), (3.0, 4.0)), "N; m") == ((64.0, 128.0), (12.0, 16.0))
    assert law.value([1.0, 2.0], "s") == [2.0, 4.0]
    assert law.value(True, "s") is True
    with pytest.raises(InputError, match="unit: expected one for all or 2, found 'm, m, rad'"):
        law.value([1.0, 2.0], "m, m, rad")


def test_time_step_is_whole_nanoseconds(ship: Vessel, model: Vessel) -> None:
    nanoseconds = ship.simulation.time_step * 1e9
    assert nanoseconds == pytest.approx(round(nanoseconds), abs=1e-6)  # rounding of the product
    assert ship.simulation.time_step == pytest.approx(model.simulation.time_step * math.sqrt(30.0), rel=_STEP)
    assert ship.measurement.sample_time == pytest.approx(10 * ship.simulation.time_step, rel=1e-15)


@given(ratio=st.floats(0.05, 200.0))
def test_there_and_back(ratio: float) -> None:
    model = load_vessel("cybership3")
    back = scaled(scaled(model, ratio), 1.0 / ratio)
    assert back.scale == pytest.approx(model.scale, rel=_DIGITS)
    for found, wanted in (
        (back.thrust_max, model.thrust_max),
        (back.thrust_rate, model.thrust_rate),
        (np.array(back.on_surface()[0].added_mass), np.array(model.on_surface()[0].added_mass)),
        (np.array(back.observer.bias_gain), np.array(model.observer.bias_gain)),
        (np.array(back.allocator.slack_weight), np.array(model.allocator.slack_weight)),
    ):
        np.testing.assert_allclose(found, wanted, rtol=_DIGITS)


def test_a_ratio_that_is_none_is_refused(model: Vessel) -> None:
    with pytest.raises(InputError, match="length_ratio"):
        scaled(model, 0.0)
    with pytest.raises(InputError, match="length_ratio: expected a time step of 1 ns or more"):
        scaled(model, 1e-17)


def test_text_reads_back_the_same(ship: Vessel, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("text") / "ship.yaml"
    path.write_text(section_text(ship, "two\nlines"), encoding="utf-8")
    assert path.read_text(encoding="utf-8").startswith("# two\n# lines\nname: cybership3_full_scale\n")
    assert read_yaml(path).validate(Vessel) == ship


def test_a_submerged_vehicle_is_not_scaled() -> None:
    with pytest.raises(InputError, match="vessel: expected one on the surface, found 'ukwial', which is submerged"):
        scaled(load_vessel("ukwial"), 2.0)
