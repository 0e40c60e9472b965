"""method = garus_azimuth: four azimuth propellers that turn together, [Garus-A]."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.thruster import AzimuthThruster
from thrust_allocator.feasible.garus_azimuth import (
    AngleChoice,
    AzimuthSquare,
    check_moment,
    check_range,
    fold,
    force_limit,
    next_angle,
    reserved_thrust,
)
from thrust_allocator.feasible.octahedron import axis_loads
from thrust_allocator.feasible.pseudo_inverse import share_within
from thrust_allocator.methods.configuration import Configuration
from thrust_allocator.methods.method import Method, Wanted, both_ways, thrust_range
from thrust_allocator.methods.settings import AzimuthAngleSettings
from thrust_allocator.plan.phase import Limit, Plan

# Turns below this are rounding of sines and cosines, rad: the propellers stay.
_STAYS = 1e-9


class GarusAzimuthMethod(Method):
    """Angle and permissible forces by [Garus-A], thrusts by the pseudo-inverse at the angles really there.

    The propellers take their time to turn. Until they are there, surge and sway are given in the largest share that
    keeps all thrusts within limits beside yaw and the other axes, so that yaw is what was asked for at any angle: that
    is what the reserved moment is for.

    Parameters
    ----------
    vessel
        Geometry and limits.
    settings
        Reserved moment, range of the angle, rule.

    Raises
    ------
    InputError
        If the vessel does not have four such propellers, does not control surge, sway and yaw, or the settings do not
        fit it.
    """

    def __init__(self, vessel: Vessel, settings: AzimuthAngleSettings) -> None:
        axes = vessel.degrees_of_freedom
        missing = [axis for axis in ("surge", "sway", "yaw") if axis not in axes]
        if missing:
            raise InputError(
                f"garus_azimuth: expected a vessel that controls surge, sway and yaw, found no {missing[0]}"
            )
        self._axes = axes
        self._square = square = azimuth_square(vessel)
        check_range(settings.angle_min)
        check_moment(square, settings.reserved_moment, settings.angle_min)
        self._settings = settings
        self._own = np.array(square.thrusters)
        self._surge, self._sway, self._yaw = (axes.index(axis) for axis in ("surge", "sway", "yaw"))
        self._others = [i for i, axis in enumerate(axes) if axis not in ("surge", "sway", "yaw")]
        self._configuration = Configuration(vessel)
        self._choice = AngleChoice(0.0, 0.0, 0.0, 0.0)

    def aim(self, limits: FloatArray, azimuth: FloatArray, tau: FloatArray) -> None:
        """Choose the thrust angle, and send the propellers there."""
        own, settings = self._own, self._settings
        strength = both_ways(limits)[own]
        sound = strength > 0.0
        square = replace(self._square, thrust_max=float(strength[sound].min()) if sound.any() else 0.0)
        turning = own[sound & (limits[own, Limit.MAY_ROTATE] != 0.0)]
        present = float(np.mean([fold(angle) for angle in azimuth[turning if len(turning) else own].tolist()]))
        reserved = reserved_thrust(square, settings.reserved_moment, settings.angle_min)
        self._choice = next_angle(
            float(tau[self._surge]),
            float(tau[self._sway]),
            present,
            force_limit(square, reserved, settings.angle_min),
            4.0 * (square.thrust_max - reserved),
            settings.angle_min,
            as_printed=settings.angle_rule == "as_printed",
        )
        for j, direction in zip(own.tolist(), square.directions(self._choice.angle).tolist(), strict=True):
            near = abs(wrap_angle(direction - float(azimuth[j]))) <= _STAYS
            limits[j, Limit.DIRECTION] = azimuth[j] if near else wrap_angle(direction)

    def want(self, plans: FloatArray, limits: FloatArray, tau: FloatArray) -> Wanted:
        """Divide what is permissible among the propellers as they point."""
        lower, upper = thrust_range(limits)
        configuration, choice, moment = self._configuration, self._choice, self._settings.reserved_moment
        configuration.point(plans[:, Plan.AZIMUTH].copy(), upper > lower, both_ways(limits))
        feasible, others = tau.copy(), self._others
        feasible[self._surge], feasible[self._sway] = choice.surge, choice.sway
        yaw = float(tau[self._yaw])
        feasible[self._yaw] = min(max(yaw, -moment), moment)
        feasible[others] = np.clip(tau[others], -configuration.limits[others], configuration.limits[others])
        yaw_load = 0.0 if yaw == 0.0 else (abs(yaw) / moment if moment > 0.0 else inf)
        loads = axis_loads(tau[others], configuration.limits[others])
        reasons = []
        if choice.load > 1.0:
            reasons.append(f"surge and sway are {choice.load:.3g} times the asteroid")
        if yaw_load > 1.0:
            reasons.append(f"yaw of {yaw:.4g} N m is beyond the reserved {moment:.4g} N m")
        reasons += [
            f"{self._axes[i]} is beyond its limit" for i, load in zip(others, loads.tolist(), strict=True) if load > 1.0
        ]
        first = feasible.copy()
        first[[self._surge, self._sway]] = 0.0
        base = np.clip(configuration.inverse @ first, lower, upper)
        rest = configuration.inverse @ (feasible - first)
        share = share_within(base, rest, lower, upper)
        if share < 1.0:
            reasons.append(f"{share:.3g} of surge and sway at the present angles")
        thrust = np.clip(base + share * rest, lower, upper)
        return Wanted(thrust, feasible, max(choice.load, yaw_load, *loads.tolist(), 0.0), "; ".join(reasons))


def azimuth_square(vessel: Vessel) -> AzimuthSquare:
    """Return the four azimuth propellers of a vessel.

    Raises
    ------
    InputError
        If it has no such four.
    """
    own = [j for j, thruster in enumerate(vessel.thrusters) if isinstance(thruster, AzimuthThruster)]
    strength = np.minimum(vessel.thrust_max, -vessel.thrust_min)[own]
    if (strength <= 0.0).any():
        raise InputError("garus_azimuth: expected propellers that reverse, found one with thrust.min 0")
    return AzimuthSquare.of(tuple(own), vessel.lever_x[own], vessel.lever_y[own], strength)
