"""What every picture of a report is made from, and what it becomes."""

from __future__ import annotations

from dataclasses import dataclass

from dp_tools.faults import Fault, faults
from dp_tools.figures.power import MeanPower, MeanPowerChange
from dp_tools.report.panels import Panels
from dp_tools.run_data import RunData
from dp_tools.scenario import Scenario
from marine_model import Vessel

Span = tuple[float, float]


@dataclass(frozen=True)
class Picture:
    """One picture with its text."""

    title: str
    text: str
    image: str  # data URI
    alt: str
    narrow: bool = False


@dataclass(frozen=True)
class Scene:
    """What every picture is made from."""

    run: RunData
    scenario: Scenario
    vessel: Vessel

    @property
    def whole(self) -> Span:
        """(0, end) of the run, s."""
        return 0.0, max(self.run.duration, 1e-9)

    def span(self, window: str) -> Span:
        """Return (start, end) of a window, s; of the whole run without a name."""
        return self.scenario.windows[window] if window else self.whole

    @property
    def faults(self) -> tuple[Fault, ...]:
        """When which thrusters are faulty."""
        return faults(self.scenario, self.vessel)

    @property
    def measured_windows(self) -> tuple[str, ...]:
        """Windows that figures are worked out over, close-ups apart, in the order of the file."""
        used = {window for spec in self.scenario.figures for _, window in spec.windows()}
        close_ups = {close_up.window for close_up in self.scenario.close_ups}
        return tuple(name for name in self.scenario.windows if name in used - close_ups)

    @property
    def power_windows(self) -> tuple[str, ...]:
        """Windows whose mean power is asked for."""
        powers = [spec for spec in self.scenario.figures if isinstance(spec, MeanPower | MeanPowerChange)]
        used = {window for spec in powers for _, window in spec.windows()}
        return tuple(name for name in self.measured_windows if name in used)

    @property
    def automatic(self) -> bool:
        """True if the controller held anything automatically at any time."""
        terms = ("proportional", "integral", "derivative")
        return any(name in self.run and bool(self.run[name].values.any()) for name in terms)

    def panels(self, labels: tuple[str, ...], span: Span, height: float = 1.5, own_legends: bool = False) -> Panels:
        """Return empty panels for this run; where thrusters are faulty they are shaded.

        A panel that is called after a thruster is shaded for that thruster alone.
        """
        found = self.faults
        # Windows that only name the stretches of faults would hide them.
        marked = () if found else self.measured_windows
        panels = Panels(labels, self.scenario, span, height, marked, own_legends)
        names = {name.replace("_", " "): j for j, name in enumerate(self.run.thrusters)}
        for i, label in enumerate(labels):
            j = names.get(label.partition("\n")[0])
            for fault in found:
                if j is None or fault.thrusters[j]:
                    panels.shade(i, fault.start, fault.end)
        return panels
