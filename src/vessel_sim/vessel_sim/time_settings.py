"""Settings of the simulator's node: those of the core, and how time goes."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from marine_model.settings import setting
from vessel_sim.settings import SimulatorSettings

_SLOWEST = 1e-6  # a step of the simulator then takes hours; below, no timer can tell its time


class NodeSettings(SimulatorSettings):
    """Settings of the core, and how time goes."""

    lockstep: bool = setting(
        False, "Wait for the ring to answer every sample: runs are repeatable to the bit", read_only=True
    )
    rate: float = setting(
        1.0,
        "Simulated seconds a wall second; 1 is real time, 0 as fast as the ring answers (lockstep only)",
        unit="1",
        ge=0.0,
        le=1e9,
    )
    hold: bool = setting(False, "Stand still until the service ~/advance says how far to sail", read_only=True)
    lockstep_timeout: float = setting(
        5.0, "Wall time without an answer after which lockstep says what is missing", unit="s", ge=0.1
    )

    start_time: float = setting(
        0.0,
        "Simulated time at which it begins when configured; vessel, sea and wind begin anew in any case",
        unit="s",
        ge=0.0,
        le=1e9,
    )
    setpoint_timeout: float = setting(
        1.0,
        "Simulated time without an actuator_setpoint after which a motor drive takes its torque and azimuth rate away; "
        "0 for never; not in lockstep, where time waits for the set point",
        unit="s",
        ge=0.0,
    )

    @model_validator(mode="after")
    def _time_goes_on(self) -> Self:
        if self.rate == 0.0 and not self.lockstep:
            raise ValueError("rate: expected above 0 unless lockstep is on, found 0.0")
        if 0.0 < self.rate < _SLOWEST:
            raise ValueError(f"rate: expected 0 or at least {_SLOWEST:g}, found {self.rate:g}")
        return self
