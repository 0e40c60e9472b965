"""The family of local thruster controllers: an abstract base and one file for each law."""

from __future__ import annotations

from typing import Literal, get_args

from thruster_drivers.controllers.base import ControlOutput, ThrusterController
from thruster_drivers.controllers.code_map import CodeMapController
from thruster_drivers.controllers.combined import CombinedController
from thruster_drivers.controllers.pitch import PitchController
from thruster_drivers.controllers.power import PowerController
from thruster_drivers.controllers.shaft_speed import ShaftSpeedController
from thruster_drivers.controllers.shaft_speed_pitch import ShaftSpeedPitchController
from thruster_drivers.controllers.torque import TorqueController
from thruster_drivers.controllers.torque_pitch import TorquePitchController
from thruster_drivers.controllers.torque_shaft_speed import TorqueShaftSpeedController
from thruster_drivers.controllers.tuning import Tuning, tuning_of
from thruster_drivers.shaft_model import ShaftModel

ControllerName = Literal[
    "shaft_speed",
    "torque",
    "power",
    "combined",
    "pitch",
    "torque_pitch",
    "shaft_speed_pitch",
    "torque_shaft_speed",
    "code_map",
]
CONTROLLERS: tuple[ControllerName, ...] = get_args(ControllerName)

_LAWS: dict[str, type[ThrusterController]] = {
    "shaft_speed": ShaftSpeedController,
    "torque": TorqueController,
    "power": PowerController,
    "combined": CombinedController,
    "pitch": PitchController,
    "torque_pitch": TorquePitchController,
    "shaft_speed_pitch": ShaftSpeedPitchController,
    "torque_shaft_speed": TorqueShaftSpeedController,
    "code_map": CodeMapController,
}


def make_controller(kind: str, model: ShaftModel, tuning: Tuning) -> ThrusterController:
    """Return a controller of ``kind``, one of ``CONTROLLERS``.

    Raises
    ------
    InputError
        If the law works through the pitch and the thruster's is fixed, or through a drive and the thruster has none.
    """
    return _LAWS[kind](model, tuning)


def needs_pitch(kind: str) -> bool:
    """Whether ``kind``, one of ``CONTROLLERS``, works through a controllable pitch."""
    return _LAWS[kind].needs_pitch


def needs_drive(kind: str) -> bool:
    """Whether ``kind``, one of ``CONTROLLERS``, works through a drive that takes integer codes."""
    return _LAWS[kind].needs_drive


__all__ = [
    "CONTROLLERS",
    "CodeMapController",
    "CombinedController",
    "ControlOutput",
    "ControllerName",
    "PitchController",
    "PowerController",
    "ShaftSpeedController",
    "ShaftSpeedPitchController",
    "ThrusterController",
    "TorqueController",
    "TorquePitchController",
    "TorqueShaftSpeedController",
    "Tuning",
    "make_controller",
    "needs_drive",
    "needs_pitch",
    "tuning_of",
]
