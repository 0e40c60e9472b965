"""Mirroring port and starboard, and scaling all forces, change the answer in the same way as the question."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from marine_model import Vessel, load_vessel
from marine_model.frames import wrap_angles
from thrust_allocator import Allocator, AllocatorSettings

VESSEL = load_vessel("cybership3")
DT = 0.2
MODES = ["fixed", "rotating"]


def mirrored(vessel: Vessel) -> Vessel:
    document: dict[str, Any] = vessel.model_dump()
    for thruster in document["thrusters"]:
        x, y, z = thruster["position"]
        thruster["position"] = (x, -y, z)
        if thruster["type"] == "tunnel":
            thruster["direction"] *= -1.0
        else:
            thruster["azimuth"]["fixed"] *= -1.0
    return Vessel.model_validate(document)


def stronger(vessel: Vessel, factor: float) -> Vessel:
    document: dict[str, Any] = vessel.model_dump()
    for thruster in document["thrusters"]:
        for limit in ("min", "max", "rate"):
            thruster["thrust"][limit] *= factor
        thruster["shaft"]["torque_max"] *= max(factor, 1.0)  # the motor has to reach the largest thrust
    return Vessel.model_validate(document)


def demands(seed: int) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    return [tau for _ in range(40) for tau in [random.normal(size=3) * [6.0, 5.0, 3.0]] * 8]


@pytest.mark.parametrize("mode", MODES)
def test_port_and_starboard_mirror(mode: str) -> None:
    settings = AllocatorSettings(azimuth_mode=mode)
    one, other = Allocator(VESSEL, settings), Allocator(mirrored(VESSEL), settings)
    for tau in demands(1):
        here, there = one.step(tau, DT), other.step(tau * [1.0, -1.0, -1.0], DT)
        # Rounding of weights of 1e8 on forces of 10 N.
        np.testing.assert_allclose(there.thrust, here.thrust, atol=1e-7)
        np.testing.assert_allclose(wrap_angles(there.azimuth + here.azimuth), 0.0, atol=1e-6)
        np.testing.assert_allclose(there.tau_achieved * [1.0, -1.0, -1.0], here.tau_achieved, atol=1e-7)
        # Each from the same point, so that rounding does not grow over the steps.
        other.reset(here.thrust, -here.azimuth)
        assert there.thrust_saturated == here.thrust_saturated


@pytest.mark.parametrize("factor", [1e-3, 7.0, 1e4])
@pytest.mark.parametrize("mode", MODES)
def test_all_forces_scale_together(mode: str, factor: float) -> None:
    settings = AllocatorSettings(azimuth_mode=mode)
    one, other = Allocator(VESSEL, settings), Allocator(stronger(VESSEL, factor), settings)
    for tau in demands(2):
        here, there = one.step(tau, DT), other.step(tau * factor, DT)
        np.testing.assert_allclose(there.thrust, factor * here.thrust, atol=1e-7 * factor)
        np.testing.assert_allclose(wrap_angles(there.azimuth - here.azimuth), 0.0, atol=1e-6)
        assert there.cost == pytest.approx(factor**2 * here.cost, rel=1e-6, abs=1e-9 * factor**2)
        other.reset(factor * here.thrust, here.azimuth)


@pytest.mark.parametrize("mode", MODES)
def test_both_geometries_of_the_vessel(mode: str) -> None:
    vessel = load_vessel("cybership3_ch7")
    allocator = Allocator(vessel, AllocatorSettings(azimuth_mode=mode))
    for _ in range(40):
        result = allocator.step([1.0, 0.8, 0.3], DT)
    np.testing.assert_allclose(result.tau_achieved, [1.0, 0.8, 0.3], atol=1e-3)


def test_over_demand_is_the_limit_of_large_demands() -> None:
    """Beyond what the solver is asked directly, the answer goes on as it was."""
    direction = np.array([0.6, 0.5, 0.3])
    answers = []
    for size in (1e4, 1e5, 1e9, 1e200):
        allocator = Allocator(VESSEL, AllocatorSettings(azimuth_mode="rotating"))
        for _ in range(30):
            result = allocator.step(size * direction, DT)
        assert result.status == "optimal"
        assert math.isfinite(result.slack[0])
        answers.append(result.thrust)
    for answer in answers[1:]:
        np.testing.assert_allclose(answer, answers[0], atol=1e-2)
