"""Limits of motor and shaft against the thrust that they are to give."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from marine_model.propellers import PropellerModel
from marine_model.schema import FieldError
from marine_model.thruster import Thruster

_PITCHES = 33  # over the range of a controllable pitch, looking for one that reaches the thrust


def check_shaft_limits(thrusters: Sequence[Thruster], models: Sequence[PropellerModel], density: float) -> None:
    """Refuse limits of torque, power and shaft speed below what the largest thrust needs at no advance speed.

    Where the pitch is controllable, that is what the pitch ratio needs that is the best for the limit in question.

    Parameters
    ----------
    thrusters, models
        As in the vessel file, and the propeller model of each.
    density
        rho, kg/m^3.

    Raises
    ------
    FieldError
        If a limit contradicts ``thrust``; it blames the limit.
    """
    for i, (thruster, model) in enumerate(zip(thrusters, models, strict=True)):
        shaft, pitch = thruster.shaft, thruster.pitch
        largest = max(thruster.thrust.max, -thruster.thrust.min)
        pitches = np.linspace(pitch.min, pitch.max, _PITCHES) if pitch else np.array([model.pitch_ratio])
        K_T, K_Q = model.coefficients(0.0, pitches)
        gives_thrust = K_T > 0.0
        K_T, K_Q = K_T[gives_thrust], K_Q[gives_thrust]
        speed = np.sqrt(largest / (K_T * density * model.diameter**4))
        torque = K_Q / K_T * model.diameter * largest + shaft.friction_static + shaft.friction_viscous * speed
        for name, limit, needed, what in (
            ("torque_max", shaft.torque_max, torque, "N m, the torque"),
            ("power_max", shaft.power_max, 2.0 * math.pi * speed * torque, "W, the power"),
            ("speed_max", shaft.speed_max, speed, "Hz, the shaft speed"),
        ):
            if limit is not None and limit < needed.min():
                raise FieldError(
                    ("thrusters", i, "shaft", name),
                    f"expected at least {needed.min():.3g} {what} at the largest thrust of {largest:g} N and no "
                    f"advance speed, found {limit:g}",
                )
