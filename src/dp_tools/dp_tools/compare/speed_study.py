"""A drive that is asked for codes: achieved against demanded thrust over the speed, [Kostenko] (4), (7), (8)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from marine_model import Vessel
from marine_model.code_maps import CodeDrive
from marine_model.errors import InputError
from marine_model.guards import FloatArray
from marine_model.propellers import PropellerModel

# By (4), or where torque of the motor and of the propeller meet, (3), which is what the simulator sails with.
Truth = Literal["map", "equilibrium"]
TRUTHS: tuple[Truth, ...] = ("map", "equilibrium")
_SPEED_STEPS = 8  # between two tabulated speeds
_THRUST_STEPS = 100
_PARTS = (0.25, 0.5, 1.0)  # of T_max at the largest speed: demands that can be met at any speed


@dataclass(frozen=True)
class SpeedRow:
    """One tabulated speed.

    Attributes
    ----------
    speed
        m/s.
    thrust_max
        T_max of Table 4, N.
    at_code_max
        Thrust of the largest code by either truth, N.
    error, rms
        Largest and mean square error with compensation, N, by either truth, demands from the dead zone to T_max.
    shortfall
        Demand less what is achieved without compensation, N, by either truth, for the largest of the demands.
    """

    speed: float
    thrust_max: float
    at_code_max: tuple[float, float]
    error: tuple[float, float]
    rms: tuple[float, float]
    shortfall: tuple[float, float]


@dataclass(frozen=True, eq=False)
class SpeedStudy:
    """One drive with its propeller.

    Attributes
    ----------
    thruster, count
        Name of the first thruster that has it, and how many have it.
    demands
        N, shape (d,).
    speeds
        m/s, shape (s,).
    over_speed
        Achieved thrust, N, shape (s, d), by (truth, whether compensated).
    thrust_max
        T_max at every speed, shape (s,).
    top_demands
        N, shape (t,).
    at_top
        Achieved thrust at the largest speed, shape (t,), by the same.
    rows
        Tabulated speeds.
    """

    thruster: str
    count: int
    demands: FloatArray
    speeds: FloatArray
    over_speed: dict[tuple[Truth, bool], FloatArray]
    thrust_max: FloatArray
    top_demands: FloatArray
    at_top: dict[tuple[Truth, bool], FloatArray]
    rows: tuple[SpeedRow, ...]


class DriveInWater:
    """A drive with its propeller: what thrust a code gives.

    Parameters
    ----------
    drive, propeller, density
        The drive, what it turns, and kg/m^3.
    """

    def __init__(self, drive: CodeDrive, propeller: PropellerModel, density: float) -> None:
        self.drive, self._propeller, self._density = drive, propeller, density
        self._known: dict[tuple[int, float], float] = {}

    def code(self, demand: float, speed: float, compensated: bool) -> int:
        """Return the code for a thrust (N) at a speed (m/s): by (8), or by (7) as at rest."""
        return self.drive.code(demand, speed if compensated else None)

    def thrust(self, code: int, speed: float, truth: Truth) -> float:
        """Return the thrust (N) of ``code`` at ``speed`` (m/s)."""
        if truth == "map":
            return self.drive.thrust_from_code.thrust(code, speed)
        if (code, speed) not in self._known:
            self._known[code, speed] = self._in_equilibrium(code, speed)
        return self._known[code, speed]

    def achieved(self, demand: float, speed: float, truth: Truth, compensated: bool) -> float:
        """Return the thrust (N) that comes of a demanded one (N) at ``speed`` (m/s)."""
        return self.thrust(self.code(demand, speed, compensated), speed, truth)

    def _in_equilibrium(self, code: int, speed: float) -> float:
        def surplus(shaft_speed: float) -> float:
            return self.drive.torque(code, shaft_speed) - float(
                self._propeller.forces(shaft_speed, speed, self._density)[1]
            )

        # A code without torque at rest lets the propeller stand.
        if self.drive.rest_shaft_speed(code) == 0.0:
            return 0.0
        low, high = 1e-3, 2.0 * self.drive.rest_shaft_speed(code)
        while surplus(high) > 0.0:
            high *= 2.0
            if high > 1e6:
                raise InputError(f"torque of code {code}: expected one that the propeller meets, found none")
        shaft_speed = float(brentq(surplus, low, high, xtol=1e-10))
        return float(self._propeller.forces(shaft_speed, speed, self._density)[0])


def drives_of(vessel: Vessel) -> list[tuple[str, int, DriveInWater]]:
    """Return the different drives that take codes: name of the first thruster, how many have it, and the drive."""
    found: list[tuple[str, int, DriveInWater]] = []
    kinds: list[object] = []
    for thruster, model in zip(vessel.thrusters, vessel.propeller_models, strict=True):
        if thruster.drive is None:
            continue
        kind = (thruster.drive, thruster.propeller)
        if kind in kinds:
            at = kinds.index(kind)
            name, count, drive = found[at]
            found[at] = (name, count + 1, drive)
            continue
        kinds.append(kind)
        built = thruster.drive.build(model, vessel.density)
        found.append((thruster.name, 1, DriveInWater(built, model, vessel.density)))
    return found


def study_speed(thruster: str, count: int, of: DriveInWater) -> SpeedStudy:
    """Return the study of a drive; arguments as from :func:`drives_of`."""
    table = of.drive.speeds
    limits = of.drive.code_from_thrust
    speeds = np.unique(
        np.concatenate(
            [
                np.linspace(one, other, _SPEED_STEPS + 1)
                for one, other in zip(table.tabulated, table.tabulated[1:], strict=False)
            ]
        )
    )
    demands = np.array(_PARTS) * limits.thrust_max(table.largest)
    ways = [(truth, compensated) for truth in TRUTHS for compensated in (False, True)]
    top = np.linspace(0.0, limits.thrust_max(0.0), _THRUST_STEPS + 1)
    return SpeedStudy(
        thruster,
        count,
        demands,
        speeds,
        {
            way: np.array(
                [[of.achieved(demand, speed, *way) for demand in demands.tolist()] for speed in speeds.tolist()]
            )
            for way in ways
        },
        np.array([limits.thrust_max(speed) for speed in speeds.tolist()]),
        top,
        {way: np.array([of.achieved(demand, table.largest, *way) for demand in top.tolist()]) for way in ways},
        tuple(_row(of, speed, float(demands[-1])) for speed in table.tabulated),
    )


def _row(of: DriveInWater, speed: float, demand: float) -> SpeedRow:
    limits = of.drive.code_from_thrust
    largest = limits.thrust_max(speed)
    wanted = np.linspace(limits.dead_zone, largest, _THRUST_STEPS + 1)[1:]
    errors = [
        np.array([of.achieved(thrust, speed, truth, True) for thrust in wanted.tolist()]) - wanted for truth in TRUTHS
    ]
    return SpeedRow(
        speed,
        largest,
        _pair(of.thrust(of.drive.code_max, speed, truth) for truth in TRUTHS),
        _pair(float(np.abs(error).max()) for error in errors),
        _pair(float(np.sqrt(np.mean(error**2))) for error in errors),
        _pair(demand - of.achieved(demand, speed, truth, False) for truth in TRUTHS),
    )


def _pair(values: Iterable[float]) -> tuple[float, float]:
    by_map, by_equilibrium = values
    return by_map, by_equilibrium
