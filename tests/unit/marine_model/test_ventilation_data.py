"""Section `ventilation` of a vessel file: Table 2.5 as it is, and what contradicts itself is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from marine_model import load_vessel
from marine_model.errors import DocumentError
from marine_model.ventilation import VentilationData, table
from marine_model.ventilation.static import VentilationModel, thrust_loss


def table_2_5() -> VentilationData:
    data = load_vessel("cybership3").ventilation
    assert data is not None
    return data


DATA = table_2_5()


def with_changes(**changes: float) -> VentilationData:
    return VentilationData(**(DATA.model_dump() | changes))


def test_table_2_5_of_the_thesis() -> None:
    assert DATA.model_dump() == {
        "a_08_plus": 1.1749,
        "b_08_plus": -0.4134,
        "a_08_minus": -0.0832,
        "b_08_minus": 0.8739,
        "a_02_plus": 1.3173,
        "b_02_plus": 0.1220,
        "a_02_minus": -0.8161,
        "b_02_minus": 2.2007,
        "beta_tw_max": 1.0,
        "beta_tw_min": 0.05,
        "a_q": 0.87,
        "b_q": 0.13,
        "thrust_rise_rate": 1.0,
        "torque_rise_rate": 1.0,
        "time_shift": 0.064,
    }


def test_the_row_has_every_field_once() -> None:
    row = DATA.row()
    assert tuple(DATA.model_dump()) == table.NAMES
    assert row.tolist() == list(DATA.model_dump().values())
    assert row.shape == (table.WIDTH,)
    for name, column in ((name.upper(), i) for i, name in enumerate(table.NAMES)):
        assert getattr(table, name) == column
    with pytest.raises(ValueError, match="read-only"):
        row[0] = 0.0


def test_where_the_minus_band_ends() -> None:
    # -0.0832 x + 0.8739 = -0.8161 x + 2.2007 at x = 1.3268 / 0.7329.
    assert DATA.minus_end == pytest.approx(1.810342, abs=1e-6)
    assert with_changes(a_02_minus=-0.0832).minus_end == math.inf


def test_a_vessel_may_have_no_ventilation(tmp_path: Path) -> None:
    path = tmp_path / "ship.yaml"
    path.write_text("extends: cybership3\nname: ship\nventilation: null\n", encoding="utf-8")
    vessel = load_vessel(path)
    assert vessel.ventilation is None
    assert vessel.ventilation_row is None
    np.testing.assert_array_equal(load_vessel("cybership3").ventilation_row, DATA.row())


def test_a_bad_field_is_named_with_its_place_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "ship.yaml"
    path.write_text("extends: cybership3\nname: ship\nventilation: {beta_tw_min: 1.0}\n", encoding="utf-8")
    with pytest.raises(DocumentError, match=r"ventilation\.beta_tw_min: expected less than beta_tw_max, found 1\.0"):
        load_vessel(path)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"beta_tw_min": 0.9, "beta_tw_max": 0.8}, "expected less than beta_tw_max, found 0.9 and 0.8"),
        ({"b_q": 0.2}, r"a_q beta_Tw \+ b_q in \[0, 1\].*found 0.2435 to 1.07"),
        ({"b_q": -0.1}, r"a_q beta_Tw \+ b_q in \[0, 1\].*found -0.0565 to 0.77"),
        ({"a_q": -0.1}, "a_q"),
        ({"beta_tw_max": 1.1}, "beta_tw_max"),
        ({"thrust_rise_rate": 0.0}, "thrust_rise_rate"),
        ({"time_shift": -0.01}, "time_shift"),
        # At x = -1 the plus band is 0.1220 - 1.3173 - (-0.4134 - 1.1749) = 0.393 wide.
        ({"b_02_plus": -0.2711}, "0.2 line above the 0.8 line of the plus band at h/R = -1"),
        ({"a_02_plus": 1.17}, "expected at least a_08_plus, found 1.17 and 1.1749"),
        ({"a_08_plus": -0.1, "b_08_plus": -2.0}, "line of beta_tw_max in the plus band not to fall"),
        # 0.2 line over the 0.8 line of the minus band at x = -1: 3.0168 against 0.9571.
        ({"b_02_minus": 0.1}, "0.2 line above the 0.8 line of the minus band at h/R = -1"),
        # A minus band that closes at x = 0.6634, where the plus band is at its minimum at F_nh2 = 0.8187.
        ({"a_02_minus": -2.0832}, r"meet at h/R = 0.6634, F_nh2 = 0.8187.*; expected no loss in the plus band"),
        ({"b_08_minus": 0.2}, r"at rest would ventilate: expected no loss at F_nh2 = 0"),
    ],
)
def test_what_contradicts_itself_is_refused(changes: dict[str, float], problem: str) -> None:
    with pytest.raises(ValidationError, match=problem):
        with_changes(**changes)


def test_the_limits_of_what_is_accepted() -> None:
    with_changes(a_02_plus=1.1749)  # plus lines that are parallel
    with_changes(beta_tw_min=0.0, a_q=1.0, b_q=0.0)
    with_changes(a_02_minus=-0.0832)  # minus lines that are parallel: the band never ends
    with_changes(time_shift=0.0)


def test_an_accepted_map_is_continuous_where_the_minus_band_ends() -> None:
    # 1.3268 / 0.8668 = 1.5307, where the plus band has no loss up to F_nh2 = 1.134 and the minus lines meet at 0.747.
    data = with_changes(a_02_minus=-0.95)
    end = data.minus_end
    model = VentilationModel(data)
    speed = np.linspace(0.0, 40.0, 2001)
    assert data.minus_end == pytest.approx(1.5307, abs=1e-4)
    below, above = (model.loss_factors(speed, 0.25, 1.0, end + e).thrust_wetted for e in (-1e-9, 1e-9))
    # beta_Tw changes by less than 2.3 for a change of 1 in h/R, F_nh2 held, in the plus band.
    np.testing.assert_allclose(below, above, rtol=0.0, atol=1e-8)


LINES = table.NAMES[:8]


@settings(suppress_health_check=[HealthCheck.filter_too_much])
@given(
    changes=st.tuples(*(st.floats(-0.6, 0.6) for _ in LINES)),
    lowest=st.floats(0.0, 0.5),
    froude=st.floats(0.0, 6.0),
    more=st.floats(0.0, 3.0),
    x=st.floats(-0.999, 6.0),
)
def test_whatever_is_accepted_is_a_map(
    changes: tuple[float, ...], lowest: float, froude: float, more: float, x: float
) -> None:
    fields = {name: getattr(DATA, name) + change for name, change in zip(LINES, changes, strict=True)}
    try:
        data = with_changes(**fields, beta_tw_min=lowest)
    except ValidationError:
        reject()
    row = data.row()
    beta = thrust_loss(row, froude, x)
    assert lowest <= beta <= 1.0
    # Falling with the Froude number, no loss at rest. Where a band closes its slope and with it the rounding grows.
    assert thrust_loss(row, froude + more, x) <= beta
    assert thrust_loss(row, 0.0, x) == pytest.approx(1.0, abs=1e-9)
    end = data.minus_end
    if math.isfinite(end):
        below, above = thrust_loss(row, froude, end - 1e-9), thrust_loss(row, froude, end + 1e-9)
        # Slope over x of the plus band, whose Froude number over width is at most 10 where it is not at a limit.
        width = data.line("plus", 0.2)(end) - data.line("plus", 0.8)(end)
        steepest = 0.6 / width * (abs(data.a_08_plus) + abs(data.a_02_plus - data.a_08_plus) * 10.0 / width)
        assert below == pytest.approx(above, abs=1e-8 + 2e-9 * steepest)
    if x >= end:
        assert thrust_loss(row, froude, x + more) >= beta - 1e-12
