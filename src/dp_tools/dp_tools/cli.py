"""The `dp` command: the operator's work without the `ros2` command."""

from __future__ import annotations

from dp_tools.commands.bag import bag_app
from dp_tools.commands.compare import compare
from dp_tools.commands.design import design
from dp_tools.commands.detection import detection
from dp_tools.commands.disturb import disturb
from dp_tools.commands.open_water import open_water_app
from dp_tools.commands.parameters import parameters_app
from dp_tools.commands.propeller import propeller
from dp_tools.commands.record import record
from dp_tools.commands.replay import replay
from dp_tools.commands.report import report
from dp_tools.commands.restart import restart
from dp_tools.commands.root import app, main
from dp_tools.commands.scenarios import scenario_app
from dp_tools.commands.status import status
from dp_tools.commands.topics import topics
from dp_tools.commands.up import up
from dp_tools.commands.vessels import vessel_app

app.command()(up)
app.command()(record)
app.command()(replay)
app.command()(report)
app.command()(status)
app.command()(topics)
app.command()(restart)
app.command()(design)
app.command()(compare)
app.command()(propeller)
app.command()(detection)
app.command()(disturb)
app.add_typer(bag_app, name="bag")
app.add_typer(parameters_app, name="param")
app.add_typer(scenario_app, name="scenario")
app.add_typer(vessel_app, name="vessel")
app.add_typer(open_water_app, name="open-water")

__all__ = ["app", "main"]
