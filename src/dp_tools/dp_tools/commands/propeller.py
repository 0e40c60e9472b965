"""`dp propeller`: curves, maps and controllers of a propeller."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dp_tools.commands.root import console
from marine_model import load_vessel


def propeller(
    vessel: Annotated[str, typer.Argument(metavar="[VESSEL]", help="Vessel, by name or file.")] = "",
    thruster: Annotated[
        str, typer.Option(metavar="NAME", help="One thruster of the vessel; all of them if left out.")
    ] = "",
    propeller_file: Annotated[
        str,
        typer.Option(
            "--propeller",
            metavar="NAME",
            help="A propeller by itself in place of a vessel, by name (wageningen_b4_70) or file.",
        ),
    ] = "",
    tau: Annotated[
        float, typer.Option(metavar="TAU", help="Where plots over tau and the comparison of controllers end.")
    ] = 6.0,
    output: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Folder for plots, CSV and JSON; propeller/<vessel> if left out."),
    ] = None,
    plots: Annotated[bool, typer.Option("--plots/--no-plots", help="Write plots, CSV and JSON, or print only.")] = True,
) -> None:
    """Look at propellers: open-water curves, efficiency over (tau, P/D), optimal paths, controllers, ventilation.

    tau = sqrt(rho) D V_A / sqrt(T) is 0 at bollard pull and large where the propeller is lightly loaded. The pictures
    are Figures 2.2, 2.10 and 3.3 to 3.14 of the thesis, the comparison its Table 3.3. With --no-plots and an --output
    the numbers are written without pictures.
    """
    if bool(vessel) == bool(propeller_file):
        raise typer.BadParameter("expected a vessel, or --propeller NAME, and not both")
    if propeller_file and thruster:
        raise typer.BadParameter("--thruster is of a vessel; a propeller file has none")
    # Plotting libraries load slowly; only this command waits for them.
    from dp_tools.propeller.run import run_propeller
    from dp_tools.propeller.subject import subject_of, subjects_of
    from marine_model.propeller_file import load_propeller

    if vessel:
        chosen = load_vessel(vessel)
        subjects, name = subjects_of(chosen, thruster), chosen.name
    else:
        one = load_propeller(propeller_file)
        subjects, name = (subject_of(one),), one.name
    folder = output or (Path("propeller") / name if plots else None)
    run_propeller(console, subjects, tau, folder, plots)
