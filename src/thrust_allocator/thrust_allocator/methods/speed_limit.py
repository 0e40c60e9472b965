"""Largest thrust of the marching thrusters at a speed: T_max of [Kostenko] Table 4."""

from __future__ import annotations

from collections.abc import Callable

from marine_model import Vessel

# Largest thrust (N) of a marching thruster at a speed (m/s).
SpeedLimit = Callable[[float], float]


def speed_limit_of(vessel: Vessel, marching: tuple[int, ...]) -> SpeedLimit | None:
    """Return the least T_max of the thrusters ``marching`` over the speed ahead; None if one has no drive with maps.

    A speed outside the tables counts as the nearest inside: that of a vehicle that goes astern as rest.
    """
    maps = []
    for j in marching:
        thruster = vessel.thrusters[j]
        if thruster.drive is None:
            return None
        maps.append(thruster.drive.build(vessel.propeller_models[j], vessel.density).code_from_thrust)
    return lambda speed: min(m.thrust_max(m.speeds.clamp(speed)) for m in maps)
