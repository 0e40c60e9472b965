"""One propeller of every model, for tests that hold for all of them."""

from __future__ import annotations

import numpy as np

from marine_model.propellers import (
    BollardPropeller,
    FourQuadrantPropeller,
    PolynomialPropeller,
    PropellerModel,
    TabulatedPropeller,
    WageningenBPropeller,
)

B4_70 = WageningenBPropeller(0.25, 4, 0.7, 1.0)
ADVANCE = [0.0, 0.15, 0.3, 0.45, 0.6, 0.7]
PITCHES = [0.8, 0.9, 1.0, 1.2]
THRUST, TORQUE = (k.tolist() for k in B4_70.coefficients(ADVANCE, np.array(PITCHES)[:, None]))
# Made up: signs as a propeller has them, three harmonics, three pitch ratios.
SERIES = (
    [0.8, 1.0, 1.3],
    [[0.02, 0.5, 0.01], [0.01, 0.6, 0.02], [0.03, 0.7, 0.01]],
    [[0.0, -0.4, 0.02], [0.0, -0.5, 0.03], [0.0, -0.5, 0.02]],
    [[0.001, 0.06, 0.001], [0.002, 0.07, 0.001], [0.001, 0.08, 0.001]],
    [[0.0, -0.06, 0.002], [0.0, -0.07, 0.001], [0.0, -0.08, 0.003]],
)

FIRST_QUADRANT: dict[str, PropellerModel] = {
    "bollard": BollardPropeller(0.09, 0.93, 0.42, 0.0442),
    "linear": BollardPropeller(0.09, 0.93, 0.42, 0.0442, -0.353, -0.0325),
    "polynomial": PolynomialPropeller(0.14, 0.60, (0.139, -0.155, -0.061), (0.0171, -0.0164, -0.0055)),
    "wageningen_b": B4_70,
    "tabulated": TabulatedPropeller(0.25, 1.0, ADVANCE, THRUST, TORQUE, PITCHES),
    "tabulated, two pitches": TabulatedPropeller(0.25, 0.9, ADVANCE, THRUST[:2], TORQUE[:2], PITCHES[:2]),
    "tabulated, one pitch": TabulatedPropeller(0.25, 1.0, ADVANCE, THRUST[2:3], TORQUE[2:3]),
}
ALL: dict[str, PropellerModel] = {
    **FIRST_QUADRANT,
    "four_quadrant": FourQuadrantPropeller(0.25, 1.0, *SERIES),
    "four_quadrant, one pitch": FourQuadrantPropeller(0.25, 1.0, [1.0], *([rows[1]] for rows in SERIES[1:])),
}
