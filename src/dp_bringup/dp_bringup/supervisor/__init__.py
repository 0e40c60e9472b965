"""Looks after the processes of a graph in real time: brings them up in order, restarts who dies or hangs, says so."""

from dp_bringup.supervisor.rules import Rules
from dp_bringup.supervisor.supervisor import SUPERVISOR, CannotStartError, Supervisor
from dp_bringup.supervisor.unit import UnitPlan, plan_units

__all__ = ["SUPERVISOR", "CannotStartError", "Rules", "Supervisor", "UnitPlan", "plan_units"]
