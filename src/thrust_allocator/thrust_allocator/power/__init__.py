"""Limits of power: total, with yaw served first, and by bus; [Ruth] 4.4.3."""

from thrust_allocator.power.bus import BusRowKind, bus_row, tangent_excess
from thrust_allocator.power.limiter import PowerLimiter, PowerReport
from thrust_allocator.power.priority import PowerAnswer, PowerStage, limit_total_power
from thrust_allocator.power.total import (
    Correction,
    CorrectionSource,
    full_power,
    measured_correction,
    phase_back,
    phase_back_factor,
    total_power,
)

__all__ = [
    "BusRowKind",
    "Correction",
    "CorrectionSource",
    "PowerAnswer",
    "PowerLimiter",
    "PowerReport",
    "PowerStage",
    "bus_row",
    "full_power",
    "limit_total_power",
    "measured_correction",
    "phase_back",
    "phase_back_factor",
    "tangent_excess",
    "total_power",
]
