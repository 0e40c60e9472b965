"""Which faults the disturber makes; all of them may be changed while it runs."""

from __future__ import annotations

from typing import Literal

from marine_model.settings import Settings, setting

Freeze = Literal["no", "value", "message"]


class JumpSettings(Settings):
    """An offset of the measured position, as of a reference that has lost its fix."""

    north: float = setting(0.0, "Added to the position to the north.", unit="m", ge=-1e6, le=1e6)
    east: float = setting(0.0, "Added to the position to the east.", unit="m", ge=-1e6, le=1e6)
    heading: float = setting(0.0, "Added to the heading.", unit="rad", ge=-1e3, le=1e3)


class DisturberSettings(Settings):
    """Faults of a stream of poses. Without any, every message goes through as it came."""

    seed: int = setting(0, "Of the random choices: equal seeds and messages give equal faults.", ge=0, le=2**31 - 1)
    loss: float = setting(0.0, "Share of messages that are lost.", unit="1", ge=0.0, le=1.0)
    duplicate: float = setting(0.0, "Share of messages that are sent twice.", unit="1", ge=0.0, le=1.0)
    reorder: float = setting(0.0, "Share of messages that the next one overtakes.", unit="1", ge=0.0, le=1.0)
    not_finite: float = setting(0.0, "Share of messages whose numbers are not numbers.", unit="1", ge=0.0, le=1.0)
    delay: float = setting(
        0.0,
        "Time by which messages come later, in the time of their stamps: one is sent when another comes whose stamp is "
        "so much later.",
        unit="s",
        ge=0.0,
        le=3600.0,
    )
    freeze: Freeze = setting(
        "no",
        "no; value: every message repeats the position of the first one, with stamps that go on; message: stamps too.",
    )
    time_offset: float = setting(0.0, "Added to the stamps; negative is back in time.", unit="s", ge=-1e6, le=1e6)
    other_cover: bool = setting(
        False, "Send quaternions with the other sign: the same heading, written as if it had wrapped."
    )
    jump: JumpSettings = setting(JumpSettings(), "Offset of the position.")
