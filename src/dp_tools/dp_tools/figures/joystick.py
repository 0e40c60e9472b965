"""Figures of steps of the joystick."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np

from dp_tools.figures.base import Measurement, WindowFigure
from dp_tools.run_data import RunData
from marine_model import Vessel
from marine_model.schema import PositiveVector3
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario


class TimeToDemand(WindowFigure):
    """Longest time from a joystick step until the commanded force has come, and stays, within tolerance of it, s."""

    unit: ClassVar[str] = "s"

    kind: Literal["time_to_demand"]
    tolerance: Annotated[PositiveVector3, Unit("N, N, N m")]

    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Return the longest of all steps."""
        times = [took for _, took in times_to_demand(self, run, scenario)]
        if not times or any(took is None for took in times):
            return Measurement(None)
        return Measurement(max(took for took in times if took is not None))


def times_to_demand(spec: TimeToDemand, run: RunData, scenario: Scenario) -> tuple[tuple[float, float | None], ...]:
    """Return (time of the step, time it took) of every joystick step in the window of ``spec``, s.

    The time it took is None where the commanded force was not within tolerance of the demand for good before the
    next step.
    """
    start, end = scenario.windows[spec.window]
    starts = [e.at for e in scenario.events if e.joystick is not None and start <= e.at < end]
    answers: list[tuple[float, float | None]] = []
    for at, until in zip(starts, [*starts[1:], end], strict=True):
        demand = run["tau_desired"].window(at, until)
        achieved = run["tau_achieved"].window(at, until)
        away = np.abs(achieved.values - demand.at(achieved.t)) > np.array(spec.tolerance)
        outside = np.flatnonzero(away.any(axis=1))
        if len(outside) == 0:
            answers.append((at, 0.0))
        elif outside[-1] + 1 == len(achieved.t):
            answers.append((at, None))
        else:
            answers.append((at, round(float(achieved.t[outside[-1] + 1]) - at, 9)))  # stamps are whole ns
    return tuple(answers)
