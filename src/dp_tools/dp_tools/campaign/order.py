"""What to sail, and what came of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from dp_tools.campaign.comparison import differences
from dp_tools.campaign.fingerprint import fingerprint
from dp_tools.figures import Measurement, compute_figures
from dp_tools.run_data import RunData, RunInfo
from dp_tools.scenario import Scenario, load_scenario
from marine_model import Vessel, load_vessel


@dataclass(frozen=True)
class Order:
    """One run to be sailed in process, or one that the graph has sailed to be judged.

    Parameters
    ----------
    scenario
        Name or path.
    vessel
        Name or path; empty for the scenario's own.
    seed
        Of the simulator.
    folder
        Where report and bag go; None for neither.
    bag
        True to write the bag of a run sailed in process.
    recorded
        Bag of a run of the graph, to be judged; None to sail in process.
    compare
        True to sail the recorded run in process as well and to say how far they are apart.
    """

    scenario: str
    vessel: str
    seed: int
    folder: Path | None = None
    bag: bool = False
    recorded: Path | None = None
    compare: bool = False

    def load(self) -> tuple[Vessel, Scenario]:
        """Return vessel and scenario, with the seed of this run. Raises DpError."""
        chosen = load_vessel(self.vessel) if self.vessel else None
        scenario = load_scenario(self.scenario, chosen)
        vessel = chosen or load_vessel(scenario.vessel)
        return vessel, scenario.model_copy(update={"seed": self.seed})


@dataclass(frozen=True)
class Outcome:
    """One run, as far as a table over many needs it.

    Attributes
    ----------
    info
        Who sailed what.
    figures
        By name.
    fingerprint
        Equal for runs that are equal to the bit.
    apart
        Largest differences from the run in process, by series; None where they were not asked for.
    """

    info: RunInfo
    figures: Mapping[str, Measurement]
    fingerprint: str
    apart: Mapping[str, float] | None = field(default=None)

    @classmethod
    def of(cls, run: RunData, scenario: Scenario, vessel: Vessel, other: RunData | None = None) -> Outcome:
        """Judge a run; compare it with ``other``. Raises InputError."""
        figures = {
            figure.spec.name: Measurement(figure.value, figure.low, figure.high)
            for figure in compute_figures(run, scenario, vessel)
        }
        return cls(run.info, figures, fingerprint(run), None if other is None else differences(run, other))

    def document(self) -> dict[str, Any]:
        """Return this as JSON takes it; an infinite difference is null."""
        apart = self.apart
        return {
            "info": asdict(self.info),
            "fingerprint": self.fingerprint,
            "figures": {name: asdict(one) for name, one in self.figures.items()},
            "apart": None if apart is None else {n: v if math.isfinite(v) else None for n, v in apart.items()},
        }

    @classmethod
    def from_document(cls, content: Mapping[str, Any]) -> Outcome:
        """Return what :meth:`document` made. Raises KeyError, TypeError if it did not."""
        apart = content["apart"]
        return cls(
            RunInfo(**content["info"]),
            {name: Measurement(**one) for name, one in content["figures"].items()},
            content["fingerprint"],
            None if apart is None else {name: math.inf if v is None else v for name, v in apart.items()},
        )
