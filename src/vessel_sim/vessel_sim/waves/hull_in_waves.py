"""What waves do to a hull: a table of its response to wave components."""

from __future__ import annotations

from abc import ABC, abstractmethod

from marine_model.guards import FloatArray
from vessel_sim.waves.components import OMEGA
from vessel_sim.waves.response_table import response_table


class HullInWaves(ABC):
    """First-order motion and mean drift of a hull by frequency and relative direction."""

    length: float
    """Of the hull, m."""

    @abstractmethod
    def responses(self, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return relative directions from 0 to pi, shape (nb,), and the functions there.

        Parameters
        ----------
        omega
            Wave frequencies seen from a fixed point, rad/s, shape (m,).

        Returns
        -------
        Directions, rad, and values, shape (m, nb, ``response_table.FUNCTIONS``), units there.
        """

    def table(self, components: FloatArray) -> FloatArray:
        """Return the response to ``components``, shape (m, NODES, 2 FUNCTIONS); see ``response_table``."""
        return response_table(*self.responses(components[:, OMEGA]))
