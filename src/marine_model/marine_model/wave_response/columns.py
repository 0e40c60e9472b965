"""Columns of a data file, and what they are made non-dimensional with."""

from __future__ import annotations

MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")

FREQUENCY = 0  # omega sqrt(L / g)
HEADING = 1  # rad, 0 for waves that travel ahead along the body x-axis
MOTION = slice(2, 14)  # real and imaginary part of every mode
DRIFT = slice(14, 17)
WIDTH = 17

HEADER = ",".join(
    (
        "frequency",
        "heading",
        *(f"{mode}_{part}" for mode in MODES for part in ("real", "imag")),
        *(f"drift_{mode}" for mode in ("surge", "sway", "yaw")),
    )
)
