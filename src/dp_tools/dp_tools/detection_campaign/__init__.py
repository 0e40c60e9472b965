"""How well the drivers find ventilation: simulated events, and a sea without any.

The real parts run: :class:`thruster_drivers.Drivers` with the detection in it, the propulsion plant of the simulator
with the vessel's propellers and losses, and the vessel's sensor noise. The hull is left out: submergence and advance
speed are prescribed.
"""

from dp_tools.detection_campaign.bench import Record, sail
from dp_tools.detection_campaign.campaign import METHODS, campaign
from dp_tools.detection_campaign.moderate_sea import least_shaft_speed
from dp_tools.detection_campaign.table import DetectionTable, merge, tabulate
from dp_tools.detection_campaign.trials import Trial, moderate_sea_trial, ventilation_trial

__all__ = [
    "METHODS",
    "DetectionTable",
    "Record",
    "Trial",
    "campaign",
    "least_shaft_speed",
    "merge",
    "moderate_sea_trial",
    "sail",
    "tabulate",
    "ventilation_trial",
]
