"""Columns of the packed parameters of a propeller (``PropellerModel.row``), for models and kernel alike."""

from __future__ import annotations

import math

PIECEWISE, FOURIER, LINEAR = 0, 1, 2

# Columns of a row.
KIND = 0
PITCH_MIN = 1
PITCH_MAX = 2
PITCH_PIECES = 3
PITCH_TERMS = 4  # coefficients of a polynomial in the pitch ratio, lowest power first
ADVANCE_PIECES = 5  # PIECEWISE
HARMONICS = 5  # FOURIER: with the constant term
END = 6  # PIECEWISE: end of the range of J, four coefficients in the pitch ratio
END_IS_ZERO_THRUST = 10  # PIECEWISE: 1 where the end is K_T = 0 and END a first guess of it
# From here: breaks in pitch ratio (PITCH_PIECES + 1). PIECEWISE: breaks in J (ADVANCE_PIECES + 1), then coefficients
# by pitch piece, advance piece, power of P/D, (K_T, K_Q), power of J. FOURIER: coefficients by pitch piece, harmonic,
# power of P/D, (A_T, B_T, A_Q, B_Q). Powers are of the distance from the lower break of the piece. What is read at once
# lies together.
BREAKS = 11
LINEAR_COEFFICIENTS = BREAKS + 4

ADVANCE_TERMS = 4  # cubic in J
SPLINE_TERMS = 4  # of a series known at several pitch ratios
# The guess of the end is good to 2 %: Newton on a cubic that falls there squares that three times, to below rounding.
END_STEPS = 4
CERTAINLY_INSIDE = 0.9

ROTATION = 0.7 * math.pi  # tangential over n D at 0.7 R, [Ruth] (2.16)
