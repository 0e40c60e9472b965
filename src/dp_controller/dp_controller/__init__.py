"""Motion controller: reference generator, nonlinear PID and operator modes; pure Python, no middleware."""

from dp_controller.controller import Controller
from dp_controller.settings import ControllerSettings
from dp_controller.signals import ControllerInputs, ControllerOutput

__all__ = ["Controller", "ControllerInputs", "ControllerOutput", "ControllerSettings"]
