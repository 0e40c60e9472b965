"""What is told of an answer beside the answer: minimum gains, and how much more of the demand could be had."""

from __future__ import annotations

import numpy as np

from marine_model import Vessel
from marine_model.axes import HORIZONTAL, in_six
from marine_model.guards import FloatArray
from thrust_allocator.attainable import AxesMargin, Margin, ThrustMargin
from thrust_allocator.feasible.directions import along_direction
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

    Gains are those of surge, sway and yaw, and NaN for a vessel that controls other axes.

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
        self._has_gains = vessel.degrees_of_freedom == HORIZONTAL
        self._dof, self._own = vessel.degrees_of_freedom, vessel.axis_indices
        self._columns, self._axes = vessel.columns6, len(vessel.degrees_of_freedom)
        self._margin = (ThrustMargin if self._has_gains else AxesMargin)(
            vessel,
            enabled=enabled,
            thrust_limit_scale=settings.thrust_limit_scale or None,
            can_rotate=(limits[:, Limit.MAY_ROTATE] != 0.0).tolist(),
        )
        chosen = settings.singularity
        self._watch, self._horizon = _WATCH[chosen.monitor], chosen.horizon
        self._change = chosen.required_change * np.maximum(vessel.thrust_max, -vessel.thrust_min)

    def margin(self, commands: FloatArray, tau: FloatArray) -> Margin:
        """Return how many times ``tau`` (m,) is attainable: at the angles of ``commands`` (n, 5), and once turned."""
        return self._margin(np.ascontiguousarray(commands[:, Command.AZIMUTH]), tau)

    def wrench(self, commands: FloatArray, tau: FloatArray) -> FloatArray:
        """Return the generalized force of ``commands`` (n, 5) in all six degrees of freedom, shape (6,), N and N m.

        ``tau`` (m,) is that over the degrees of freedom of the vessel. A vessel on the surface has nothing else.
        """
        if self._has_gains:
            return in_six(self._dof, tau)
        azimuth = commands[:, Command.AZIMUTH]
        thrust = np.where(commands[:, Command.PHASE] != LOST, commands[:, Command.THRUST], 0.0)
        wrench: FloatArray = thrust @ along_direction(self._columns, azimuth)
        # To the last bit what was summed by axis.
        wrench[self._own] = tau
        return wrench

    def both_ways(self, commands: FloatArray) -> MinimumGain:
        """Return the minimum gain at the angles of ``commands`` if every thruster that is not lost could reverse."""
        if not self._has_gains:
            return MinimumGain(np.nan, np.full(self._axes, np.nan))
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
        if not self._has_gains:
            return MonitorReading.unknown(self._axes)
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
