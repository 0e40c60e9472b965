"""A propeller quadratic in the advance number: [Kostenko] (1)-(2) with Table 1."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from marine_model.errors import InputError
from marine_model.propellers import PolynomialPropeller
from marine_model.propellers.sections import PropellerData

THRUST, TORQUE = (0.139, -0.155, -0.061), (0.0171, -0.0164, -0.0055)
TABLE_1 = PolynomialPropeller(0.14, 0.60, THRUST, TORQUE)
RHO = 102.0 * 9.81  # (1): kg s^2/m^4 times g
SECTION = {
    "model": "polynomial",
    "diameter": 0.14,
    "pitch_ratio": 0.6,
    "thrust_polynomial": list(THRUST),
    "torque_polynomial": list(TORQUE),
}


def test_equations_1_and_2_by_hand() -> None:
    """At 25 Hz and 1 m/s: J = 1 / 3.5, K_T = 0.139 - 0.044286 - 0.0049796, K_M = 0.0171 - 0.0046857 - 0.00044898."""
    J = 1.0 / (25.0 * 0.14)
    K_T, K_M = (float(k) for k in TABLE_1.coefficients(J))
    assert pytest.approx(0.0897347, abs=1e-7) == K_T
    assert pytest.approx(0.01196531, abs=1e-8) == K_M
    thrust, torque = (float(x) for x in TABLE_1.forces(25.0, 1.0, RHO))
    assert thrust == pytest.approx(0.0897347 * 102.0 * 625.0 * 0.14**4 * 9.81, rel=1e-6)
    assert torque == pytest.approx(0.01196531 * 102.0 * 625.0 * 0.14**5 * 9.81, rel=1e-6)


def test_the_range_ends_where_thrust_does() -> None:
    """By hand: 0.061 J^2 + 0.155 J - 0.139 = 0 at J = 0.7025; the torque would be zero at 0.818."""
    low, high = TABLE_1.advance_number_range
    assert low == 0.0
    assert high == pytest.approx((math.sqrt(0.155**2 + 4 * 0.061 * 0.139) - 0.155) / 0.122, rel=1e-14)
    assert high == pytest.approx(0.7025, abs=5e-5)
    with pytest.raises(InputError, match=r"advance_number: expected a number from 0 to 0\.7025"):
        TABLE_1.coefficients(0.75)


def test_outside_the_range_forces_go_on_along_tangents() -> None:
    """Below J = 0 without the quadratic term; beyond the end with the slope there; astern by odd symmetry."""
    n, scale = 20.0, RHO * 0.14**4 * 400.0
    thrust = float(TABLE_1.forces(n, -1.0, RHO)[0])
    assert thrust == pytest.approx((0.139 + 0.155 * 1.0 / (n * 0.14)) * scale, rel=1e-13)
    end = TABLE_1.advance_number_range[1]
    thrust = float(TABLE_1.forces(n, (end + 0.2) * n * 0.14, RHO)[0])
    assert thrust == pytest.approx(0.2 * (-0.155 - 2.0 * 0.061 * end) * scale, rel=1e-12)
    assert float(TABLE_1.forces(-n, 1.0, RHO)[0]) == -float(TABLE_1.forces(n, -1.0, RHO)[0])


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"thrust_polynomial": [0.139, -0.155]}, "thrust_polynomial"),
        ({"thrust_polynomial": [0.139, 0.155, -0.61]}, "expected one that falls from J = 0"),
        ({"thrust_polynomial": [0.139, 0.0, 0.0], "torque_polynomial": [0.01, 0.0, 0.0]}, "found neither"),
        ({"torque_polynomial": [-0.0171, -0.0164, -0.0055]}, "expected a number above 0, found -0.0171"),
        ({"torque_polynomial": [0.0171, -0.0164, math.nan]}, "finite"),
        # Falls to a least value at J = 0.5 and would rise from there to the zero of thrust.
        ({"torque_polynomial": [0.0171, -0.01, 0.01]}, "torque_polynomial: expected one that falls"),
    ],
)
def test_what_is_no_propeller_is_refused(change: dict[str, Any], reason: str) -> None:
    section = SECTION | change
    with pytest.raises(ValidationError) as refused:
        TypeAdapter(PropellerData).validate_python(section)
    assert reason.rpartition(": ")[2] in str(refused.value)
    if len(section["thrust_polynomial"]) == 3:
        with pytest.raises(InputError, match="polynomial"):
            PolynomialPropeller(0.14, 0.6, section["thrust_polynomial"], section["torque_polynomial"])


def test_a_section_is_the_model() -> None:
    model = TypeAdapter(PropellerData).validate_python(SECTION).build()
    assert isinstance(model, PolynomialPropeller)
    np.testing.assert_array_equal(model.row(), TABLE_1.row())
