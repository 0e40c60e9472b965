"""Forbidden and reduced sectors of azimuth thrusters: windows, ways between them, and when to change."""

from thrust_allocator.sectors.control import SectorControl, SectorReport
from thrust_allocator.sectors.geometry import (
    Arc,
    ThrusterSectors,
    Window,
    combinations,
    factor_at,
    thruster_sectors,
    vessel_sectors,
)
from thrust_allocator.sectors.path import (
    Path,
    Reach,
    SectorTable,
    nearest_window,
    path_into,
    path_to,
    reach_table,
    sector_table,
)
from thrust_allocator.sectors.supervisor import (
    Candidate,
    CostLimits,
    SupervisorState,
    SwitchingRule,
    advance,
    cost_limits,
    decide,
    may_cross,
    switching_rule,
)

__all__ = [
    "Arc",
    "Candidate",
    "CostLimits",
    "Path",
    "Reach",
    "SectorControl",
    "SectorReport",
    "SectorTable",
    "SupervisorState",
    "SwitchingRule",
    "ThrusterSectors",
    "Window",
    "advance",
    "combinations",
    "cost_limits",
    "decide",
    "factor_at",
    "may_cross",
    "nearest_window",
    "path_into",
    "path_to",
    "reach_table",
    "sector_table",
    "switching_rule",
    "thruster_sectors",
    "vessel_sectors",
]
