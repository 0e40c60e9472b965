"""Both methods of detection over the same ventilation and the same sea."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from dp_tools.detection_campaign import DetectionTable, campaign
from marine_model import Vessel

METHODS = {
    "torque_rate": "Torque rate, every feedback (5.14)",
    "shaft_deceleration": "Shaft deceleration, every sample (B.41)–(B.43)",
}


@dataclass(frozen=True)
class MethodResult:
    """One method: a time with ventilation, and a time of moderate sea without it."""

    title: str
    ventilation: DetectionTable
    sea: DetectionTable


def run_campaigns(
    vessel: Vessel, duration: float, seed: int, progress: Callable[[float], None] | None = None
) -> tuple[MethodResult, ...]:
    """Return the tables of every method.

    Parameters
    ----------
    vessel
        With ``drivers.ventilation`` and ``ventilation``.
    duration
        s of sea; half of it is the time of ventilation.
    seed
        Of both.
    progress
        Called with the number of methods done, fractions of them included.

    Raises
    ------
    InputError
        If the vessel lacks a section that is needed.
    """
    found: list[MethodResult] = []
    for method, title in METHODS.items():

        def tell(done: int, total: int, before: int = len(found)) -> None:
            if progress is not None:
                progress(before + done / total)

        found.append(MethodResult(title, *campaign(vessel, method, duration, seed, progress=tell)))
    return tuple(found)


def confusion(result: MethodResult) -> list[tuple[str, str]]:
    """Return the confusion table of one method as text, a row a number."""
    wet, sea = result.ventilation, result.sea
    return [
        ("Events longer than 0.5 s", f"{wet.events}"),
        ("found before they ended", f"{wet.found}"),
        ("found within two samples of the control system", f"{wet.found_in_time}"),
        ("found within two of its own samples", f"{int((wet.delays_in_own_samples <= 2.0).sum())}"),
        ("missed", f"{wet.missed}"),
        ("Flags raised", f"{wet.flags}"),
        ("of these between both thresholds", f"{wet.early}"),
        ("of these on a wet propeller", f"{wet.false_alarms}"),
        ("Moderate sea, thruster hours", f"{sea.hours:.1f}"),
        ("false alarms there", f"{sea.flags}"),
    ]
