"""A vessel whose thrusters have propellers of every model: a series propeller in all the forms that data come in."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from marine_model.propellers import PropellerModel, WageningenBPropeller

_BLADES, _AREA_RATIO = 4, 0.7
_PITCHES = (0.6, 0.8, 1.0, 1.2)
_HARMONICS = 20  # as many as the published four-quadrant series have
_ANGLES = 256
_PITCH_DRIVE = {"min": 0.6, "max": 1.2, "rate": 0.1, "time_constant": 0.3}


def with_every_model(vessel: Vessel) -> Vessel:
    """Return ``vessel`` with models and pitch actuators changed, in turn of the thrusters.

    Every first keeps its propeller. Others get a propeller of the B-series with four blades and an area ratio of 0.7
    as polynomials with controllable pitch, as a table, or as a Fourier series with controllable pitch.
    """
    content = vessel.model_dump()
    for i, thruster in enumerate(content["thrusters"]):
        diameter = thruster["propeller"]["diameter"]
        # The motor is for another propeller; what its limit does is not the point here.
        if i % 4 != 0:
            thruster["shaft"]["torque_max"] *= 2.0
        if i % 4 == 1:
            thruster["propeller"] = {
                "model": "wageningen_b",
                "diameter": diameter,
                "blades": _BLADES,
                "area_ratio": _AREA_RATIO,
                "pitch_ratio": 1.0,
            }
        elif i % 4 == 2:
            thruster["propeller"] = {"model": "tabulated", "diameter": diameter, "pitch_ratio": 1.0, "table": _table()}
        elif i % 4 == 3:
            thruster["propeller"] = {
                "model": "four_quadrant",
                "diameter": diameter,
                "pitch_ratio": 1.0,
                "series": _series(),
            }
        if i % 2 == 1:
            thruster["pitch"] = _PITCH_DRIVE
    return Vessel.model_validate(content)


def _series_propeller(pitch: float) -> PropellerModel:
    return WageningenBPropeller(1.0, _BLADES, _AREA_RATIO, pitch)


def _table() -> dict[str, Any]:
    advance = np.linspace(0.0, 0.6, 13)
    K_T, K_Q = _series_propeller(1.0).coefficients(advance)
    return {
        "advance_number": tuple(advance.tolist()),
        "thrust_coefficient": (tuple(K_T.tolist()),),
        "torque_coefficient": (tuple(K_Q.tolist()),),
    }


def _series() -> dict[str, Any]:
    """Return C_T and C_Q over the advance angle, the first quadrant's model continued over all four."""
    angle = 2.0 * math.pi * np.arange(_ANGLES) / _ANGLES
    rows: dict[str, list[tuple[float, ...]]] = {
        name: [] for name in ("thrust_cosine", "thrust_sine", "torque_cosine", "torque_sine")
    }
    for pitch in _PITCHES:
        # Diameter 1 m, density 1 kg/m^3, and a speed of 1 m/s at 0.7 R: C = force / (pi / 8).
        forces = _series_propeller(pitch).forces(np.cos(angle) / (0.7 * math.pi), np.sin(angle), 1.0)
        for name, force in zip(("thrust", "torque"), forces, strict=True):
            cosine, sine = _harmonics(force / (math.pi / 8.0))
            rows[f"{name}_cosine"].append(cosine)
            rows[f"{name}_sine"].append(sine)
    return {"pitch_ratio": _PITCHES, **{name: tuple(values) for name, values in rows.items()}}


def _harmonics(values: FloatArray) -> tuple[tuple[float, ...], tuple[float, ...]]:
    spectrum = np.fft.rfft(values)[: _HARMONICS + 1] / len(values)
    cosine, sine = 2.0 * spectrum.real, -2.0 * spectrum.imag
    cosine[0] *= 0.5
    return tuple(cosine.tolist()), tuple(sine.tolist())
