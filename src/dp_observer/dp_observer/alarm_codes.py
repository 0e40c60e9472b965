"""Which alarms the observer's state means: for its node, and for who runs the core without one."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from dp_observer.estimate import ObserverStatus

BY_STATUS: Mapping[ObserverStatus, str] = MappingProxyType(
    {
        ObserverStatus.UNINITIALISED: "OBSERVER-NO-FIX-YET",
        ObserverStatus.DEAD_RECKONING: "OBSERVER-DEAD-RECKONING",
        ObserverStatus.OUTLIER_REFUSED: "OBSERVER-FIX-REFUSED",
        ObserverStatus.INVALID: "OBSERVER-ESTIMATE-INVALID",
        ObserverStatus.REINITIALISED: "OBSERVER-REINITIALISED",
    }
)
NO_POSE = "OBSERVER-NO-POSE"
MEASUREMENTS_LOST = "OBSERVER-MEASUREMENTS-LOST"
FIX_FROZEN = "OBSERVER-FIX-FROZEN"


def codes_of(status: ObserverStatus, reinitialised: bool, poses: int, missing: int, frozen: bool) -> list[str]:
    """Return the codes of the alarms of one report, each once.

    Parameters
    ----------
    status
        Of the last estimate.
    reinitialised
        Whether the position was set anew since the last report.
    poses, missing
        Poses since the last report; those without a fix, refused as outliers, late, or made up for.
    frozen
        Whether too many fixes in a row are equal.
    """
    found = [BY_STATUS[status]] if status in BY_STATUS else []
    if reinitialised and status is not ObserverStatus.REINITIALISED:
        found.append(BY_STATUS[ObserverStatus.REINITIALISED])
    if not poses:
        found.append(NO_POSE)
    elif missing:
        found.append(MEASUREMENTS_LOST)
    if poses and frozen:
        found.append(FIX_FROZEN)
    return found
