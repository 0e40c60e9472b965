"""MCSimPython (NTNU) as a peer of the in-process loop: its model ship, its waves, and its own station keeping.

What is wired here is what the package offers, with the step of our simulator and the waves of our scenario. Everything
runs at every step, as in the package's demonstrations: its observer and integrators are written for the step of the
simulation. Nothing is logged.
"""

from __future__ import annotations

import contextlib
import importlib
import io
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from marine_model import Vessel
from marine_model.errors import DpError
from marine_model.settings import Settings
from vessel_sim.noise import own_sequence
from vessel_sim.waves.components import AMPLITUDE, BETA, OMEGA, PHASE
from vessel_sim.waves.from_settings import components_of

PEER = "MCSimPython 0.1.6"

_MODULES = (
    "control.basic",
    "guidance.filter",
    "observer.nonlinobs",
    "simulator.csad",
    "simulator.thruster_dynamics",
    "thrust_allocation.allocation",
    "thrust_allocation.thruster",
    "vessel_data.CSAD.thruster_data",
    "waves.wave_loads",
)
# Surge, sway and yaw of its six components.
_HORIZONTAL = [0, 1, 5]


class PeerMissingError(DpError):
    """MCSimPython cannot be imported; the message says why."""


class VesselInWaves:
    """C/S Arctic Drillship, 3-DOF manoeuvring model, adrift in the wave components of our scenario.

    Per step: first- and second-order wave load of its transfer functions, then its step of the hull (explicit Euler,
    its default and cheapest). No thrusters, observer, controller or allocator.

    Parameters
    ----------
    vessel
        Ours; gives the time step, and gains where the peer needs some.
    settings
        Of the nodes at the start of our scenario; gives the waves.

    Raises
    ------
    PeerMissingError
        If MCSimPython cannot be imported.
    """

    def __init__(self, vessel: Vessel, settings: Mapping[str, Settings]) -> None:
        self._dt = vessel.simulation.time_step
        self._modules = _import()
        self._ship = self._modules.csad.CSADMan3DOF(self._dt)
        simulator: Any = settings["vessel_sim"]
        waves = components_of(simulator.waves, own_sequence(simulator.seed, "sea"))
        with contextlib.redirect_stdout(io.StringIO()):  # it reports progress on standard output
            self._waves = self._modules.wave_loads.WaveLoad(
                *(waves[:, column].copy() for column in (AMPLITUDE, OMEGA, PHASE, BETA)),
                self._ship._config_file,
                rho=vessel.density,
            )
        self._tick = 0

    def sail(self, seconds: float) -> None:
        """Go on by ``seconds`` of simulated time."""
        for _ in range(round(seconds / self._dt)):
            self._step()

    @property
    def position(self) -> Any:
        """North, east (m) and heading (rad)."""
        return self._ship.get_eta()

    def _step(self) -> None:
        self._ship.integrate(0.0, 0.0, self._wave_load())
        self._tick += 1

    def _wave_load(self) -> Any:
        # Not by calling the object: that takes the last but one component for the heading.
        eta, time = self._ship.get_eta(), self._tick * self._dt
        load = self._waves.first_order_loads(time, eta) + self._waves.second_order_loads(time, eta[-1])
        return load[_HORIZONTAL]


class StationKeeping(VesselInWaves):
    """The same, held at the origin by its own parts.

    Beside the vessel in waves: nonlinear passive observer, third-order reference filter, PID controller,
    pseudo-inverse allocation and static thruster forces. No thrust, rate or azimuth limits, no shafts, no noise.
    """

    def __init__(self, vessel: Vessel, settings: Mapping[str, Settings]) -> None:
        super().__init__(vessel, settings)
        m, ship, gains = self._modules, self._ship, vessel.observer
        self._observer = m.nonlinobs.NonlinObs3dof(
            self._dt,
            gains.cutoff_ratio[0] * gains.wave_frequency[0],
            gains.wave_frequency[0],
            gains.wave_damping[0],
            gains.bias_time_constant[0],
            ship._M,
            ship._D + ship._Bv,
        )
        # Poles as for a critically damped mass; integral action a tenth as fast.
        frequency = vessel.controller.reference.frequency
        mass = np.diag(ship._M)
        self._controller = m.basic.PID(
            list(frequency**2 * mass), list(2.0 * frequency * mass), list(0.1 * frequency**3 * mass), self._dt
        )
        self._reference = m.filter.ThrdOrderRefFilter(self._dt)
        self._reference.set_eta_r(np.zeros(3))
        self._allocator = m.allocation.pseudo_inverse_allocator()
        data = m.thruster_data
        for x, y, factor in zip(data.lx, data.ly, data.K, strict=True):
            self._allocator.add_thruster(m.thruster.Thruster([x, y], factor))
        self._thrusters = m.thruster_dynamics.ThrusterDynamics()
        self._tau = np.zeros(3)

    def _step(self) -> None:
        self._observer.update(self._ship.get_eta(), self._tau)
        self._reference.update()
        demand = self._controller.get_tau(
            self._observer.eta, self._reference.get_eta_d(), self._observer.nu, self._reference.get_nu_d()
        )
        self._tau = self._thrusters.get_tau(*self._allocator.allocate(demand))
        self._ship.integrate(0.0, 0.0, self._tau + self._wave_load())
        self._tick += 1


def _import() -> SimpleNamespace:
    """Return the modules of the package by their last names."""
    try:
        return SimpleNamespace(
            **{name.rpartition(".")[2]: importlib.import_module(f"MCSimPython.{name}") for name in _MODULES}
        )
    except ImportError as error:
        raise PeerMissingError(f"MCSimPython cannot be imported: {error}") from error
