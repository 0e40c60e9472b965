"""One scenario over its seeds: what is kept of it, and what is said of it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from dp_tools.campaign.comparison import largest
from dp_tools.campaign.order import Outcome
from dp_tools.campaign.over_seeds import Spread, Verdict, over_seeds, verdicts
from dp_tools.figures import AnyFigure, FigureSpec
from dp_tools.scenario import Scenario
from marine_model.errors import DocumentError

SUMMARY_NAME = "seeds.json"
_SPECS: TypeAdapter[tuple[FigureSpec, ...]] = TypeAdapter(tuple[AnyFigure, ...])


@dataclass(frozen=True)
class JudgedFigure:
    """A figure over the seeds, and what to say of it."""

    spec: FigureSpec
    spread: Spread
    verdicts: tuple[Verdict, ...]

    @property
    def unexplained(self) -> bool:
        """Whether ours differs from the printed number and the scenario does not say why."""
        return Verdict.DIFFERS in self.verdicts and not self.spec.reason


@dataclass(frozen=True)
class RunSummary:
    """One scenario over its seeds.

    Attributes
    ----------
    name, title
        Of the scenario.
    machine
        That sailed it.
    specs
        Figures that it asks for.
    outcomes
        One a seed.
    failures
        Seed and reason of those that did not come to their end.
    """

    name: str
    title: str
    machine: str
    specs: tuple[FigureSpec, ...]
    outcomes: tuple[Outcome, ...]
    failures: tuple[tuple[int, str], ...] = field(default=())

    @classmethod
    def of(
        cls, scenario: Scenario, machine: str, outcomes: Sequence[Outcome], failures: Sequence[tuple[int, str]] = ()
    ) -> RunSummary:
        """Return the summary of runs of ``scenario``."""
        return cls(scenario.name, scenario.title, machine, scenario.figures, tuple(outcomes), tuple(failures))

    @property
    def run(self) -> str:
        """``A`` for ``run_a``, another name as it is."""
        short = self.name.removeprefix("run_")
        return short.upper() if len(short) == 1 else self.name

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds that were sailed to the end."""
        return tuple(outcome.info.seed for outcome in self.outcomes)

    @property
    def how(self) -> str:
        """How they were sailed."""
        return ", ".join(dict.fromkeys(outcome.info.how for outcome in self.outcomes))

    @property
    def real_time_factor(self) -> float | None:
        """Simulated over wall time of all seeds; None where that is not known."""
        wall = math.fsum(outcome.info.wall_time for outcome in self.outcomes)
        return math.fsum(outcome.info.simulated_time for outcome in self.outcomes) / wall if wall > 0.0 else None

    @property
    def apart(self) -> tuple[str, float] | None:
        """Series and size of the largest difference from the run in process; None where nothing was compared."""
        found = [largest(outcome.apart) for outcome in self.outcomes if outcome.apart is not None]
        return max(found, key=lambda one: one[1]) if found else None

    def figures(self) -> tuple[JudgedFigure, ...]:
        """Return every figure over the seeds, in the order of the scenario; none without an outcome."""
        judged = []
        for spec in self.specs if self.outcomes else ():
            spread = over_seeds([outcome.figures[spec.name] for outcome in self.outcomes])
            judged.append(JudgedFigure(spec, spread, verdicts(spec, spread)))
        return tuple(judged)

    def write(self, folder: Path) -> None:
        """Write seeds.json."""
        document = {
            "name": self.name,
            "title": self.title,
            "machine": self.machine,
            "figures": [spec.model_dump(mode="json") for spec in self.specs],
            "outcomes": [outcome.document() for outcome in self.outcomes],
            "failures": [list(failure) for failure in self.failures],
        }
        text = json.dumps(document, indent=1, allow_nan=False) + "\n"
        (folder / SUMMARY_NAME).write_text(text, encoding="utf-8")


def read_summary(path: Path) -> RunSummary:
    """Return what :meth:`RunSummary.write` wrote. Raises DocumentError."""
    try:
        content: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return RunSummary(
            content["name"],
            content["title"],
            content["machine"],
            _SPECS.validate_python([_without_none(one) for one in content["figures"]], strict=False),
            tuple(Outcome.from_document(one) for one in content["outcomes"]),
            tuple((int(seed), str(why)) for seed, why in content["failures"]),
        )
    except (OSError, ValueError, KeyError, TypeError, ValidationError) as error:
        raise DocumentError(f"{path}: expected a summary of runs, found {error}") from error


def _without_none(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in fields.items() if value is not None}
