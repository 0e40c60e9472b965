"""Command line."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import capytaine as cpt

from hydrodynamics import checks, convergence
from hydrodynamics.body import Hull
from hydrodynamics.comments import comments
from hydrodynamics.response import HEADINGS, respond
from hydrodynamics.table import write
from marine_model.errors import DpError
from marine_model.load import load_vessel
from marine_model.vessel import Vessel
from marine_model.wave_response.load import FOLDER

# Of the length. At omega sqrt(L / g) = 7 a wave is 0.128 L long: five panels.
PANEL = 0.025


def main(arguments: Sequence[str]) -> int:
    """Run the command; return its exit status."""
    chosen = _parser().parse_args(arguments)
    # capytaine reports every panel that is not quite plane, and there are as many as the hull is curved.
    cpt.set_logging("ERROR")
    try:
        vessel = load_vessel(chosen.vessel)
        if chosen.convergence:
            print(convergence.table(vessel))
        elif chosen.check:
            return checks.run(hull_of(vessel, chosen.panel))
        else:
            _compute(vessel, chosen.panel, chosen.output or FOLDER / f"{vessel.name}.csv")
    except (DpError, ValueError, OSError) as error:
        print(f"hydrodynamics: {error}", file=sys.stderr)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python scripts/hydrodynamics",
        description="Motion and mean drift of a hull in waves by potential flow (capytaine), as a data file for the "
        "field wave_forces.response of a vessel file. Takes some minutes.",
    )
    parser.add_argument("vessel", help="name or path of a vessel file; its hull section and density are used")
    parser.add_argument("-o", "--output", type=Path, help="data file (default: NAME.csv among those of marine_model)")
    parser.add_argument(
        "--panel", type=float, default=PANEL, help="side of a panel over the length of the ship (default: %(default)s)"
    )
    mode = parser.add_mutually_exclusive_group()
    mode.add_argument("--check", action="store_true", help="compare with limits and conservation laws; write nothing")
    mode.add_argument("--convergence", action="store_true", help="print a table over panel sizes; write nothing")
    return parser


def hull_of(vessel: Vessel, panel: float) -> Hull:
    """Return the hull of ``vessel`` with panels of side ``panel`` over its length. Trim is left out."""
    hull = vessel.hull
    return Hull.of(hull.length, hull.beam, hull.draught, hull.mass / vessel.density, panel)


def _compute(vessel: Vessel, panel: float, output: Path) -> None:
    start = time.monotonic()
    hull = hull_of(vessel, panel)

    def progress(done: int, count: int) -> None:
        print(f"\r{done + 1} of {count} frequencies, {time.monotonic() - start:.0f} s", end="", file=sys.stderr)

    response = respond(hull, None, HEADINGS, progress).all_round()
    print(file=sys.stderr)
    lines = comments(vessel, hull, response, panel)
    write(output, lines, response)
    print("\n".join(lines))
    print(f"written to {output} in {time.monotonic() - start:.0f} s")
