"""From model to ship: scaling laws, and which model-scale results may be scaled, [Ruth] 2.1 and Table 2.2."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from marine_model.errors import InputError
from marine_model.guards import finite_number, positive_number

Regime = Literal["non_ventilated", "partially_ventilated", "fully_ventilated"]
REGIMES: tuple[Regime, ...] = ("non_ventilated", "partially_ventilated", "fully_ventilated")

GRAVITY = 9.81  # m/s^2
SURFACE_TENSION = 0.072  # N/m, fresh water against air
ATMOSPHERE = 101325.0  # Pa
VAPOUR_PRESSURE = 2340.0  # Pa, water at 20 deg C

REYNOLDS_WITH_CORRECTION = 2e5  # below it ITTC (1999a) has no correction
REYNOLDS_FREE = 5e5  # above it the drag coefficient is constant
# "3 - 4" in [Ruth] (2.5): between the two similarity is asked for.
FROUDE_FREE = 4.0
FROUDE_OF_SHIPS = 1.4  # ships reach no more, Shiba (1953)
WEBER_FREE = 180.0  # above it the critical advance number does not depend on it, Shiba (1953)

# Table 2.2: requirements (2.1)-(2.7) by regime, at low advance speed. Weber's number is in no row of it.
REQUIRED: dict[Regime, tuple[int, ...]] = {
    "non_ventilated": (1, 2, 3, 4),
    "fully_ventilated": (1, 2, 3, 4, 5, 6),
    "partially_ventilated": (1, 2, 3, 4, 5, 6),
}


@dataclass(frozen=True)
class FroudeScale:
    """What model-scale quantities are multiplied by, at the same J and Froude number.

    Attributes
    ----------
    scale
        lambda, ship over model, [Ruth] (2.1).
    density_ratio
        Density of the ship's water over that of the model's.
    """

    scale: float
    density_ratio: float = 1.0

    @property
    def length(self) -> float:
        """Lambda."""
        return self.scale

    @property
    def speed(self) -> float:
        """Square root of lambda."""
        return math.sqrt(self.scale)

    @property
    def shaft_speed(self) -> float:
        """One over the square root of lambda."""
        return 1.0 / math.sqrt(self.scale)

    @property
    def thrust(self) -> float:
        """Lambda^3 and density: K_T and (2.9)."""
        return self.density_ratio * self.scale**3

    @property
    def torque(self) -> float:
        """Lambda^4 and density: K_Q and (2.10)."""
        return self.density_ratio * self.scale**4

    @property
    def power(self) -> float:
        """Lambda^3.5 and density."""
        return self.density_ratio * self.scale**3 * math.sqrt(self.scale)


@dataclass(frozen=True)
class ModelRun:
    """One propeller in one test at model scale.

    Attributes
    ----------
    shaft_speed
        n, Hz, above 0.
    diameter
        D, m, above 0.
    advance_speed
        V_A, m/s.
    shaft_depth
        h, m, of the shaft below the surface.
    chord
        c, m, above 0: of the blade at 0.7 R.
    scale
        lambda, ship over model, above 0.
    regime
        What was seen in the test: one of ``REGIMES``.
    kinematic_viscosity
        nu, m^2/s.
    density
        rho, kg/m^3.
    surface_tension
        s, N/m.

    Raises
    ------
    InputError
        If a number is not finite or not above 0 where it must be, or the regime is not known.
    """

    shaft_speed: float
    diameter: float
    advance_speed: float
    shaft_depth: float
    chord: float
    scale: float
    regime: Regime
    kinematic_viscosity: float = 1.0e-6
    density: float = 1000.0
    surface_tension: float = SURFACE_TENSION

    def __post_init__(self) -> None:
        for name in (
            "shaft_speed",
            "diameter",
            "chord",
            "scale",
            "kinematic_viscosity",
            "density",
            "surface_tension",
        ):
            positive_number(name, getattr(self, name))
        finite_number("advance_speed", self.advance_speed)
        finite_number("shaft_depth", self.shaft_depth)
        if self.regime not in REGIMES:
            raise InputError(f"regime: expected one of {', '.join(REGIMES)}, found {self.regime!r}")

    @property
    def advance_number(self) -> float:
        """J, (2.2)."""
        return self.advance_speed / (self.shaft_speed * self.diameter)

    @property
    def submergence_ratio(self) -> float:
        """h/R, (2.3)."""
        return self.shaft_depth / (0.5 * self.diameter)

    @property
    def inflow_speed(self) -> float:
        """V_inf at 0.7 R, m/s, (2.16)."""
        return math.hypot(self.advance_speed, 0.7 * math.pi * self.shaft_speed * self.diameter)

    @property
    def reynolds_number(self) -> float:
        """R_n, (2.4)."""
        return self.inflow_speed * self.chord / self.kinematic_viscosity

    @property
    def froude_number(self) -> float:
        """F_nD, (2.5)."""
        return self.shaft_speed * math.sqrt(self.diameter / GRAVITY)

    @property
    def cavitation_number(self) -> float:
        """sigma_c, (2.6): of a cavity filled with air in the fully ventilated regime, otherwise with vapour, (2.20).

        Fully ventilated it is (2.21), which is printed with 0.35 pi; V_inf (2.16) gives (0.7 pi)^2.
        """
        pressure = self.density * GRAVITY * self.shaft_depth
        if self.regime != "fully_ventilated":
            pressure += ATMOSPHERE - VAPOUR_PRESSURE
        return pressure / (0.5 * self.density * self.inflow_speed**2)

    @property
    def weber_number(self) -> float:
        """W, (2.7)."""
        return self.shaft_speed * self.diameter * math.sqrt(self.density * self.diameter / self.surface_tension)


@dataclass(frozen=True)
class Requirement:
    """One of [Ruth] (2.1)-(2.7) for one run."""

    number: int  # 1 to 7
    name: str
    value: float  # at model scale
    required: bool  # by Table 2.2
    met: bool
    reason: str


@dataclass(frozen=True)
class ScalingCheck:
    """Whether a result may be scaled, requirement by requirement."""

    run: ModelRun
    requirements: tuple[Requirement, ...]  # seven, in the order of (2.1)-(2.7)

    @property
    def may_be_scaled(self) -> bool:
        """True if every requirement of Table 2.2 is met."""
        return not self.reasons_against

    @property
    def reasons_against(self) -> tuple[str, ...]:
        """What stands against it: name and reason of every requirement that is not met."""
        return tuple(f"{r.name}: {r.reason}" for r in self.requirements if r.required and not r.met)


def check_scaling(run: ModelRun) -> ScalingCheck:
    """Return whether the result of ``run`` may be scaled to the ship, by Table 2.2.

    Requirements 1 to 3 are met by the ship's run that the model stands for, and the reason says which that is. It holds
    at low advance speed, and takes the ship's regime for the model's: [Ruth] 2.1.1 and 2.1.2 say how far that is known.
    """
    to_ship = FroudeScale(run.scale)
    required = REQUIRED[run.regime]

    def requirement(number: int, name: str, value: float, met: bool, reason: str) -> Requirement:
        return Requirement(number, name, value, number in required, met, reason)

    froude_met, froude = _froude(run)
    cavitation_met, cavitation = _cavitation(run, froude_met)
    weber = run.weber_number
    return ScalingCheck(
        run,
        (
            requirement(1, "geometry", run.scale, True, f"for a ship with D = {run.diameter * to_ship.length:.4g} m"),
            requirement(2, "advance number", run.advance_number, True, f"for a ship at J = {run.advance_number:.4g}"),
            requirement(
                3,
                "submergence ratio",
                run.submergence_ratio,
                True,
                f"for a ship with its shaft at {run.shaft_depth * to_ship.length:.4g} m",
            ),
            requirement(4, "Reynolds number", run.reynolds_number, *_reynolds(run.reynolds_number)),
            requirement(5, "Froude number", run.froude_number, froude_met, froude),
            requirement(6, "cavitation number", run.cavitation_number, cavitation_met, cavitation),
            requirement(
                7,
                "Weber number",
                weber,
                weber > WEBER_FREE,
                f"{'above' if weber > WEBER_FREE else 'not above'} {WEBER_FREE:g}; it counts for the advance number "
                "at which ventilation begins",
            ),
        ),
    )


def _reynolds(number: float) -> tuple[bool, str]:
    if number > REYNOLDS_FREE:
        return True, f"above {REYNOLDS_FREE:g}: the drag coefficient is constant"
    if number > REYNOLDS_WITH_CORRECTION:
        return True, f"above {REYNOLDS_WITH_CORRECTION:g}: to be corrected as ITTC (1999) says"
    return False, f"expected above {REYNOLDS_WITH_CORRECTION:g}, found {number:.3g}"


def _froude(run: ModelRun) -> tuple[bool, str]:
    number = run.froude_number
    if number > FROUDE_FREE:
        return True, f"above {FROUDE_FREE:g}: inertial forces dominate gravity"
    if number <= FROUDE_OF_SHIPS:
        shaft_speed = run.shaft_speed * FroudeScale(run.scale).shaft_speed
        return True, f"for a ship at n = {shaft_speed:.4g} Hz"
    return False, (
        f"expected at most {FROUDE_OF_SHIPS:g}, what a ship reaches, or above {FROUDE_FREE:g}, where gravity does not "
        f"count, found {number:.3g}"
    )


def _cavitation(run: ModelRun, froude_met: bool) -> tuple[bool, str]:
    if run.regime == "partially_ventilated":
        return False, "cavities without air need it, which a test at atmospheric pressure does not have"
    if run.regime == "fully_ventilated":
        follows = "follows from advance number, submergence ratio and Froude number (2.21)"
        return froude_met, follows if froude_met else f"{follows}, and the last is not met"
    return False, "not had at atmospheric pressure; without ventilation at low advance speed it is not needed"
