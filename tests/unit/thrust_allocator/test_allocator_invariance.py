"""What may not change an answer does not; and the cost true to power falls to its optimum while a demand stands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from marine_model import Vessel, load_vessel
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray
from marine_model.thruster_configuration import polar_configuration
from thrust_allocator import Allocator, AllocatorSettings, Status
from thrust_allocator.cost import regularised_cost, thrust_floor
from thrust_allocator.settings import PowerSettings, SectorSettings

VESSEL = load_vessel("cybership3")
DT = 0.2
GAINS = VESSEL.allocator
SLACK = (GAINS.slack_gain * np.array(GAINS.slack_weight)) ** 2
FLOOR = thrust_floor(VESSEL.thrust_min, VESSEL.thrust_max)
WEIGHT = np.array(GAINS.thrust_weight) ** 2


def cost_of(thrust: FloatArray, azimuth: FloatArray, tau: FloatArray) -> float:
    """F of cost.py."""
    slack = tau - polar_configuration(VESSEL.lever_x, VESSEL.lever_y, azimuth) @ thrust
    return float(SLACK @ slack**2) + regularised_cost(WEIGHT, np.ones(4), thrust, FLOOR)


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
def test_cost_true_to_power_never_rises(mode: str) -> None:
    random = np.random.default_rng(31)
    samples = []
    for _ in range(20):
        tau = random.normal(size=3) * [2.0, 1.5, 1.0]
        allocator = Allocator(VESSEL, AllocatorSettings(azimuth_mode=mode, cost="power_3_2"))
        costs = [cost_of(np.zeros(4), VESSEL.fixed_direction, tau)]
        for _ in range(80):
            result = allocator.step(tau, DT)
            costs.append(cost_of(result.thrust, result.azimuth, tau))
        if mode == "fixed":
            # Rounding of multipliers of some 1e6 times thrusts of 10 N.
            assert max(np.diff(costs)) <= 1e-9 * costs[0]
        else:
            # A rotating command is the answer brought into its cone; beyond it lies c_2 of the span at most, some
            # 0.02 N, and a slack of that costs its square times the weight. Where it does not, F falls.
            assert max(np.diff(costs[-20:])) <= 1e-6 * costs[-1]
        samples.append(next(k for k, cost in enumerate(costs) if cost <= 1.01 * costs[-1]))
    # 9.4 steps to 1 % (cost.py), and as many as the thrust rates take; rotating ones turn half a circle in 15 as well.
    assert np.median(samples) <= (12 if mode == "fixed" else 30)


def test_cost_true_to_power_converges_to_the_optimum() -> None:
    random = np.random.default_rng(32)
    azimuth = VESSEL.fixed_direction
    B = polar_configuration(VESSEL.lever_x, VESSEL.lever_y, azimuth)
    for _ in range(15):
        tau = random.normal(size=3) * [3.0, 2.0, 1.5]
        allocator = Allocator(VESSEL, AllocatorSettings(cost="power_3_2"))
        for _ in range(120):
            result = allocator.step(tau, DT)
        found = cost_of(result.thrust, azimuth, tau)

        def gradient(thrust: FloatArray, azimuth: FloatArray = azimuth, tau: FloatArray = tau) -> FloatArray:
            slope = 2.0 * WEIGHT * thrust * (thrust**2 + FLOOR**2) ** -0.25
            return slope - 2.0 * B.T @ (SLACK * (tau - B @ thrust))

        # From the answer and from elsewhere; F is strictly convex, so that neither can find less.
        for start in (result.thrust, np.zeros(4)):
            best = minimize(
                cost_of, start, args=(azimuth, tau), jac=gradient, method="L-BFGS-B",
                bounds=list(zip(VESSEL.thrust_min, VESSEL.thrust_max, strict=True)),
                options={"maxiter": 5000, "ftol": 1e-16, "gtol": 1e-10},
            )  # fmt: skip
            assert found <= best.fun * (1.0 + 1e-8)
        # And the conditions of first order hold, relative to the pull of the slack.
        slope = gradient(result.thrust)
        inside = (result.thrust > VESSEL.thrust_min + 1e-9) & (result.thrust < VESSEL.thrust_max - 1e-9)
        assert np.abs(slope[inside]).max(initial=0.0) <= 1e-6 * float(np.abs(B.T @ (SLACK * tau)).max())


def mirrored(vessel: Vessel) -> Vessel:
    document: dict[str, Any] = vessel.model_dump()
    for thruster in document["thrusters"]:
        x, y, z = thruster["position"]
        thruster["position"] = (x, -y, z)
        if thruster["type"] == "tunnel":
            thruster["direction"] *= -1.0
            continue
        thruster["azimuth"]["fixed"] *= -1.0
        for sector in thruster["azimuth"]["sectors"]:
            sector["start"], sector["end"] = -sector["end"], -sector["start"]
    return Vessel.model_validate(document)


def permuted(vessel: Vessel, order: list[int]) -> Vessel:
    document: dict[str, Any] = vessel.model_dump()
    document["thrusters"] = [document["thrusters"][j] for j in order]
    document["allocator"]["thrust_weight"] = [document["allocator"]["thrust_weight"][j] for j in order]
    return Vessel.model_validate(document)


def demands(seed: int) -> list[FloatArray]:
    random = np.random.default_rng(seed)
    return [tau for _ in range(30) for tau in [random.normal(size=3) * [6.0, 5.0, 3.0]] * 8]


EVERYTHING = [
    {"sectors": True},
    {"sectors": True, "cost": "power_3_2", "thrust_weight": "propeller"},
    {"over_demand": "proportional"},
    {"power": "both"},
    {"sectors": True, "power": "total"},
]


def chosen(vessel: Vessel, options: dict[str, Any]) -> AllocatorSettings:
    options = dict(options)
    # A dwell time that is never over on a sample, where rounding would decide.
    sectors = SectorSettings(enabled=options.pop("sectors", False), dwell_time=2.9)
    power = PowerSettings(limit=options.pop("power", "none"), available=2.0, bus_limit=(1.0, 0.8))
    return AllocatorSettings.for_vessel(vessel, azimuth_mode="rotating", sectors=sectors, power=power, **options)


@pytest.mark.parametrize("options", EVERYTHING, ids=str)
def test_mirror_of_the_whole_allocator(options: dict[str, Any]) -> None:
    other_vessel = mirrored(VESSEL)
    one, other = Allocator(VESSEL, chosen(VESSEL, options)), Allocator(other_vessel, chosen(other_vessel, options))
    # The search under a limit of total power ends with any answer that uses 99.5 % of it, and rounding decides on
    # which: 0.3 % of 13.5 N.
    tolerance = 0.05 if options.get("power") == "total" else 1e-5
    for tau in demands(33):
        here, there = one.step(tau, DT), other.step(tau * [1.0, -1.0, -1.0], DT)
        # Each goes on from its own answer: nothing here makes rounding grow.
        np.testing.assert_allclose(there.thrust, here.thrust, atol=tolerance)
        np.testing.assert_allclose(wrap_angles(there.azimuth + here.azimuth), 0.0, atol=tolerance)
        if here.sectors is not None and there.sectors is not None:
            assert there.sectors.cost == pytest.approx(here.sectors.cost, rel=1e-9, abs=1e-9)
            assert there.sectors.crossing == here.sectors.crossing


@pytest.mark.parametrize("options", EVERYTHING, ids=str)
def test_order_of_thrusters_does_not_matter(options: dict[str, Any]) -> None:
    order = [2, 0, 3, 1]
    other_vessel = permuted(VESSEL, order)
    one, other = Allocator(VESSEL, chosen(VESSEL, options)), Allocator(other_vessel, chosen(other_vessel, options))
    for tau in demands(34):
        here, there = one.step(tau, DT), other.step(tau, DT)
        np.testing.assert_allclose(there.thrust, here.thrust[order], atol=1e-5)
        np.testing.assert_allclose(wrap_angles(there.azimuth - here.azimuth[order]), 0.0, atol=1e-5)


@pytest.mark.parametrize("factor", [1e-3, 1e4])
@pytest.mark.parametrize("options", [EVERYTHING[0], EVERYTHING[2]], ids=str)
def test_forces_scale_together(options: dict[str, Any], factor: float) -> None:
    document: dict[str, Any] = VESSEL.model_dump()
    for thruster in document["thrusters"]:
        for limit in ("min", "max", "rate"):
            thruster["thrust"][limit] *= factor
        thruster["shaft"]["torque_max"] *= max(factor, 1.0)  # the motor has to reach the largest thrust
    other_vessel = Vessel.model_validate(document)
    one, other = Allocator(VESSEL, chosen(VESSEL, options)), Allocator(other_vessel, chosen(other_vessel, options))
    for tau in demands(35):
        here, there = one.step(tau, DT), other.step(factor * tau, DT)
        assert there.status is Status.OPTIMAL
        np.testing.assert_allclose(there.thrust, factor * here.thrust, atol=1e-5 * factor)
        np.testing.assert_allclose(wrap_angles(there.azimuth - here.azimuth), 0.0, atol=1e-5)
