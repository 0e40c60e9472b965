"""What is told of an answer beside the answer: minimum gains, and how much more of the demand could be had."""

from __future__ import annotations

import numpy as np

from marine_model import Vessel
from marine_model.guards import FloatArray
from thrust_allocator.attainable import Margin, ThrustMargin
from thrust_allocator.plan.phase import LOST, ROTATING, Limit
from thrust_allocator.plan.polar import Command
from thrust_allocator.settings import AllocatorSettings
from thrust_allocator.singularity import (
    MinimumGain,
    MonitorReading,
    Watch,
    minimum_gain,
    monitor,
    scaled_configuration,
    scaling_of,
)

_WATCH = {
    "none": Watch(0),
    "global": Watch.GLOBAL,
    "local": Watch.LOCAL,
    "horizon": Watch.HORIZON,
    "all": Watch.ALL,
}


class Monitoring:
    """Monitor of one vessel under one set of settings; made anew when they change.

    Parameters
    ----------
    vessel
        The vessel.
    settings
        Failures, limits, and what to watch.
    limits
        Table of limits of these settings, shape (n, 14).
    """

    def __init__(self, vessel: Vessel, settings: AllocatorSettings, limits: FloatArray) -> None:
        enabled: list[bool] = (limits[:, Limit.ENABLED] != 0.0).tolist()
        self._scaling = scaling_of(vessel)
        self._margin = ThrustMargin(
            vessel,
            enabled=enabled,
            thrust_limit_scale=settings.thrust_limit_scale or None,
            can_rotate=(limits[:, Limit.MAY_ROTATE] != 0.0).tolist(),
        )
        chosen = settings.singularity
        self._watch, self._horizon = _WATCH[chosen.monitor], chosen.horizon
        self._change = chosen.required_change * np.maximum(vessel.thrust_max, -vessel.thrust_min)

    def margin(self, commands: FloatArray, tau: FloatArray) -> Margin:
        """Return how many times ``tau`` (3,) is attainable: at the angles of ``commands`` (n, 5), and once turned."""
        return self._margin(np.ascontiguousarray(commands[:, Command.AZIMUTH]), tau)

    def both_ways(self, commands: FloatArray) -> MinimumGain:
        """Return the minimum gain at the angles of ``commands`` if every thruster that is not lost could reverse."""
        azimuth = np.ascontiguousarray(commands[:, Command.AZIMUTH])
        return minimum_gain(scaled_configuration(self._scaling, azimuth, commands[:, Command.PHASE] != LOST))

    def read(self, commands: FloatArray, limits: FloatArray) -> MonitorReading:
        """Return the minimum gains that the settings ask for; NaN for the others.

        Parameters
        ----------
        commands
            Table of commands, shape (n, 5).
        limits
            Table of limits of that step, shape (n, 14).
        """
        phase = commands[:, Command.PHASE]
        return monitor(
            self._scaling,
            commands[:, Command.THRUST],
            commands[:, Command.AZIMUTH],
            phase != LOST,
            limits[:, Limit.THRUST_MIN],
            limits[:, Limit.THRUST_MAX] * limits[:, Limit.FACTOR],
            phase == ROTATING,
            limits[:, Limit.AZIMUTH_RATE],
            self._horizon,
            -self._change,
            self._change,
            np.clip(limits[:, Limit.REACH_LOW], -np.pi, 0.0),
            np.clip(limits[:, Limit.REACH_HIGH], 0.0, np.pi),
            watch=self._watch,
        )
