"""Thrusts and torque losses in the same panels."""

from __future__ import annotations

from typing import Literal

from dp_tools.plot_specs.base import PlotSpec


class ThrustAndLoss(PlotSpec):
    """Commanded thrust of every thruster with its beta_Q2; the first one's panel shows when anti-spin was on."""

    kind: Literal["thrust_and_loss"]
    window: str = ""  # empty: the whole run

    def windows(self) -> tuple[tuple[str, str], ...]:
        """Return the window, if there is one."""
        return (("window", self.window),) if self.window else ()
