"""Settings of the simulator: sea, current and wind, the sensors, and where the run begins."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from marine_model.constants import GRAVITY
from marine_model.errors import InputError
from marine_model.settings import Settings, setting
from marine_model.vessel import Vessel

Switches = Annotated[tuple[bool, ...], Field(strict=False)]

_BREAKING_STEEPNESS = 1.0 / 7.0  # height over length of the steepest wave that does not break (Michell)
_SEA_STEEPNESS = 1.0 / 15.0  # 2 pi H_s / (g T_p^2) of the steepest seas, DNV-RP-C205, 3.5.5, at short peak periods


class WaveSettings(Settings):
    """Waves in deep water: regular and long-crested, or irregular."""

    kind: Literal["regular", "jonswap", "ittc"] = setting(
        "regular", "One regular wave, or a sea with the spectrum JONSWAP or ITTC (two parameters, Bretschneider)"
    )
    amplitude: float = setting(0.0, "Regular waves: amplitude, half of the height", unit="m", ge=0.0)
    period: float = setting(1.0, "Regular waves: period seen from a fixed point", unit="s", ge=0.01)
    significant_height: float = setting(0.0, "Irregular sea: significant wave height", unit="m", ge=0.0)
    peak_period: float = setting(1.0, "Irregular sea: period of the spectrum's peak", unit="s", ge=0.01)
    peakedness: float = setting(3.3, "JONSWAP: gamma, height of the peak over one without", unit="1", ge=1.0, le=20.0)
    components: int = setting(100, "Irregular sea: number of components", ge=1, le=2000)
    spreading: float = setting(
        0.0,
        "Irregular sea: s of the spreading function cos^2s(delta/2); 0 is long-crested",
        unit="1",
        ge=0.0,
        le=1000.0,
    )
    direction: float = setting(
        math.pi,
        "Direction in NED that the waves travel towards (the main one of a short-crested sea); pi is head seas for a "
        "ship heading north",
        unit="rad",
        ge=-2.0 * math.pi,
        le=2.0 * math.pi,
    )
    ramp: float = setting(
        2.0, "Time in which the waves grow or die down, at the start and after a change", unit="s", ge=0.0
    )
    maker_distance: float = setting(
        0.0,
        "How far before the map origin the wave maker is, from which changes travel with the group velocity; 0: they "
        "come everywhere at once",
        unit="m",
        ge=0.0,
        read_only=True,
    )

    @property
    def wave_number(self) -> float:
        """Deep-water wave number omega^2 / g of regular waves, rad/m."""
        return (2.0 * math.pi / self.period) ** 2 / GRAVITY

    @model_validator(mode="after")
    def _does_not_break(self) -> Self:
        if self.kind == "regular":
            steepness = self.amplitude * self.wave_number / math.pi
            if steepness > _BREAKING_STEEPNESS:
                raise ValueError(
                    "waves.amplitude and waves.period: expected height over length at most 1/7, where waves break, "
                    f"found {steepness:.3f} from {self.amplitude} m and {self.period} s"
                )
            return self
        steepness = 2.0 * math.pi * self.significant_height / (GRAVITY * self.peak_period**2)
        if steepness > _SEA_STEEPNESS:
            raise ValueError(
                "waves.significant_height and waves.peak_period: expected height over length at the peak at most 1/15, "
                f"as steep as seas get (DNV-RP-C205), found {steepness:.3f} from {self.significant_height} m and "
                f"{self.peak_period} s"
            )
        return self


class CurrentSettings(Settings):
    """Uniform current."""

    speed: float = setting(0.0, "Current speed", unit="m/s", ge=0.0, le=20.0)
    direction: float = setting(
        0.0,
        "Direction in NED that the current sets towards",
        unit="rad",
        ge=-2.0 * math.pi,
        le=2.0 * math.pi,
    )

    variation: float = setting(
        0.0, "Standard deviation of a slow variation of the speed about its mean", unit="m/s", ge=0.0, le=20.0
    )
    direction_variation: float = setting(
        0.0, "Standard deviation of a slow variation of the direction about its mean", unit="rad", ge=0.0, le=math.pi
    )
    time_constant: float = setting(
        100.0, "Time in which a variation fades to 1/e (first-order Gauss-Markov process)", unit="s", ge=0.1
    )


class WindSettings(Settings):
    """Wind, where the vessel has wind_forces."""

    speed: float = setting(
        0.0,
        "Mean wind speed (one hour at full scale), 10 m above the sea at full scale; at the scale of the vessel",
        unit="m/s",
        ge=0.0,
        le=200.0,
    )
    direction: float = setting(
        math.pi,
        "Direction in NED that the wind blows towards; pi is head wind for a ship heading north",
        unit="rad",
        ge=-2.0 * math.pi,
        le=2.0 * math.pi,
    )
    gusts: bool = setting(False, "Gusts of the NPD spectrum along the mean wind")
    components: int = setting(100, "Components that the gusts are made of", ge=1, le=10_000)
    direction_variation: float = setting(
        0.0, "Standard deviation of a slow variation of the direction about its mean", unit="rad", ge=0.0, le=math.pi
    )
    time_constant: float = setting(100.0, "Time in which the variation of the direction fades to 1/e", unit="s", ge=0.1)


class PropulsionSettings(Settings):
    """What the water does to the propellers, and which thrusters have failed; empty means none."""

    inflow: bool = setting(True, "Advance speed at the propellers changes their thrust and torque")
    ventilation: bool = setting(True, "Propellers near the surface lose thrust and torque to air")
    failed: Switches = setting((), "Per thruster: true for one whose motor gives no torque, so that it windmills")
    azimuth_failed: Switches = setting(
        (), "Per thruster: true for one whose azimuth motor gives no rate, so that it stays where it points"
    )


class InitialState(Settings):
    """Where the vessel lies, at rest over ground, when the run begins."""

    north: float = setting(0.0, "Position north at the start", unit="m", ge=-1e7, le=1e7, read_only=True)
    east: float = setting(0.0, "Position east at the start", unit="m", ge=-1e7, le=1e7, read_only=True)
    heading: float = setting(
        0.0, "Heading at the start", unit="rad", ge=-2.0 * math.pi, le=2.0 * math.pi, read_only=True
    )
    depth: float = setting(
        0.0,
        "Depth of the origin of a submerged vehicle at the start, one length of it unless given; 0 on the surface",
        unit="m",
        ge=0.0,
        le=12_000.0,
        read_only=True,
    )


class SimulatorSettings(Settings):
    """Everything about a run that is not the vessel."""

    waves: WaveSettings = WaveSettings()
    current: CurrentSettings = CurrentSettings()
    wind: WindSettings = WindSettings()
    propulsion: PropulsionSettings = PropulsionSettings()
    initial: InitialState = InitialState()
    seed: int = setting(
        0, "Seed of sensor noise, dropout, irregular seas, gusts and slow variations", ge=0, read_only=True
    )
    sensor_noise: bool = setting(True, "Sensors have the noise that the vessel file gives them")
    pose_dropout: float = setting(
        0.0, "Chance that a pose is lost, on top of the vessel file's dropout", unit="1", ge=0.0, le=1.0
    )

    @classmethod
    def for_vessel(cls, vessel: Vessel, **overrides: Any) -> Self:
        """Return settings for ``vessel``: fields over thrusters written out, below the surface if it belongs there."""
        none = (False,) * len(vessel.thrusters)
        written: dict[str, Any] = {"propulsion": PropulsionSettings(failed=none, azimuth_failed=none)}
        if vessel.is_submerged:
            written["initial"] = InitialState(depth=vessel.hull.length)
        return cls(**(written | overrides))


def check_settings(settings: SimulatorSettings, vessel: Vessel) -> None:
    """Check ``settings`` against ``vessel``.

    Raises
    ------
    InputError
        If a field over thrusters has the wrong length, wind is to blow on a vessel of which nobody knows what the wind
        does to it, waves are to reach a submerged one, or the depth at the start does not suit it.
    """
    n = len(vessel.thrusters)
    for name in ("failed", "azimuth_failed"):
        found = len(getattr(settings.propulsion, name))
        if found not in (0, n):
            names = ", ".join(vessel.thruster_names)
            raise InputError(f"propulsion.{name}: expected {n} elements, one a thruster ({names}), found {found}")
    speed = settings.wind.speed
    if speed > 0.0 and vessel.wind_forces is None:
        raise InputError(
            f"wind.speed: expected 0, because vessel '{vessel.name}' has no section wind_forces, found {speed} m/s"
        )
    depth = settings.initial.depth
    if not vessel.is_submerged:
        if depth != 0.0:
            raise InputError(
                f"initial.depth: expected 0, because vessel '{vessel.name}' is on the surface, found {depth} m"
            )
        return
    top = 0.5 * vessel.hull.draught
    if depth < top:
        raise InputError(
            f"initial.depth: expected at least {top:g} m, half the height of '{vessel.name}', so that it begins below "
            f"the surface, found {depth} m"
        )
    waves = settings.waves
    name, height = (
        ("amplitude", waves.amplitude) if waves.kind == "regular" else ("significant_height", waves.significant_height)
    )
    if height > 0.0:
        raise InputError(
            f"waves.{name}: expected 0, because nothing is known of what waves do to '{vessel.name}' below the "
            f"surface, found {height} m"
        )
