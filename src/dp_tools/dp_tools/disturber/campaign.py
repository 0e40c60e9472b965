"""A list of pose faults, each sailed in process, and what came of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from dp_tools.disturber.loop import DisturbedLoop, Witness
from dp_tools.scenario import Scenario
from marine_model import Vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray

START = 60.0  # s of simulated time: by then the vessel holds its position
END = 80.0  # the fault ends
DURATION = 220.0
# What counts as recovered, as distance from the same voyage without a fault.
BACK = 0.05  # m
BACK_HEADING = np.radians(2.0)


@dataclass(frozen=True, slots=True)
class PoseFault:
    """One row: its name, and settings of the disturber between :data:`START` and ``end`` (s)."""

    name: str
    values: dict[str, object]
    end: float = END


FAULTS = (
    PoseFault("lose 1 %", {"loss": 0.01}),
    PoseFault("lose 10 %", {"loss": 0.1}),
    PoseFault("lose 50 %", {"loss": 0.5}),
    PoseFault("lose all for 4 s", {"loss": 1.0}, START + 4.0),
    PoseFault("lose all for 20 s", {"loss": 1.0}),
    PoseFault("delay 0.2 s", {"delay": 0.2}),
    PoseFault("delay 0.6 s", {"delay": 0.6}),
    PoseFault("delay 2 s", {"delay": 2.0}),
    PoseFault("duplicate 50 %", {"duplicate": 0.5}),
    PoseFault("reorder 30 %", {"reorder": 0.3}),
    PoseFault("jump 10 m for 0.4 s", {"jump.north": 10.0}, START + 0.4),
    PoseFault("jump 10 m for 20 s", {"jump.north": 10.0}),
    PoseFault("frozen position for 5 s", {"freeze": "value"}, START + 5.0),
    PoseFault("frozen position for 20 s", {"freeze": "value"}),
    PoseFault("same message again for 4 s", {"freeze": "message"}, START + 4.0),
    PoseFault("same message again for 20 s", {"freeze": "message"}),
    PoseFault("NaN 10 %", {"not_finite": 0.1}),
    PoseFault("NaN for 20 s", {"not_finite": 1.0}),
    PoseFault("heading plus one turn", {"jump.heading": 6.283185307179586}),
    PoseFault("quaternion of the other sign", {"other_cover": True}),
    PoseFault("time 0.6 s back", {"time_offset": -0.6}),
)


@dataclass(frozen=True, slots=True)
class FaultFigures:
    """What a fault did.

    Attributes
    ----------
    name
        Of the fault.
    largest, heading
        Largest distance (m) and turn (rad) from the voyage without a fault, from the begin of the fault on.
    rms
        Root of the mean square of the distance (m) while the fault lasts.
    recovery
        Time from the end of the fault until the vessel stays within :data:`BACK` and :data:`BACK_HEADING` of the
        voyage without one, s; None if it does not within the run.
    shown
        Alarm codes that the undisturbed voyage did not have, in order of their first report.
    shown_after
        Time from the begin of the fault to the first of them, s; None without one.
    refused
        Messages refused.
    """

    name: str
    largest: float
    heading: float
    rms: float
    recovery: float | None
    shown: tuple[str, ...]
    shown_after: float | None
    refused: int


def voyage(scenario: Scenario) -> Scenario:
    """Return a scenario without events but those at its start, as long as a fault and recovery need."""
    events = tuple(event for event in scenario.events if event.at == 0.0)
    return scenario.model_copy(update={"duration": DURATION, "events": events})


def sail(vessel: Vessel, scenario: Scenario, fault: PoseFault | None) -> Witness:
    """Sail the scenario with a fault and return what was seen. Raises InputError as the loop does."""
    changes: list[tuple[float, dict[str, object]]] = []
    if fault is not None:
        changes = [(START, fault.values), (fault.end, {})]
    loop = DisturbedLoop(vessel, scenario, changes)
    loop.run()
    return loop.witness


def judge(fault: PoseFault, disturbed: Witness, undisturbed: Witness) -> FaultFigures:
    """Compare two voyages that differ in the fault only."""
    time: FloatArray = np.array(disturbed.time)
    off: FloatArray = np.array(disturbed.position) - np.array(undisturbed.position)
    distance: FloatArray = np.hypot(off[:, 0], off[:, 1])
    turn: FloatArray = np.abs(wrap_angles(off[:, 2]))
    begun = time >= START
    during = begun & (time < fault.end)
    away = time[(time >= fault.end) & ((distance > BACK) | (turn > BACK_HEADING))]
    recovery: float | None = 0.0
    if len(away):
        recovery = None if away[-1] == time[-1] else float(away[-1] - fault.end)
    shown = [code for code, at in disturbed.alarms.items() if at >= START and code not in undisturbed.alarms]
    return FaultFigures(
        name=fault.name,
        largest=float(distance[begun].max()),
        heading=float(turn[begun].max()),
        rms=float(np.sqrt(np.mean(distance[during] ** 2))),
        recovery=recovery,
        shown=tuple(shown),
        shown_after=disturbed.alarms[shown[0]] - START if shown else None,
        refused=disturbed.refused,
    )


def campaign(
    vessel: Vessel, scenario: Scenario, told: Callable[[str], None] = lambda name: None
) -> Iterator[FaultFigures]:
    """Yield the figures of every fault in :data:`FAULTS`; ``told`` hears which one is sailed."""
    told("no fault")
    undisturbed = sail(vessel, scenario, None)
    for fault in FAULTS:
        told(fault.name)
        yield judge(fault, sail(vessel, scenario, fault), undisturbed)
