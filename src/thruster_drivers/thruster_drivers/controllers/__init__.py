"""The family of local thruster controllers: an abstract base and one file for each law."""

from __future__ import annotations

from marine_model.gains import DriverGains
from thruster_drivers.controllers.base import ThrusterController
from thruster_drivers.controllers.shaft_speed import ShaftSpeedController
from thruster_drivers.shaft_model import ShaftModel

__all__ = ["ShaftSpeedController", "ThrusterController", "make_controller"]


def make_controller(kind: str, model: ShaftModel, gains: DriverGains) -> ThrusterController:
    """Return a controller of ``kind``, one of the values of ``DriverSettings.controller``."""
    return _MAKERS[kind](model, gains)


_MAKERS = {
    "shaft_speed": lambda model, gains: ShaftSpeedController(model, gains.shaft_speed),
}
