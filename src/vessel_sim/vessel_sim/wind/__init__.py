"""Wind on the hull: mean wind by height, gusts, slow turns, and the anemometer."""

from vessel_sim.wind.wind import Wind

__all__ = ["Wind"]
