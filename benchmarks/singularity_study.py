"""`python -m benchmarks.singularity_study`: what singularity avoidance does to 1 m to port, as in Run K.

The closed loop of dp_tools sails [Ruth] 7.9.2: azimuth rate 0.10 rad a sample, sigma_lim 0.5, t_lim 0, no waves, 1 m to
port and 1 m more. The thesis says that its results depend very much on how the thrusters point when a change begins.
Here a weak current from eight directions sees to that; maxima are over all of them, means are of all.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from dp_tools.in_process import ClosedLoop
from dp_tools.scenario import Event, Scenario
from marine_model import Vessel, load_vessel
from thrust_allocator.singularity.scaling import scaled_configuration, scaling_of

Method = Literal["none", "three_step", "required_gain", "crossing"]
METHODS: tuple[Method, ...] = ("none", "three_step", "required_gain", "crossing")
RATE = 0.10 / 0.2  # rad/s, Run K
SETTLED = 60.0  # s, the integral action has found the current by then
CHANGES = (60.0, 100.0)  # s
DURATION = 140.0  # s
CURRENT = 0.06  # m/s
_SIGNALS = ("slack", "reference_position", "truth_position", "azimuth_command", "power")


class Row(NamedTuple):
    """Figures of one method, over all currents."""

    method: str
    surge: float  # N, largest |slack|
    sway: float
    yaw: float  # N m
    off_surge: float  # m, largest |reference - truth|
    off_sway: float
    off_yaw: float  # rad
    power: float  # W, mean, of all shafts
    below: float  # s a run with a gain below the limit


def sail(vessel: Vessel, method: Method, currents: int) -> Row:
    """Return the figures of one method."""
    scaling = scaling_of(vessel)
    limit = vessel.allocator.singularity.gain_limit if vessel.allocator.singularity else math.nan
    worst, off = np.zeros(3), np.zeros(3)
    powers, belows = [], []
    for k in range(currents):
        scenario = Scenario(
            name="run_k_currents",
            title="Run K",
            description="1 m to port, twice",
            vessel=vessel.name,
            duration=DURATION,
            seed=1,
            parameters={
                "vessel_sim": {"current.speed": CURRENT, "current.direction": 2.0 * math.pi * k / currents - math.pi},
                "dp_controller": {"mode": "setpoint"},
                "thrust_allocator": {
                    "azimuth_mode": "rotating",
                    "singularity.method": method,
                    "azimuth_rate_scale": [min(RATE / r, 1.0) if r > 0.0 else 1.0 for r in vessel.azimuth_rate],
                },
            },
            events=(
                Event(at=0.0, setpoint=(0.0, 0.0, 0.0)),
                *(Event(at=at, setpoint=(0.0, -1.0 - i, 0.0)) for i, at in enumerate(CHANGES)),
            ),
        )
        data = ClosedLoop(vessel, scenario).run()
        moving = {name: data[name].window(SETTLED, DURATION).values for name in _SIGNALS}
        worst = np.maximum(worst, np.abs(moving["slack"]).max(axis=0))
        error = moving["reference_position"] - moving["truth_position"]
        off = np.maximum(off, np.abs(error).max(axis=0))
        powers.append(float(moving["power"].sum(axis=1).mean()))
        gains = [
            np.linalg.svd(scaled_configuration(scaling, azimuth), compute_uv=False)[2]
            for azimuth in moving["azimuth_command"]
        ]
        belows.append(float((np.array(gains) < limit * (1.0 - 1e-6)).sum()) * vessel.measurement.sample_time)
    return Row(
        method=method,
        surge=float(worst[0]),
        sway=float(worst[1]),
        yaw=float(worst[2]),
        off_surge=float(off[0]),
        off_sway=float(off[1]),
        off_yaw=float(off[2]),
        power=float(np.mean(powers)),
        below=float(np.mean(belows)),
    )


def main(arguments: Sequence[str]) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.singularity_study", description=__doc__)
    parser.add_argument("--currents", type=int, default=8, help="how many directions of the current")
    given = parser.parse_args(arguments)
    vessel = load_vessel("cybership3")
    table = Table(title=f"1 m to port twice, {given.currents} currents of {CURRENT} m/s")
    for heading in (
        "method", "surge N", "sway N", "yaw N m", "surge m", "sway m", "yaw deg", "power W", "below s",
    ):  # fmt: skip
        table.add_column(heading, justify="right")
    for method in METHODS:
        row = sail(vessel, method, given.currents)
        table.add_row(
            method, f"{row.surge:.2f}", f"{row.sway:.2f}", f"{row.yaw:.3f}", f"{row.off_surge:.3f}",
            f"{row.off_sway:.3f}", f"{math.degrees(row.off_yaw):.1f}", f"{row.power:.3f}", f"{row.below:.1f}",
        )  # fmt: skip
    Console(width=140).print(table)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
