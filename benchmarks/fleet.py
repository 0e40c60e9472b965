"""Vessels with more thrusters, made from one that exists."""

from __future__ import annotations

import math

from marine_model import Vessel
from marine_model.frames import wrap_angle
from marine_model.thruster import AzimuthThruster


def with_thrusters(vessel: Vessel, count: int) -> Vessel:
    """Return ``vessel`` with ``count`` thrusters: its own over and over, elsewhere, as strong together.

    Parameters
    ----------
    vessel
        Where thrusters and weights come from.
    count
        A multiple of its number of thrusters.

    Raises
    ------
    ValueError
        If it is not one.
    """
    own = len(vessel.thrusters)
    if count < own or count % own:
        raise ValueError(f"count: expected a multiple of {own}, found {count}")
    share = own / count
    thrusters = []
    for i in range(count):
        original = vessel.thrusters[i % own]
        thrust = original.thrust
        thrusters.append(
            original.model_copy(
                update={
                    "name": original.name if i < own else f"{original.name}_{i // own + 1}",
                    "position": _moved(vessel, original.position, i, own),
                    "thrust": thrust.model_copy(
                        update={"min": share * thrust.min, "max": share * thrust.max, "rate": share * thrust.rate}
                    ),
                }
            )
        )
    gains = vessel.allocator
    weights = tuple(gains.thrust_weight[i % own] for i in range(count))
    # The allocator is what is measured: no detection, whose least shaft speeds belong to the thrusters there are.
    drivers = vessel.drivers.model_copy(update={"ventilation": None})
    # Through the schema once more, which also checks the result.
    document = vessel.model_dump() | {
        "name": f"{vessel.name}_{count}",
        "thrusters": tuple(thruster.model_dump() for thruster in thrusters),
        "allocator": gains.model_copy(update={"thrust_weight": weights}).model_dump(),
        "drivers": drivers.model_dump(),
    }
    return Vessel.model_validate(document)


def _moved(vessel: Vessel, position: tuple[float, float, float], i: int, own: int) -> tuple[float, float, float]:
    """Return a position of its own within the hull, for all but the first ``own`` thrusters."""
    if i < own:
        return position
    # Multiples of the golden section never fall together.
    along = math.modf(i * (math.sqrt(5.0) - 1.0) / 2.0)[0] - 0.5
    across = math.modf(i * (math.sqrt(2.0) - 1.0))[0] - 0.5
    return (0.9 * vessel.hull.length * along, 0.9 * vessel.hull.beam * across, position[2])


def with_windows(vessel: Vessel, count: int) -> Vessel:
    """Return ``vessel`` with ``count`` windows of directions for every azimuth thruster, one about its fixed direction.

    Between them lie forbidden sectors of 20 deg; a single window is 160 deg wide, so that it is convex.
    """
    half = 0.5 * (min(2.0 * math.pi / count, math.pi) - math.radians(20.0))
    thrusters = []
    for thruster in vessel.thrusters:
        document = thruster.model_dump()
        if isinstance(thruster, AzimuthThruster):
            centres = [thruster.fixed_direction + 2.0 * math.pi * i / count for i in range(count)]
            document["azimuth"]["sectors"] = tuple(
                {"start": wrap_angle(here + half), "end": wrap_angle(there - half), "kind": "forbidden"}
                for here, there in zip(centres, centres[1:] + centres[:1], strict=True)
            )
        thrusters.append(document)
    return Vessel.model_validate(vessel.model_dump() | {"thrusters": tuple(thrusters)})
