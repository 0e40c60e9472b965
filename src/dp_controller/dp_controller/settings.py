"""What an operator may change while the controller runs."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field

from marine_model import Vessel
from marine_model.axes import HORIZONTAL, VERTICAL
from marine_model.errors import InputError
from marine_model.schema import NonNegativeVector3
from marine_model.settings import Settings, setting

Mode = Literal["standby", "joystick", "setpoint", "semi_automatic", "tracking"]
AxisMode = Literal["off", "joystick", "automatic"]
AxisModes = tuple[AxisMode, AxisMode, AxisMode]

_Scale = Annotated[float, Field(ge=0.0, le=10.0)]
_Scale3 = Annotated[tuple[_Scale, _Scale, _Scale], Field(strict=False)]
_SpeedFraction = Annotated[float, Field(ge=0.01, le=1.0)]
_SpeedFraction3 = Annotated[tuple[_SpeedFraction, _SpeedFraction, _SpeedFraction], Field(strict=False)]

_ONES = (1.0, 1.0, 1.0)


class WindFeedforwardSettings(Settings):
    """Use of the measured wind."""

    enabled: bool = setting(False, "Ask for the opposite of the wind's estimated force; needs a measured wind")
    gain: float = setting(1.0, "Part of the estimated force that is asked for", unit="1", ge=0.0, le=2.0)
    filter_time: float = setting(
        1.0,
        "Time constant with which the force follows the measured wind, so that thrusters do not follow gusts",
        unit="s",
        ge=0.0,
    )
    timeout: float = setting(
        2.0, "Time without a measured wind after which the integral takes the feed-forward over", unit="s", ge=0.0
    )


class VerticalSettings(Settings):
    """Heave, roll and pitch of submerged vehicles; without a meaning on the surface. Vectors are heave, roll, pitch."""

    axis_heave: AxisMode = setting("off", "Heave in mode semi_automatic; off without that degree of freedom")
    axis_roll: AxisMode = setting("off", "Roll in mode semi_automatic; off without that degree of freedom")
    axis_pitch: AxisMode = setting("off", "Pitch in mode semi_automatic; off without that degree of freedom")
    proportional_scale: _Scale3 = setting(
        _ONES, "Factor on the vehicle's proportional gain in heave, roll, pitch, 0 to 10", unit="1"
    )
    integral_scale: _Scale3 = setting(
        _ONES, "Factor on the vehicle's integral gain in heave, roll, pitch, 0 to 10", unit="1"
    )
    derivative_scale: _Scale3 = setting(
        _ONES, "Factor on the vehicle's derivative gain in heave, roll, pitch, 0 to 10", unit="1"
    )
    velocity_scale: _SpeedFraction3 = setting(
        _ONES,
        "Part of the vehicle's velocity limit that the reference may use in heave, roll, pitch, 0.01 to 1",
        unit="1",
    )
    tau_max: NonNegativeVector3 = setting(
        (0.0, 0.0, 0.0), "Largest demand in heave, roll, pitch; 0 for no limit", unit="N, N m, N m"
    )
    depth_alarm: float = setting(
        0.0, "Distance from the reference depth beyond which an alarm is raised; 0 for never", unit="m", ge=0.0
    )


class ControllerSettings(Settings):
    """Operator-facing options of the controller. Vectors are surge, sway, yaw."""

    mode: Mode = setting("standby", "What the controller does")
    axis_surge: AxisMode = setting("joystick", "Surge in mode semi_automatic")
    axis_sway: AxisMode = setting("joystick", "Sway in mode semi_automatic")
    axis_yaw: AxisMode = setting("automatic", "Yaw in mode semi_automatic")
    proportional_scale: _Scale3 = setting(
        _ONES, "Factor on the vessel's proportional gain in surge, sway, yaw, 0 to 10", unit="1"
    )
    integral_scale: _Scale3 = setting(
        _ONES, "Factor on the vessel's integral gain in surge, sway, yaw, 0 to 10", unit="1"
    )
    derivative_scale: _Scale3 = setting(
        _ONES, "Factor on the vessel's derivative gain in surge, sway, yaw, 0 to 10", unit="1"
    )
    velocity_scale: _SpeedFraction3 = setting(
        _ONES, "Part of the vessel's velocity limit that the reference may use in surge, sway, yaw, 0.01 to 1", unit="1"
    )
    velocity_feedback: Literal["vessel", "error"] = setting(
        "vessel",
        "Velocity that the derivative term damps at a set point: that of the vessel, as in [Ruth] (B.15), "
        "or its difference from the reference (always so in mode tracking)",
    )
    anti_windup_time: float = setting(
        20.0, "Time constant with which the integral gives way to saturated thrusters; 0 for never", unit="s", ge=0.0
    )
    transfer_time: float = setting(
        5.0, "Time in which a step of the demand at a switch fades; 0 for no bumpless transfer", unit="s", ge=0.0
    )
    joystick_timeout: float = setting(
        2.0, "Age from which a joystick input fades to zero; 0 for never", unit="s", ge=0.0
    )
    tau_max: NonNegativeVector3 = setting(
        (0.0, 0.0, 0.0), "Largest demand in surge, sway, yaw; 0 for no limit", unit="N, N, N m"
    )
    position_alarm: float = setting(
        0.0, "Distance from the reference beyond which an alarm is raised; 0 for never", unit="m", ge=0.0
    )
    heading_alarm: float = setting(
        0.0, "Angle from the reference heading beyond which an alarm is raised; 0 for never", unit="rad", ge=0.0
    )

    wind_feedforward: WindFeedforwardSettings = WindFeedforwardSettings()
    vertical: VerticalSettings = VerticalSettings()

    @classmethod
    def for_vessel(cls, vessel: Vessel, **overrides: Any) -> Self:
        """Return settings that fit the degrees of freedom of ``vessel``."""
        if not vessel.is_submerged:
            return cls(**overrides)
        axes = vessel.degrees_of_freedom
        values: dict[str, Any] = {f"axis_{axis}": "off" for axis in HORIZONTAL if axis not in axes}
        automatic: dict[str, Any] = {f"axis_{axis}": "automatic" for axis in VERTICAL if axis in axes}
        return cls(**(values | {"vertical": VerticalSettings(**automatic)} | overrides))

    @property
    def axis_modes(self) -> AxisModes:
        """Modes of surge, sway and yaw."""
        if self.mode == "semi_automatic":
            return self.axis_surge, self.axis_sway, self.axis_yaw
        return _AXIS_MODES[self.mode]

    @property
    def vertical_modes(self) -> AxisModes:
        """Modes of heave, roll and pitch, where the vehicle has them."""
        if self.mode == "semi_automatic":
            return self.vertical.axis_heave, self.vertical.axis_roll, self.vertical.axis_pitch
        return _AXIS_MODES[self.mode]


_AXIS_MODES: dict[str, AxisModes] = {
    "standby": ("off", "off", "off"),
    "joystick": ("joystick", "joystick", "joystick"),
    "setpoint": ("automatic", "automatic", "automatic"),
    "tracking": ("automatic", "automatic", "automatic"),
}


def check_settings(settings: ControllerSettings, vessel: Vessel) -> None:
    """Refuse what the vessel cannot do.

    Raises
    ------
    InputError
        If feed-forward is enabled and nobody knows what the wind does to the vessel, or an axis is to be controlled
        that the vessel has not.
    """
    asked = {
        **{f"axis_{axis}": getattr(settings, f"axis_{axis}") for axis in HORIZONTAL},
        **{f"vertical.axis_{axis}": getattr(settings.vertical, f"axis_{axis}") for axis in VERTICAL},
    }
    for name, mode in asked.items():
        if mode != "off" and name.rpartition("_")[2] not in vessel.degrees_of_freedom:
            has = ", ".join(vessel.degrees_of_freedom)
            raise InputError(f"{name}: expected off, because vessel '{vessel.name}' controls {has}, found {mode}")
    if settings.wind_feedforward.enabled and vessel.wind_forces is None:
        raise InputError(
            f"wind_feedforward.enabled: expected false, because vessel '{vessel.name}' has no section wind_forces, "
            "found true"
        )
