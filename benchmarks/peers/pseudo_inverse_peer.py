"""MCSimPython's two allocators: pseudo-inverse with free directions, and with fixed ones."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from benchmarks.demands import Step
from benchmarks.peers.peer import Commands, Peer, PeerMissingError, titled
from marine_model import Vessel


class PseudoInverse(Peer):
    """`pseudo_inverse_allocator` where thrusters rotate, `fixed_angle_allocator` where they do not.

    Its thrust coefficients are set to 1, so that its control inputs are thrusts.

    Parameters
    ----------
    vessel
        Geometry.
    rotating
        Which of the two.
    """

    def __init__(self, vessel: Vessel, rotating: bool) -> None:
        try:
            allocation = importlib.import_module("MCSimPython.thrust_allocation.allocation")
            thruster = importlib.import_module("MCSimPython.thrust_allocation.thruster")
        except ImportError as error:
            raise PeerMissingError(f"MCSimPython cannot be imported: {error}") from error
        self._rotating = rotating
        self._allocator: Any = allocation.pseudo_inverse_allocator() if rotating else allocation.fixed_angle_allocator()
        if not rotating:
            # Its directions belong to another ship.
            self._allocator.alpha = vessel.fixed_direction.copy()
        for x, y in zip(vessel.lever_x.tolist(), vessel.lever_y.tolist(), strict=True):
            self._allocator.add_thruster(thruster.Thruster([x, y], 1.0))

    @property
    def name(self) -> str:
        """Stable name."""
        return "mcsimpython"

    @property
    def title(self) -> str:
        """What it is."""
        return f"{titled('MCSimPython')}, {'pseudo-inverse' if self._rotating else 'fixed angle'}"

    @property
    def remark(self) -> str:
        """What it cannot do by design."""
        if self._rotating:
            return "no limits, no weights, and it turns the tunnel thruster too, by design"
        return "no limits, no weights, by design"

    def prepare(self, step: Step) -> Any:
        """Return the demand."""
        return step.tau

    def solve(self, task: Any) -> Any:
        """Allocate."""
        return self._allocator.allocate(task)

    def commands(self, step: Step, answer: Any) -> Commands | None:
        """Return what it says."""
        thrust, azimuth = answer
        return np.asarray(thrust), np.asarray(azimuth)
