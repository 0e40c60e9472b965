"""Compiles the inner loops ahead of their first use: ``python3 -m dp_tools.machine_code``.

Without it the first allocator and the first simulator on a machine compile them when they are made, which takes half a
minute. The machine code stays beside the modules, or in the user's cache folder where those cannot be written.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from marine_model import load_vessel
from marine_model.propellers.kernel import load, thrust_torque
from marine_model.ventilation.static import VentilationModel
from thrust_allocator.allocator import Allocator
from thrust_allocator.attainable import largest_ball, scale_to_boundary
from thrust_allocator.attainable.force_set import force_set
from thrust_allocator.settings import AllocatorSettings, PowerSettings, SectorSettings
from thrust_allocator.singularity import gain_map, minimum_gain, scaled_configuration
from thrust_allocator.singularity.settings import SingularitySettings
from thruster_drivers.ventilation import VentilationMonitor
from vessel_sim import (
    Simulator,
    SimulatorInputs,
    SimulatorSettings,
    UnderwaterSimulator,
    WaveSettings,
    WindSettings,
)
from vessel_sim.inflow import Inflow
from vessel_sim.propulsion import PropulsionPlant
from vessel_sim.waves import Waves, hull_in_waves

_VESSEL = "cybership3"
_TAU = (3.0, 1.0, 0.5)


def _allocation() -> None:
    vessel = load_vessel(_VESSEL)
    for changes in (
        {"cost": "power_3_2", "over_demand": "proportional"},
        {"sectors": SectorSettings(enabled=True)},
        {"power": PowerSettings(limit="both", available=1.0, bus_limit=(0.5,) * len(vessel.power.buses))},
    ):
        Allocator(vessel, AllocatorSettings.for_vessel(vessel, azimuth_mode="rotating", **changes))


def _monitoring() -> None:
    vessel = load_vessel(_VESSEL)
    settings = AllocatorSettings.for_vessel(
        vessel, azimuth_mode="rotating", singularity=SingularitySettings(monitor="all")
    )
    result = Allocator(vessel, settings).step(_TAU, vessel.measurement.sample_time)
    result.gains, result.margin, result.gain_both_ways  # noqa: B018 - computed when read
    for azimuth in (None, vessel.fixed_direction):
        scale_to_boundary(vessel, azimuth, _TAU)
    largest_ball(force_set(vessel, None))


def _singularity() -> None:
    vessel = load_vessel(_VESSEL)
    for method in ("three_step", "required_gain", "crossing"):
        settings = AllocatorSettings.for_vessel(
            vessel, azimuth_mode="rotating", singularity=SingularitySettings(method=method)
        )
        Allocator(vessel, settings)
    B = scaled_configuration(vessel, vessel.fixed_direction)
    for unidirectional in (None, np.ones(B.shape[1], dtype=np.bool_)):
        minimum_gain(B, unidirectional)
    angles = np.linspace(-math.pi, math.pi, 3)
    gain_map(vessel, (2, 3), (angles, angles), vessel.fixed_direction)


def _sea() -> None:
    vessel = load_vessel(_VESSEL)
    waves = Waves(hull_in_waves(vessel), WaveSettings(amplitude=0.01))
    origin = (0.0, 0.0, 0.0)
    Inflow(vessel).at(origin, origin, np.zeros(len(vessel.thrusters)), waves, 0.0)
    waves.elevation(0.0, 0.0, 0.0)
    waves.particle_velocity(0.0, 0.0, 0.0, 0.0)
    waves.motion(origin, (0.0, 0.0), 0.0)
    if vessel.ventilation is not None:
        VentilationModel(vessel.ventilation).loss_factors(1.0, 1.0, 1.0, 1.0)


def _propellers() -> None:
    vessel = load_vessel(_VESSEL)
    for function in (thrust_torque, load):
        function(vessel.propeller_table[0], vessel.propeller_models[0].diameter, vessel.density, 1.0, 0.1, 1.0)


def _simulation() -> None:
    _sea()
    vessel = load_vessel(_VESSEL)
    simulator = Simulator(vessel, SimulatorSettings(wind=WindSettings(speed=1.0, gusts=True)))
    still = np.zeros(len(vessel.thrusters))
    # The second step begins where the first one ended.
    for _ in range(2):
        simulator.step(SimulatorInputs(still, still), vessel.simulation.time_step)
    simulator.truth(), simulator.measure(), simulator.measure_wind()
    PropulsionPlant(vessel).step(still, still, None, still, still, vessel.simulation.time_step)


def _underwater() -> None:
    vessel = load_vessel("ukwial")
    simulator = UnderwaterSimulator(vessel)
    still = np.zeros(len(vessel.thrusters))
    simulator.step(SimulatorInputs(still, still), vessel.simulation.time_step)
    simulator.truth()


def _detection() -> None:
    vessel = load_vessel(_VESSEL)
    VentilationMonitor(vessel)


PARTS: dict[str, Callable[[], None]] = {
    "allocation": _allocation,
    "monitoring": _monitoring,
    "singularity": _singularity,
    "propellers": _propellers,
    "simulation": _simulation,
    "underwater": _underwater,
    "detection": _detection,
}


def _compile(part: str) -> str:
    PARTS[part]()
    return part


def main() -> None:
    """Compile the first part, which the others use, and then those, as many at once as there are processors."""
    first, *others = PARTS
    with ProcessPoolExecutor(min(os.cpu_count() or 1, len(others)), mp_context=get_context("spawn")) as pool:
        _tell(pool.submit(_compile, first).result())
        for part in pool.map(_compile, others):
            _tell(part)


def _tell(part: str) -> None:
    print(f"compiled: {part}", flush=True)


if __name__ == "__main__":
    main()
