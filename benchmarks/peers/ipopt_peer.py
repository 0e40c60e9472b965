"""CasADi with IPOPT on the polar form: [Ruth] (4.10)-(4.13), thrusts and directions as variables."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.demands import Step
from benchmarks.peers.peer import Commands, Peer, PeerMissingError, titled
from marine_model import Vessel
from marine_model.frames import wrap_angle


class Ipopt(Peer):
    """A nonlinear program made once, with the demand as its parameter; started from the command of the step before.

    Parameters
    ----------
    vessel
        Geometry, limits and weights.
    rotating
        Azimuth thrusters rotate; they keep their directions otherwise.
    """

    def __init__(self, vessel: Vessel, rotating: bool) -> None:
        try:
            import casadi
        except ImportError as error:
            raise PeerMissingError(f"casadi cannot be imported: {error}") from error
        self._vessel = vessel
        n = len(vessel.thrusters)
        self._n = n
        self._turning = np.array(vessel.can_rotate) & rotating
        thrust, azimuth, slack = (casadi.SX.sym(*of) for of in (("T", n), ("alpha", n), ("s", 3)))
        tau = casadi.SX.sym("tau", 3)
        x, y = thrust * casadi.cos(azimuth), thrust * casadi.sin(azimuth)
        lever_x, lever_y = casadi.DM(vessel.lever_x), casadi.DM(vessel.lever_y)
        force = casadi.vertcat(casadi.sum1(x), casadi.sum1(y), casadi.sum1(lever_x * y - lever_y * x))
        gains = vessel.allocator
        slack_weights = casadi.DM((gains.slack_gain * np.array(gains.slack_weight)) ** 2)
        thrust_weights = casadi.DM(np.array(gains.thrust_weight) ** 2)
        cost = casadi.dot(slack_weights, slack**2) + casadi.dot(thrust_weights, thrust**2)
        program = {"x": casadi.vertcat(thrust, azimuth, slack), "p": tau, "f": cost, "g": force + slack - tau}
        options: dict[str, Any] = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}
        self._solve = casadi.nlpsol("allocation", "ipopt", program, options)

    @property
    def name(self) -> str:
        """Stable name."""
        return "casadi_ipopt"

    @property
    def title(self) -> str:
        """What it is."""
        return f"{titled('casadi')} with IPOPT, polar form"

    @property
    def remark(self) -> str:
        """What it does differently."""
        return "its limits are arcs where ours are chords within them, so that its force may be the larger one"

    def prepare(self, step: Step) -> Any:
        """Return bounds (4.12)-(4.13), parameter and start."""
        vessel = self._vessel
        slack = np.full(3, np.inf)
        change = vessel.thrust_rate * step.dt
        least = np.where(self._turning, 0.0, vessel.thrust_min)
        low = np.minimum(np.maximum(least, step.thrust_before - change), step.thrust_before + change)
        high = np.maximum(np.minimum(vessel.thrust_max, step.thrust_before + change), low)
        turn = np.where(self._turning, vessel.azimuth_rate * step.dt, 0.0)
        force = np.zeros(3)
        return {
            "x0": np.concatenate([step.thrust_before, step.azimuth_before, force]),
            "p": step.tau,
            "lbx": np.concatenate([low, step.azimuth_before - turn, -slack]),
            "ubx": np.concatenate([high, step.azimuth_before + turn, slack]),
            "lbg": force,
            "ubg": force,
        }

    def solve(self, task: Any) -> Any:
        """Solve."""
        return self._solve(**task)

    def commands(self, step: Step, answer: Any) -> Commands | None:
        """Return the commands of an answer that was found."""
        if not self._solve.stats()["success"]:
            return None
        x = np.asarray(answer["x"]).ravel()
        return x[: self._n], np.array([wrap_angle(angle) for angle in x[self._n : 2 * self._n].tolist()])
