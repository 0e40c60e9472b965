"""Thrusters that are asked for by integer code, [Kostenko] (3)-(8): thrust and torque of a code, code of a thrust."""

from marine_model.code_maps.code_from_thrust import CodeFromThrust
from marine_model.code_maps.codes import nearest_code, require_code
from marine_model.code_maps.drive import CodeDrive
from marine_model.code_maps.rest_code_from_thrust import RestCodeFromThrust
from marine_model.code_maps.speeds import Speeds
from marine_model.code_maps.thrust_from_code import ThrustFromCode

__all__ = [
    "CodeDrive",
    "CodeFromThrust",
    "RestCodeFromThrust",
    "Speeds",
    "ThrustFromCode",
    "nearest_code",
    "require_code",
]
