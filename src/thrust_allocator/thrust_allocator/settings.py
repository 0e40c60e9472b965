"""What an operator changes while the allocator runs."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from marine_model import Vessel
from marine_model.axes import HORIZONTAL
from marine_model.errors import InputError
from marine_model.schema import Fraction
from marine_model.settings import Settings, setting
from thrust_allocator.methods.make import check_method, default_moment, knows_speed
from thrust_allocator.methods.settings import AzimuthAngleSettings, PortionSettings, PrioritySettings
from thrust_allocator.program.active_set_solver import NAME
from thrust_allocator.program.solvers import check_solver
from thrust_allocator.singularity.settings import SingularitySettings, limits_of

Switches = Annotated[tuple[bool, ...], Field(strict=False)]
Fractions = Annotated[tuple[Fraction, ...], Field(strict=False)]
# W; what stands for no limit, where a vessel file gives none.
UNLIMITED = 1e9
# Samples of the vessel for which what was told of ventilation holds.
_LONGEST_SILENCE = 5.0
Powers = Annotated[tuple[Annotated[float, Field(ge=0.0, le=UNLIMITED)], ...], Field(strict=False)]
Directions = Annotated[tuple[Annotated[float, Field(ge=-math.pi, le=math.pi)], ...], Field(strict=False)]


class SectorSettings(Settings):
    """Forbidden and reduced sectors, [Ruth] 6.4.1; the sectors themselves belong to the vessel file."""

    enabled: bool = setting(False, "Keep rotating thrusters out of the forbidden sectors of the vessel file")
    hysteresis: float = setting(
        0.04,
        "How much lower log10 of the cost must be to turn a thruster for it, J_lim",
        unit="decades",
        ge=0.0,
        le=10.0,
    )
    dwell_time: float = setting(
        3.0, "Least time between two passages through forbidden sectors, t_lim", unit="s", ge=0.0, le=3600.0
    )


class AutoSettings(Settings):
    """Supervisor of azimuth_mode = auto, [Ruth] (6.3)-(6.5)."""

    force_limit: float = setting(
        1.0, "Filtered surge-sway demand around which thrusters change between fixed and rotating", unit="N", ge=0.0
    )
    hysteresis: float = setting(0.1, "How far beyond the limit a change happens", unit="N", ge=0.0)
    dwell_time: float = setting(5.0, "Least time between two changes", unit="s", ge=0.0, le=3600.0)
    filter_frequency: float = setting(0.2, "Corner of the low-pass filter of the demand", unit="rad/s", ge=1e-6, le=1e3)


class PowerSettings(Settings):
    """Limits of power, [Ruth] 4.4.3."""

    limit: Literal["none", "total", "bus", "both"] = setting("none", "Which limits of power are kept")
    available: float = setting(
        UNLIMITED, "Power of all thrusters together that the plant can give", unit="W", ge=0.0, le=UNLIMITED
    )
    bus_limit: Powers = setting((), "Per bus of the vessel file: power of its thrusters together", unit="W")
    priority: Literal["yaw", "equal"] = setting(
        "yaw", "What gives way to the total limit: surge and sway before yaw, or all in equal shares"
    )
    measured: bool = setting(True, "Correct the prediction by the power that thruster_feedback tells, (4.44)")

    @property
    def needs_measurement(self) -> bool:
        """Whether the measured power has a say."""
        return self.limit != "none" and self.measured


class AntiSpinSettings(Settings):
    """Cost of thrust of ventilating thrusters, [Ruth] (5.11)-(5.18)."""

    enabled: bool = setting(False, "Raise the cost of thrusters that draw air, as ventilation tells")
    exponent_m: float = setting(
        0.65, "m in beta_Q = beta_T^m: how torque goes with thrust when air is drawn", unit="1", ge=0.5, le=1.5
    )
    relax_rate: float = setting(
        0.1, "How fast a torque loss is forgotten, largest rise of beta_Q2", unit="1/s", ge=1e-3, le=100.0
    )
    # Table 2.5 in (2.51): 0.87 * 0.05 + 0.13 is what is left of the torque in full ventilation.
    loss_min: float = setting(
        0.17, "Torque loss factor below which the cost rises no further", unit="1", ge=0.1, le=1.0
    )
    excluded: Switches = setting((), "Per thruster: true for one whose cost stays, whatever it is said to draw")
    timeout: float = setting(
        1.0, "Age from which ventilation counts as unknown, and losses are forgotten", unit="s", ge=1e-3, le=3600.0
    )


class AllocatorSettings(Settings):
    """Settings of :class:`~thrust_allocator.allocator.Allocator`.

    Fields over thrusters have one element a thruster, in the order of the vessel file; empty means the default for
    every thruster.
    """

    method: Literal["qp", "pseudo_inverse", "garus_azimuth", "portioned"] = setting(
        "qp",
        "How a demand is divided: quadratic program; pseudo-inverse; four azimuth propellers that turn together; "
        "portions of marching thrusters in a cross",
    )
    feasible: Literal["none", "proportional", "priority"] = setting(
        "none",
        "With method = pseudo_inverse: how a demand beyond the octahedron is reduced before it is divided",
    )
    compare_qp: bool = setting(
        True, "With another method: solve the quadratic program beside it, and tell what it would achieve"
    )
    azimuth_mode: Literal["fixed", "rotating", "variable", "auto"] = setting(
        "fixed",
        "Azimuth thrusters are held in their fixed directions, rotate (rotating, or variable), or change between both "
        "with the size of the demand (auto)",
    )
    cost: Literal["quadratic", "power_3_2"] = setting(
        "quadratic", "Cost of thrust: its square, or true to power by re-weighting with the thrust of the step before"
    )
    thrust_weight: Literal["vessel", "propeller"] = setting(
        "vessel", "Weights of the cost of thrust: those of the vessel file, or from propeller data by (5.9)-(5.10)"
    )
    over_demand: Literal["slack", "proportional"] = setting(
        "slack", "What is out of reach is missed by axis as slack_weight says, or in all axes in proportion"
    )
    solver: str = setting(
        NAME, "Solver of the quadratic program: active_set, daqp, or the name of one behind qpsolvers"
    )
    thruster_enabled: Switches = setting((), "Per thruster: false for a lost thruster, whose command is ramped to zero")
    azimuth_enabled: Switches = setting(
        (), "Per thruster: false for one that cannot turn: it is allocated as fixed where thruster_feedback sees it"
    )
    thrust_limit_scale: Fractions = setting(
        (), "Per thruster: fraction of the thrust limits that may be used, 0 to 1", unit="1"
    )
    azimuth_rate_scale: Fractions = setting(
        (), "Per thruster: fraction of the azimuth rate that may be used, 0 to 1; at 0 it cannot turn", unit="1"
    )
    fixed_direction: Directions = setting(
        (),
        "Per thruster: direction of its thrust while held fixed; a tunnel thruster keeps its own",
        unit="rad",
    )
    feather_time: float = setting(
        0.0,
        "Time in which the thrust limits of a thruster grow from nothing when it is enabled again",
        unit="s",
        ge=0.0,
        le=3600.0,
    )
    longest_step: float = setting(
        1.5,
        "Longest time that one step may allow thrust and direction to change for, in samples of the vessel",
        unit="samples",
        ge=1.0,
        le=100.0,
    )
    auto: AutoSettings = Field(default=AutoSettings())
    sectors: SectorSettings = Field(default=SectorSettings())
    power: PowerSettings = Field(default=PowerSettings())
    singularity: SingularitySettings = Field(default=SingularitySettings())
    antispin: AntiSpinSettings = Field(default=AntiSpinSettings())
    priority: PrioritySettings = Field(default=PrioritySettings())
    garus_azimuth: AzimuthAngleSettings = Field(default=AzimuthAngleSettings())
    portions: PortionSettings = Field(default=PortionSettings())

    @property
    def needs_direction(self) -> bool:
        """Whether an azimuth drive is lost, so that the measured directions have a say."""
        return not all(self.azimuth_enabled) or 0.0 in self.azimuth_rate_scale

    @property
    def needs_speed(self) -> bool:
        """Whether the speed through the water has a say."""
        return self.method == "portioned" and self.portions.speed_limited

    def enabled(self, vessel: Vessel) -> NDArray[np.bool_]:
        """Return which thrusters are not lost, shape (n,)."""
        return np.array(self.thruster_enabled or (True,) * len(vessel.thrusters), dtype=np.bool_)

    @classmethod
    def for_vessel(cls, vessel: Vessel, **overrides: Any) -> Self:
        """Return settings with the numbers of ``vessel``: fields over thrusters written out, supervisors, power."""
        n = len(vessel.thrusters)
        gains = vessel.allocator
        values: dict[str, Any] = {
            "thruster_enabled": (True,) * n,
            "azimuth_enabled": (True,) * n,
            "thrust_limit_scale": (1.0,) * n,
            "azimuth_rate_scale": (1.0,) * n,
            "fixed_direction": tuple(vessel.fixed_direction.tolist()),
        }
        if gains.fixed_rotating is not None:
            values["auto"] = AutoSettings(**gains.fixed_rotating.model_dump())
        if gains.sectors is not None:
            values["sectors"] = SectorSettings(**gains.sectors.model_dump())
        values["power"] = PowerSettings(
            available=min(vessel.power_available, UNLIMITED),
            bus_limit=tuple(min(limit, UNLIMITED) for limit in vessel.bus_limit.tolist()),
        )
        if gains.singularity is not None:
            values["singularity"] = SingularitySettings(**gains.singularity.model_dump())
        antispin: dict[str, Any] = {
            "excluded": (False,) * n,
            "timeout": _LONGEST_SILENCE * vessel.measurement.sample_time,
        }
        if vessel.drivers.ventilation is not None:
            antispin["relax_rate"] = vessel.drivers.ventilation.relax_rate
        values["antispin"] = AntiSpinSettings(**antispin)
        values["priority"] = PrioritySettings(weights=(1.0,) * len(vessel.degrees_of_freedom))
        values["garus_azimuth"] = AzimuthAngleSettings(reserved_moment=default_moment(vessel))
        values["portions"] = PortionSettings(speed_limited=knows_speed(vessel))
        return cls(**(values | overrides))


def check_settings(settings: AllocatorSettings, vessel: Vessel) -> None:
    """Check ``settings`` against ``vessel`` and against the solvers of this machine.

    Raises
    ------
    InputError
        If a field over thrusters has the wrong length, the solver is unknown or not installed, or a limit of power is
        asked for that was not given, or a method or an option does not fit the vessel.
    """
    n = len(vessel.thrusters)
    per_thruster = {
        "thruster_enabled": settings.thruster_enabled,
        "azimuth_enabled": settings.azimuth_enabled,
        "thrust_limit_scale": settings.thrust_limit_scale,
        "azimuth_rate_scale": settings.azimuth_rate_scale,
        "fixed_direction": settings.fixed_direction,
        "antispin.excluded": settings.antispin.excluded,
    }
    for name, values in per_thruster.items():
        found = len(values)
        if found not in (0, n):
            raise InputError(
                f"{name}: expected {n} elements, one a thruster ({', '.join(vessel.thruster_names)}), found {found}"
            )
    check_solver(settings.solver)
    if vessel.degrees_of_freedom != HORIZONTAL:
        _check_axes(settings, vessel)
    if settings.singularity.method != "none":
        limits_of(settings.singularity, vessel)
    buses, found = len(vessel.power.buses), len(settings.power.bus_limit)
    asked = settings.power.limit in ("bus", "both")
    if found not in (0, buses) or (asked and not found):
        raise InputError(
            f"power.bus_limit: expected {buses} elements, one a bus of the vessel file"
            f"{', and at least one bus' if not buses else ''}, found {found}"
        )
    if settings.sectors.enabled and not any(vessel.sectors):
        raise InputError(f"sectors.enabled: expected a vessel with sectors, found none in '{vessel.name}'")
    if settings.auto.hysteresis >= settings.auto.force_limit:
        raise InputError(
            "auto.hysteresis: expected less than auto.force_limit, or the thrusters are never held again, found "
            f"{settings.auto.hysteresis} and {settings.auto.force_limit}"
        )
    check_method(settings, vessel)


def _check_axes(settings: AllocatorSettings, vessel: Vessel) -> None:
    """Refuse what only makes sense in surge, sway and yaw for a vessel that controls other axes."""
    power = settings.power
    refused = {
        "azimuth_mode": settings.azimuth_mode if settings.azimuth_mode == "auto" else "",
        "sectors.enabled": "true" if settings.sectors.enabled else "",
        "singularity.method": settings.singularity.method if settings.singularity.method != "none" else "",
        "power.priority": power.priority if power.limit in ("total", "both") and power.priority == "yaw" else "",
    }
    for name, found in refused.items():
        if found:
            raise InputError(
                f"{name}: expected another value for a vessel that controls {', '.join(vessel.degrees_of_freedom)}: "
                f"it is for surge, sway, yaw, found {found}"
            )
