"""Which thrusters are faulty when: what a scenario does to the simulated propulsion plant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from dp_tools.node_settings import SIMULATOR
from dp_tools.scenario import Scenario
from marine_model import Vessel

Spans = tuple[tuple[float, float], ...]  # s, s

FAILED = "propulsion.failed"
AZIMUTH_FAILED = "propulsion.azimuth_failed"


@dataclass(frozen=True)
class Fault:
    """A stretch of time in which the same thrusters are faulty.

    Parameters
    ----------
    start, end
        s.
    motors, azimuths
        By thruster: whether its motor, or its azimuth motor, has failed.
    """

    start: float
    end: float
    motors: tuple[bool, ...]
    azimuths: tuple[bool, ...]

    @property
    def thrusters(self) -> tuple[bool, ...]:
        """By thruster: whether anything of it has failed."""
        return tuple(a or b for a, b in zip(self.motors, self.azimuths, strict=True))

    @property
    def name(self) -> str:
        """Numbers of the thrusters that work, as in [Ruth] 6.5.3, or of the azimuth motors that do not; from 1."""
        if not any(self.motors):
            return "azimuth " + " ".join(str(j + 1) for j, faulty in enumerate(self.azimuths) if faulty)
        return "".join(str(j + 1) for j, faulty in enumerate(self.motors) if not faulty) or "none"


def faults(scenario: Scenario, vessel: Vessel) -> tuple[Fault, ...]:
    """Return the faults of a scenario in order of time."""
    none = (False,) * len(vessel.thrusters)
    found: list[Fault] = []
    start, state = 0.0, _state(scenario.parameters.get(SIMULATOR, {}), (none, none), none)
    for event in scenario.events:
        changed = _state(event.parameters.get(SIMULATOR, {}), state, none)
        if changed == state:
            continue
        if any(map(any, state)) and event.at > start:
            found.append(Fault(start, event.at, *state))
        start, state = event.at, changed
    if any(map(any, state)) and scenario.duration > start:
        found.append(Fault(start, scenario.duration, *state))
    return tuple(found)


def _state(
    changes: Mapping[str, object], before: tuple[tuple[bool, ...], tuple[bool, ...]], none: tuple[bool, ...]
) -> tuple[tuple[bool, ...], tuple[bool, ...]]:
    motors, azimuths = (
        (value or none) if isinstance(value := changes.get(name, last), list | tuple) else none
        for name, last in zip((FAILED, AZIMUTH_FAILED), before, strict=True)
    )
    return tuple(motors), tuple(azimuths)
