"""The marching thruster of MMT-300, its tables as [Kostenko] prints them, and a vessel that has it."""

from __future__ import annotations

from functools import cache

from marine_model import Vessel, load_vessel
from marine_model.code_maps import CodeDrive
from marine_model.code_maps.sections import DriveData
from marine_model.load import DRIVE_FOLDER
from marine_model.propellers import PolynomialPropeller
from marine_model.yaml_document import read_yaml

DENSITY = 102.0 * 9.81  # (1): kg s^2/m^4 times g
PROPELLER = {  # Table 1
    "model": "polynomial",
    "diameter": 0.14,
    "pitch_ratio": 0.60,
    "thrust_polynomial": [0.139, -0.155, -0.061],
    "torque_polynomial": [0.0171, -0.0164, -0.0055],
}
MODEL = PolynomialPropeller(0.14, 0.60, (0.139, -0.155, -0.061), (0.0171, -0.0164, -0.0055))
SPEEDS = (0.0, 0.5, 1.0, 1.5, 2.0)
TABLE_2 = {
    "constant": (-4.0, -5.0, -8.0, -11.0, -15.0),
    "linear": (0.254, 0.215, 0.211, 0.210, 0.208),
    "quadratic": (8.82e-4, 10.2e-4, 9.65e-4, 9.07e-4, 8.67e-4),
}
TABLE_3 = {"ahead": (12.7, 4.336, -0.070, 7.29e-4), "astern": (-12.7, 4.738, 0.089, 9.68e-4)}
TABLE_4 = {
    "thrust_max": (42.0, 38.5, 34.5, 29.9, 24.8),
    "constant": (11.7, 20.6, 30.8, 43.2, 60.0),
    "linear": (4.32, 4.04, 3.97, 3.95, 3.17),
    "quadratic": (-0.073, -0.062, -0.063, -0.074, -0.031),
    "cubic": (8.51e-4, 7.43e-4, 8.33e-4, 12.1e-4, 5.00e-4),
}
# Of the load test, section 2.
TESTED_CODES = (20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 127)


@cache
def drive_data() -> DriveData:
    """The section as it comes with the package."""
    return DriveData.model_validate(read_yaml(DRIVE_FOLDER / "at_drive_50x14.yaml").content)


@cache
def drive() -> CodeDrive:
    """The drive with the propeller of Table 1."""
    return drive_data().build(MODEL, DENSITY)


@cache
def driven_vessel() -> Vessel:
    """MMT-300 with that drive at every thruster, and its propeller."""
    content = load_vessel("mmt300").model_dump()
    for thruster in content["thrusters"]:
        thruster["propeller"] = dict(PROPELLER)
        thruster["drive"] = drive_data().model_dump()
    return Vessel.model_validate(content)


@cache
def straight_vessel() -> Vessel:
    """The same with all five thrusters along the hull, so that the speed of the vessel is that along the shafts."""
    content = driven_vessel().model_dump()
    content["degrees_of_freedom"] = ["surge"]
    content["allocator"]["slack_weight"] = [1.0]
    for thruster in content["thrusters"]:
        thruster["axis"] = [1.0, 0.0, 0.0]
    return Vessel.model_validate(content)
