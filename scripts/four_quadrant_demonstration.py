"""Write src/marine_model/marine_model/data/b4_70_continued.yaml: Fourier series of C_T and C_Q in four quadrants.

It demonstrates the format of such a file and gives tests something to run on. No published coefficients are in it:
the Wageningen B4-70 propeller (polynomials of 1975, first quadrant) is continued into the other quadrants as
`PropellerModel.forces` does it, by tangents and odd symmetry, and the series are its discrete Fourier transform.

    .venv/bin/python scripts/four_quadrant_demonstration.py
"""

from pathlib import Path

import numpy as np

import marine_model
from marine_model.guards import FloatArray
from marine_model.propellers import WageningenBPropeller
from marine_model.propellers.conversion import ROTATION, four_quadrant_scale

FILE = Path(marine_model.__file__).parent / "data" / "b4_70_continued.yaml"
PITCH_RATIOS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4)
HARMONICS = 31  # with the constant term
ANGLES = 3600
DIGITS = 7  # after the point: rounding adds less than the series leave out

NAMES = ("thrust_cosine", "thrust_sine", "torque_cosine", "torque_sine")

HEAD = """\
# Demonstration of a four-quadrant file, written by scripts/four_quadrant_demonstration.py. NOT published coefficients:
# the Wageningen B4-70 polynomials of 1975 continued beyond their first quadrant along tangents and by odd symmetry,
# as Fourier series of the advance angle with {harmonics} terms. Largest difference from what the series stand for, over
# all angles and pitch ratios here: {thrust:.4f} in C_T, {torque:.5f} in C_Q.
# C = sum over k of cosine[k] cos(k beta) + sine[k] sin(k beta), a row for every pitch ratio; C_T, C_Q and beta as in
# [Ruth] (2.12)-(2.14).
source: Wageningen B4-70 polynomials of 1975, continued; a demonstration
"""


def continued(pitch_ratio: float, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """C_T and C_Q of the continued propeller."""
    propeller = WageningenBPropeller(1.0, 4, 0.7, pitch_ratio)
    shaft_speed, advance_speed = np.cos(angle) / ROTATION, np.sin(angle)
    thrust, torque = propeller.forces(shaft_speed, advance_speed, 1.0)
    scale = four_quadrant_scale(shaft_speed, advance_speed, 1.0, 1.0)
    return thrust / scale, torque / scale


def main() -> None:
    angle = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False)
    k = np.arange(HARMONICS)
    cosine, sine = np.cos(np.outer(k, angle)), np.sin(np.outer(k, angle))
    weight = np.where(k == 0, 1.0, 2.0) / ANGLES
    series: dict[str, list[FloatArray]] = {name: [] for name in NAMES}
    worst = [0.0, 0.0]
    for pitch_ratio in PITCH_RATIOS:
        for i, values in enumerate(continued(pitch_ratio, angle)):
            a, b = (np.round(weight * (base @ values), DIGITS) for base in (cosine, sine))
            series[NAMES[2 * i]].append(a)
            series[NAMES[2 * i + 1]].append(b)
            worst[i] = max(worst[i], float(np.abs(a @ cosine + b @ sine - values).max()))
    lines = [HEAD.format(harmonics=HARMONICS, thrust=worst[0], torque=worst[1])]
    lines.append("pitch_ratio: [{}]\n".format(", ".join(str(p) for p in PITCH_RATIOS)))
    for name in NAMES:
        lines.append(name + ":\n")
        lines += ["  - [{}]\n".format(", ".join(f"{value + 0.0:.{DIGITS}f}" for value in row)) for row in series[name]]
    FILE.write_text("".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
