"""Singularity of thruster configurations: [Ruth] chapter 7. See docs/singularity.md."""

from thrust_allocator.singularity.bounds import AttainableBound, lemma_7_2, theorem_7_3
from thrust_allocator.singularity.cone import horizon_window, window_minimum_gain
from thrust_allocator.singularity.gain import GainMethod, MinimumGain, minimum_gain, minimum_gains
from thrust_allocator.singularity.gain_map import gain_map
from thrust_allocator.singularity.local import (
    LocalKind,
    classify,
    local_minimum_gain,
    required_change,
    required_change_scaled,
)
from thrust_allocator.singularity.minimum_norm import minimum_norm_thrust
from thrust_allocator.singularity.monitor import MonitorReading, Watch, monitor
from thrust_allocator.singularity.projection import Projection, project
from thrust_allocator.singularity.scaling import Scaling, scaled_configuration, scaling_of

__all__ = [
    "AttainableBound",
    "GainMethod",
    "LocalKind",
    "MinimumGain",
    "MonitorReading",
    "Projection",
    "Scaling",
    "Watch",
    "classify",
    "gain_map",
    "horizon_window",
    "lemma_7_2",
    "local_minimum_gain",
    "minimum_gain",
    "minimum_gains",
    "minimum_norm_thrust",
    "monitor",
    "project",
    "required_change",
    "required_change_scaled",
    "scaled_configuration",
    "scaling_of",
    "theorem_7_3",
    "window_minimum_gain",
]
