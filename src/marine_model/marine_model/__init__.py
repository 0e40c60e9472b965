"""The shared vocabulary of the dynamic-positioning stack; pure Python, no middleware."""

from marine_model.load import load_vessel, vessel_names
from marine_model.vessel import Vessel

__all__ = ["Vessel", "load_vessel", "vessel_names"]
