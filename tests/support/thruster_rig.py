"""A controllable-pitch vessel, and one thruster of it as a plant: shaft, propeller in a flow, pitch servo."""

from __future__ import annotations

import math
from typing import Any

from marine_model import Vessel, load_vessel
from marine_model.propellers.kernel import thrust_torque
from thruster_drivers.controllers import CONTROLLERS, needs_drive
from thruster_drivers.shaft_model import ShaftModel

# Those of any thruster, controllable pitch or not: no drive that takes codes.
LAWS = tuple(law for law in CONTROLLERS if not needs_drive(law))
SUBSTEPS = 8  # of the simulated shaft in one control step


def controllable_pitch_vessel(shaft: dict[str, Any] | None = None, drivers: dict[str, Any] | None = None) -> Vessel:
    """Return CyberShip III with propellers of the B-series and pitch servos, some fields changed.

    Torque limits are three times those of the vessel file, so that one size of propeller serves all.
    """
    content = load_vessel("cybership3").model_dump()
    for thruster in content["thrusters"]:
        diameter = thruster["propeller"]["diameter"]
        thruster["propeller"] = {
            "model": "wageningen_b",
            "diameter": diameter,
            "blades": 4,
            "area_ratio": 0.7,
            "pitch_ratio": 0.8,
        }
        thruster["pitch"] = {"min": 0.5, "max": 1.4, "rate": 0.4, "time_constant": 0.2}
        thruster["shaft"]["torque_max"] *= 3.0
        thruster["shaft"] |= shaft or {}
    content["drivers"] |= drivers or {}
    return Vessel.model_validate(content)


class ThrusterRig:
    """The truth of one thruster: 2 pi J dn/dt = Q_m - Q_p(n, V_A, P/D) - Q_f, and a first-order pitch servo."""

    def __init__(self, model: ShaftModel, advance_speed: float = 0.0, pitch_ratio: float | None = None) -> None:
        assert model.propeller is not None
        self.model = model
        self.row = model.propeller.row()
        self.diameter = model.propeller.diameter
        self.advance_speed = advance_speed
        self.speed = 0.0
        self.pitch_ratio = model.pitch_ratio if pitch_ratio is None else pitch_ratio
        self.thrust = self.torque = 0.0
        self.load_factor = 1.0  # of propeller torque and thrust: below 1 where the propeller ventilates

    def step(self, torque: float, setpoint: float, dt: float) -> None:
        h = dt / SUBSTEPS
        for _ in range(SUBSTEPS):
            self.thrust, self.torque = (
                self.load_factor * value
                for value in thrust_torque(
                    self.row, self.diameter, self.model.density, self.speed, self.advance_speed, self.pitch_ratio
                )
            )
            friction = self.model.friction_static * math.tanh(self.speed / 0.01)  # smooth sign over 0.01 Hz
            friction += self.model.friction_viscous * self.speed
            self.speed += (torque - self.torque - friction) / (2.0 * math.pi * self.model.inertia) * h
            if self.model.pitch is not None:
                rate = (setpoint - self.pitch_ratio) / self.model.pitch.time_constant
                self.pitch_ratio += max(-self.model.pitch.rate, min(self.model.pitch.rate, rate)) * h
