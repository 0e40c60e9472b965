"""Thrusts and torque losses in the same panels."""

from __future__ import annotations

from typing import Literal

from dp_tools.plot_specs.base import PartPlot


class ThrustAndLoss(PartPlot):
    """Commanded thrust of every thruster with its beta_Q2; the first one's panel shows when anti-spin was on."""

    kind: Literal["thrust_and_loss"]
