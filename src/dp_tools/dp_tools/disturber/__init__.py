"""A relay that spoils a stream of poses on purpose: what a position reference, its link or its clock may do."""

from dp_tools.disturber.disturber import Disturber, PoseSample
from dp_tools.disturber.settings import DisturberSettings

__all__ = ["Disturber", "DisturberSettings", "PoseSample"]
