"""What a controller under test is fed with."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dp_controller import Controller, ControllerInputs, ControllerOutput, ControllerSettings
from marine_model import Vessel, load_vessel
from marine_model.frames import rotation

DT = 0.2

Array = NDArray[np.float64]


VESSEL = load_vessel("cybership3")


@dataclass
class Rig:
    """A controller that is fed with what the test says, and an allocator that grants everything."""

    controller: Controller
    position: Array = field(default_factory=lambda: np.zeros(3))
    velocity: Array = field(default_factory=lambda: np.zeros(3))
    valid: bool = True
    achieved: Array = field(default_factory=lambda: np.zeros(3))
    wind: Array | None = None  # newly measured at every step

    def step(self, dt: float = DT) -> ControllerOutput:
        inputs = ControllerInputs(self.position, self.velocity, self.achieved, self.valid, self.wind)
        output = self.controller.step(inputs, dt)
        self.achieved = output.tau_desired
        return output

    def run(self, steps: int) -> ControllerOutput:
        for _ in range(steps):
            output = self.step()
        return output

    def change(self, **changes: object) -> None:
        settings = self.controller.settings.model_dump() | changes
        self.controller.apply(ControllerSettings.model_validate(settings))


class Basin:
    """Linear low-frequency model of the vessel, with a current-like force in NED and thrusters that saturate."""

    def __init__(self, vessel: Vessel, force: ArrayLike = (0.0, 0.0, 0.0), tau_max: float = np.inf) -> None:
        mass = np.array(vessel.on_surface()[0].rigid_body_mass) + np.array(vessel.on_surface()[0].added_mass)
        self.inverse_mass = np.linalg.inv(mass)
        self.damping = np.array(vessel.on_surface()[0].linear_damping)
        self.force = np.array(force, dtype=float)
        self.tau_max = tau_max
        self.position = np.zeros(3)
        self.velocity = np.zeros(3)
        self.achieved = np.zeros(3)

    def sail(self, controller: Controller, seconds: float) -> list[ControllerOutput]:
        outputs = []
        for _ in range(round(seconds / DT)):
            output = controller.step(ControllerInputs(self.position, self.velocity, self.achieved, True), DT)
            self.achieved = np.clip(output.tau_desired, -self.tau_max, self.tau_max)
            self.position = self.position.copy()
            for _ in range(10):
                turn = rotation(self.position[2])
                tau = self.achieved + turn.T @ self.force - self.damping @ self.velocity
                self.velocity = self.velocity + 0.1 * DT * self.inverse_mass @ tau
                self.position += 0.1 * DT * turn @ self.velocity
            outputs.append(output)
        return outputs


def rig(**settings: object) -> Rig:
    """A rig with these settings."""
    return Rig(Controller(VESSEL, ControllerSettings.model_validate(settings)))


def basin(force: ArrayLike = (0.0, 0.0, 0.0), tau_max: float = np.inf) -> Basin:
    """A vessel in a basin."""
    return Basin(VESSEL, force, tau_max)
