"""Vessels with more thrusters, made from one that exists."""

from __future__ import annotations

import math

from marine_model import Vessel


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
    # Through the schema once more, which also checks the result.
    document = vessel.model_dump() | {
        "name": f"{vessel.name}_{count}",
        "thrusters": tuple(thruster.model_dump() for thruster in thrusters),
        "allocator": gains.model_copy(update={"thrust_weight": weights}).model_dump(),
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
