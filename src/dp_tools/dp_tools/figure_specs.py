"""What a scenario asks to be measured: one class a kind of figure, told apart by the field ``kind``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from marine_model.schema import PositiveVector3, Section

Axis = Literal["surge", "sway", "yaw"]
Place = Literal["north", "east", "heading"]
Force = Literal["tau_desired", "tau_achieved", "tau_measured"]


class _Figure(Section):
    name: str = Field(pattern=r"^[a-z][a-z0-9_]*$")  # in figures.json
    title: str = Field(min_length=1)  # in the report
    thesis: float | None = None  # what the thesis prints, in the figure's unit
    source: str = ""  # where it is printed
    reason: str = ""  # why ours may differ, or why the thesis has no number
    at_most: float | None = None  # a bound that must hold


class MeanPower(_Figure):
    """Mean of the developed power of all thrusters over a window, W."""

    kind: Literal["mean_power"]
    window: str


class MeanPowerChange(_Figure):
    """Mean developed power of one window over that of another, minus one."""

    kind: Literal["mean_power_change"]
    baseline: str
    compared: str


class PositionError(_Figure):
    """Deviation from the reference over a window, m or deg."""

    kind: Literal["position_error"]
    window: str
    axis: Place
    of: Literal["estimate", "truth"] = "estimate"
    statistic: Literal["std", "rms", "max"]


class ForceLevel(_Figure):
    """Mean or standard deviation of a generalized force over a window, N or N m."""

    kind: Literal["force_level"]
    window: str
    axis: Axis
    force: Force
    statistic: Literal["mean", "std"]


class ForceTracking(_Figure):
    """Root mean square of measured minus commanded generalized force over a window, N or N m."""

    kind: Literal["force_tracking"]
    window: str
    axis: Axis


class TimeToDemand(_Figure):
    """Longest time from a joystick step until the commanded force has come, and stays, within tolerance of it, s."""

    kind: Literal["time_to_demand"]
    window: str
    tolerance: PositiveVector3  # N, N, N m


class AzimuthStep(_Figure):
    """Largest turn of a commanded direction between two samples, deg."""

    kind: Literal["azimuth_step"]
    window: str = ""  # empty: the whole run


class ThrustLevel(_Figure):
    """Mean magnitude of the commanded thrust of one thruster over a window, N."""

    kind: Literal["thrust_level"]
    window: str
    thruster: str


class ThrustLevelChange(_Figure):
    """Mean magnitude of the commanded thrust of one thruster in one window over that in another, minus one."""

    kind: Literal["thrust_level_change"]
    baseline: str
    compared: str
    thruster: str


class VentilatingShare(_Figure):
    """Share of a window in which a thruster was flagged as ventilating."""

    kind: Literal["ventilating_share"]
    window: str
    thruster: str


class ForceDeviation(_Figure):
    """Largest deviation of the commanded from the desired generalized force over a window, N or N m."""

    kind: Literal["force_deviation"]
    window: str
    axis: Axis


class ForceJump(_Figure):
    """Most that the commanded force moved in a sample beyond what was desired, over a window, N or N m."""

    kind: Literal["force_jump"]
    window: str
    axis: Axis


class LimitViolations(_Figure):
    """Number of samples of the whole run in which a limit of a thruster was broken."""

    kind: Literal["limit_violation_count"]


FigureSpec = Annotated[
    MeanPower
    | MeanPowerChange
    | PositionError
    | ForceLevel
    | ForceTracking
    | TimeToDemand
    | AzimuthStep
    | ThrustLevel
    | ThrustLevelChange
    | VentilatingShare
    | ForceDeviation
    | ForceJump
    | LimitViolations,
    Field(discriminator="kind"),
]


def windows_of(figure: FigureSpec) -> tuple[tuple[str, str], ...]:
    """Return (field, window name) of every window that ``figure`` needs."""
    if isinstance(figure, MeanPowerChange | ThrustLevelChange):
        return ("baseline", figure.baseline), ("compared", figure.compared)
    if isinstance(figure, LimitViolations) or not figure.window:
        return ()
    return (("window", figure.window),)
