"""The simulator that a vessel needs."""

from __future__ import annotations

from marine_model.vessel import Vessel
from vessel_sim.interface import VesselSimulator
from vessel_sim.settings import SimulatorSettings
from vessel_sim.simulator import Simulator
from vessel_sim.underwater import UnderwaterSimulator


def make_simulator(vessel: Vessel, settings: SimulatorSettings | None = None) -> VesselSimulator:
    """Return a :class:`Simulator`, or an :class:`UnderwaterSimulator` for a vessel with a section ``underwater``.

    Raises
    ------
    InputError
        As they do.
    """
    kind = UnderwaterSimulator if vessel.is_submerged else Simulator
    return kind(vessel, settings)
