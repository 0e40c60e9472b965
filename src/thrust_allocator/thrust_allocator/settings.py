"""What an operator changes while the allocator runs."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field

from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.schema import Fraction
from marine_model.settings import Settings, setting
from thrust_allocator.active_set_solver import NAME
from thrust_allocator.solvers import check_solver


class AllocatorSettings(Settings):
    """Settings of :class:`~thrust_allocator.allocator.Allocator`.

    Fields over thrusters have one element a thruster, in the order of the vessel file; empty means the default for
    every thruster.
    """

    azimuth_mode: Literal["fixed", "rotating", "variable"] = setting(
        "fixed", "Azimuth thrusters are held in their fixed directions, or rotate freely (rotating, variable)"
    )
    solver: str = setting(
        NAME, "Solver of the quadratic program: active_set, daqp, or the name of one behind qpsolvers"
    )
    thruster_enabled: Annotated[tuple[bool, ...], Field(strict=False)] = setting(
        (), "Per thruster: false for a lost thruster, whose command is ramped to zero"
    )
    azimuth_enabled: Annotated[tuple[bool, ...], Field(strict=False)] = setting(
        (), "Per thruster: false for one that cannot turn and keeps its present direction"
    )
    thrust_limit_scale: Annotated[tuple[Fraction, ...], Field(strict=False)] = setting(
        (), "Per thruster: fraction of the thrust limits that may be used, 0 to 1"
    )
    azimuth_rate_scale: Annotated[tuple[Fraction, ...], Field(strict=False)] = setting(
        (), "Per thruster: fraction of the azimuth rate that may be used, 0 to 1; at 0 it cannot turn"
    )
    longest_step: float = setting(
        1.5,
        "Longest time that one step may allow thrust and direction to change for, in samples of the vessel",
        unit="samples",
        ge=1.0,
        le=100.0,
    )

    @classmethod
    def for_vessel(cls, vessel: Vessel, **overrides: Any) -> Self:
        """Return settings whose fields over thrusters are written out for ``vessel``."""
        n = len(vessel.thrusters)
        values: dict[str, Any] = {
            "thruster_enabled": (True,) * n,
            "azimuth_enabled": (True,) * n,
            "thrust_limit_scale": (1.0,) * n,
            "azimuth_rate_scale": (1.0,) * n,
        }
        return cls(**(values | overrides))


def check_settings(settings: AllocatorSettings, vessel: Vessel) -> None:
    """Check ``settings`` against ``vessel`` and against the solvers of this machine.

    Raises
    ------
    InputError
        If a field over thrusters has the wrong length, or the solver is unknown or not installed.
    """
    n = len(vessel.thrusters)
    for name in ("thruster_enabled", "azimuth_enabled", "thrust_limit_scale", "azimuth_rate_scale"):
        found = len(getattr(settings, name))
        if found not in (0, n):
            raise InputError(
                f"{name}: expected {n} elements, one a thruster ({', '.join(vessel.thruster_names)}), found {found}"
            )
    check_solver(settings.solver)
