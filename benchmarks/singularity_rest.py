"""`python -m benchmarks.singularity_rest`: how far from the best configuration required_gain comes to rest.

Random demands stand for 60 s; brute force tries all azimuths of CyberShip III in steps of 7.5 deg over whole turns.
"""

from __future__ import annotations

import math
import sys

import numpy as np

from marine_model import load_vessel
from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thrust_allocator.engine import Answer, Engine
from thrust_allocator.plan.limits import limit_table
from thrust_allocator.settings import AllocatorSettings
from thrust_allocator.singularity.avoidance import Avoidance
from thrust_allocator.singularity.avoidance_thrusters import Thrusters, gain_at, static_cost
from thrust_allocator.singularity.scaling import scaling_of
from thrust_allocator.singularity.settings import SingularitySettings

_POINTS = 48
_DEMANDS = 24
_STEPS = 300
_DT = 0.2


@compiled
def _brute_force(thrusters: Thrusters, azimuth: FloatArray, tau: FloatArray, threshold: float) -> float:
    best = math.inf
    at, unused, multiplier, thrust = azimuth.copy(), np.empty(3), np.zeros(3), np.empty(4)
    for node in range(_POINTS**3):
        for j in range(3):
            at[j + 1] = 2.0 * math.pi * (node // _POINTS**j % _POINTS) / _POINTS
        if gain_at(thrusters, at, unused) >= threshold:
            multiplier[:] = 0.0
            best = min(best, static_cost(thrusters, at, tau, multiplier, thrust))
    return best


def main() -> int:
    """Print cost over brute force for every demand."""
    vessel = load_vessel("cybership3")
    engine, scaling = Engine(vessel), scaling_of(vessel)
    limits = limit_table(vessel, AllocatorSettings(azimuth_mode="rotating"))
    scale = np.array([1.0, 1.0, scaling.moment_scale]) / scaling.mean_thrust_max
    thrusters = Thrusters(
        engine.columns,
        engine.columns * scale[:, None] * vessel.thrust_max[:, None, None],
        engine.weights.thrust,
        1.0 / engine.weights.slack,
        vessel.thrust_min.copy(),
        vessel.thrust_max.copy(),
        np.arange(4),
        np.arange(1, 4),
    )

    def run(table: FloatArray, before: FloatArray, multiplier: FloatArray, demand: FloatArray) -> Answer:
        return engine.run(table, before, multiplier, engine.weights.thrust, demand, _DT)

    ratios = []
    generator = np.random.default_rng(1)
    for _ in range(_DEMANDS):
        tau = generator.normal(size=3) * np.array([6.0, 4.0, 2.0])
        avoidance = Avoidance(vessel, engine, SingularitySettings(method="required_gain"))
        before = np.zeros((4, 5))
        before[:, 1] = vessel.fixed_direction
        for _ in range(_STEPS):
            answer, report = avoidance.step(run, limits, before, tau, _DT)
            before = answer.commands
        best = _brute_force(thrusters, before[:, 1].copy(), tau, report.threshold)
        ratios.append(report.cost_kept / best)
        print(np.round(tau, 2), f"cost {report.cost_kept:.3f}, brute force {best:.3f}, ratio {ratios[-1]:.4f}")
    print(f"median {np.median(ratios):.4f}, largest {np.sort(ratios)[-3:]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
