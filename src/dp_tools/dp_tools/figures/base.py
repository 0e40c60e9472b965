"""What every figure of merit is: asked for in a scenario file, worked out from a run."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from dp_tools.figures.samples import column
from dp_tools.interval import batch_jackknife
from dp_tools.run_data import RunData, Series
from marine_model import Vessel
from marine_model.guards import FloatArray
from marine_model.schema import Section
from marine_model.units import Unit

if TYPE_CHECKING:
    from dp_tools.scenario import Scenario

# How a number is shown: with its unit, as a change in per cent with a sign, or as a share in per cent.
Shown = Literal["quantity", "change", "share"]
# A number in the unit of the figure, which depends on its other fields.
InFiguresUnit = Annotated[float | None, Unit("")]


def _as_names(value: Any) -> Any:
    """Return one name as a tuple of one, and a list as a tuple; what is neither is left for the schema to refuse."""
    if isinstance(value, str):
        return (value,)
    return tuple(value) if isinstance(value, list) else value


# One window, or several whose samples count together.
Windows = Annotated[tuple[str, ...], BeforeValidator(_as_names), Field(min_length=1)]


@dataclass(frozen=True)
class Measurement:
    """A figure of one run.

    Parameters
    ----------
    value
        In the unit of its spec; None where the run never got there (a demand that is not reached).
    low, high
        Ends of the 95 % confidence interval; None for extremes and counts, which one run gives no interval for.
    """

    value: float | None
    low: float | None = None
    high: float | None = None

    @classmethod
    def of(cls, statistic: Callable[..., float], *samples: FloatArray) -> Measurement:
        """Return a statistic of one or more windows, with its interval."""
        low, high = batch_jackknife(statistic, samples)
        return cls(statistic(*samples), low, high)


class FigureSpec(Section):
    """One figure of merit in a scenario file; a kind is a subclass, told apart by its field ``kind``."""

    shown: ClassVar[Shown] = "quantity"

    name: str = Field(pattern=r"^[a-z][a-z0-9_]*$")  # in figures.json
    title: str = Field(min_length=1)  # in the report
    thesis: InFiguresUnit = None  # what the thesis prints
    source: str = ""  # where it is printed
    reason: str = ""  # why ours may differ, or why the thesis has no number
    at_most: InFiguresUnit = None  # bounds that must hold
    at_least: InFiguresUnit = None
    # The windows hold a manoeuvre instead of a steady state: the scatter within one run says nothing, so no interval.
    transient: bool = False

    @property
    @abstractmethod
    def unit(self) -> str:
        """SI, degrees for angles, 1 for a ratio or a count."""

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return (field, window name) of every window that this needs."""
        return ()

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return (field, thruster name) of every thruster that this needs."""
        return ()

    @abstractmethod
    def measure(self, run: RunData, scenario: Scenario, vessel: Vessel) -> Measurement:
        """Work it out.

        Raises
        ------
        InputError
            If a series or part of the run is missing.
        """


class WindowFigure(FigureSpec):
    """A figure over one window."""

    window: str

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window."""
        return (("window", self.window),)


class ComparedFigure(FigureSpec):
    """A figure of one window over that of another, minus one; several windows on a side count together."""

    shown: ClassVar[Shown] = "change"
    unit: ClassVar[str] = "1"

    baseline: Windows
    compared: Windows

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return both windows."""
        return (
            *(("baseline", window) for window in self.baseline),
            *(("compared", window) for window in self.compared),
        )

    def sides(self, series: Series, scenario: Scenario, index: int) -> tuple[FloatArray, FloatArray]:
        """Return the samples of one column of ``series``: of the baseline, and of what is compared with it."""
        return column(series, scenario, self.baseline, index), column(series, scenario, self.compared, index)


class ThrusterFigure(FigureSpec):
    """A figure of one thruster."""

    thruster: str

    def thrusters(self) -> tuple[tuple[str, str], ...]:
        """Return the thruster."""
        return (("thruster", self.thruster),)
