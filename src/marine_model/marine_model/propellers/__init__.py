"""Propeller models behind one interface, conversions between their coefficients, and scaling from model to ship."""

from marine_model.propellers.base import OutOfRangeWarning, PropellerModel
from marine_model.propellers.bollard import BollardPropeller
from marine_model.propellers.bollard_row import BollardPropellers
from marine_model.propellers.four_quadrant import FourQuadrantPropeller
from marine_model.propellers.polynomial import PolynomialPropeller
from marine_model.propellers.scaling import FroudeScale, ModelRun, ScalingCheck, check_scaling
from marine_model.propellers.tabulated import TabulatedPropeller
from marine_model.propellers.wageningen_b import WageningenBPropeller

__all__ = [
    "BollardPropeller",
    "BollardPropellers",
    "FourQuadrantPropeller",
    "FroudeScale",
    "ModelRun",
    "OutOfRangeWarning",
    "PolynomialPropeller",
    "PropellerModel",
    "ScalingCheck",
    "TabulatedPropeller",
    "WageningenBPropeller",
    "check_scaling",
]
