"""One graph by the wall clock through a chain of faults: of the pose, of every node of the ring, of the processor.

Simulated time is five times wall time. After each fault every node has to report, anew, that nothing is the matter.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import pairwise
from typing import Any

import numpy as np
import psutil
import pytest
from geometry_msgs.msg import PoseStamped

from dp_bringup.operator_node import Operator, operator
from dp_bringup.parameter_service import RemoteParameters
from dp_node import RING_PUBLISHER
from dp_tools.disturber import DisturberSettings
from marine_model import load_vessel
from marine_model.settings import parameters_of
from support.domains import reserve_domain_id
from support.graph_rig import GraphRig

pytestmark = pytest.mark.timeout(400)

RATE = 5.0
# Distance from the set point within which the vessel has to be again: the noise of a calm day stays below 0.05 m.
ENVELOPE = 0.5  # m
# The drivers need a thruster_command every 2 s, whatever else happens; a machine with other things to do takes longer.
LOST = 10.0  # s of simulated time


class Trial:
    """The graph, its operator, and what is asked of it."""

    def __init__(self, rig: GraphRig, one: Operator) -> None:
        self.rig = rig
        self._disturber = RemoteParameters(one, "disturber")
        self._one = one
        self.calm = 0.0
        """Simulated time from the end of the last fault until nothing was the matter, s."""

    def disturb(self, **values: Any) -> None:
        """Set the disturber's faults; those that are not named are switched off."""
        named = {name.replace("__", "."): value for name, value in values.items()}
        self._disturber.set(parameters_of(DisturberSettings()) | named)

    def hold(self) -> None:
        """Ask for north 0, east 0, heading 0."""
        publisher = self._one.node.create_publisher(PoseStamped, "setpoint", RING_PUBLISHER)
        self._one.wait_until(lambda: publisher.get_subscription_count() > 0, 30.0, "dp_controller to listen")
        message = PoseStamped()
        message.header.frame_id = "map_ned"
        message.pose.orientation.w = 1.0
        publisher.publish(message)

    def wait_until_shown(self, *codes: str) -> None:
        """Wait until each of these alarms is in the newest report of a node at least once from now on."""
        seen: set[str] = set()

        def shown() -> bool:
            for alarms in self.rig.watch.active.values():
                seen.update(alarms)
            return seen >= set(codes)

        self.rig.wait_until(shown, f"alarms {', '.join(codes)}")

    def wait_until_back(self) -> float:
        """Wait until nothing is the matter and the vessel is in its envelope; return simulated time that took (s)."""
        begin = self.rig.time
        self.rig.wait_until_calm()
        self.calm = self.rig.time - begin
        self.rig.wait_until(lambda: self.rig.watch.off[-1][1] < ENVELOPE, f"the vessel within {ENVELOPE} m")
        return self.rig.time - begin


@pytest.fixture(scope="module")
def trial(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Trial]:
    with ExitStack() as stack:
        domain = stack.enter_context(reserve_domain_id())
        patch = stack.enter_context(pytest.MonkeyPatch.context())
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        rig = stack.enter_context(
            GraphRig(
                tmp_path_factory.mktemp("faults"),
                RATE,
                parameters={"dp_controller": {"mode": "setpoint"}},
                remap={"vessel_sim": ["pose:=pose_measured"]},
                disturber=True,
            )
        )
        one = stack.enter_context(operator())
        rig.wait_until(lambda: rig.time > 2.0, "the graph to sail")
        found = Trial(rig, one)
        found.hold()
        found.wait_until_back()
        yield found


@pytest.mark.parametrize(
    ("values", "codes"),
    [
        ({"loss": 0.5}, ("OBSERVER-MEASUREMENTS-LOST",)),
        ({"not_finite": 1.0}, ("NODE-INPUT-REFUSED", "OBSERVER-DEAD-RECKONING", "OBSERVER-ESTIMATE-INVALID")),
        ({"freeze": "message"}, ("NODE-INPUT-REFUSED", "OBSERVER-NO-POSE", "OBSERVER-ESTIMATE-INVALID")),
        ({"duplicate": 0.5}, ("NODE-INPUT-REFUSED",)),
        ({"jump__north": 10.0, "loss": 0.6}, ("OBSERVER-FIX-REFUSED",)),
        ({"time_offset": -10.0}, ("NODE-INPUT-REFUSED", "NODE-SOURCE-RESTARTED")),
    ],
    ids=["lose_half", "not_a_number", "same_message", "duplicate", "jump", "time_backwards"],
)
def test_a_fault_of_the_pose_is_shown_and_over_when_it_is_over(
    trial: Trial, values: dict[str, Any], codes: tuple[str, ...]
) -> None:
    begin = trial.rig.time
    trial.disturb(**values)
    trial.wait_until_shown(*codes)
    trial.disturb()
    lasted = trial.rig.time - begin
    back = trial.wait_until_back()
    off = max(off for at, off in trial.rig.watch.off if at >= begin)
    print(
        f"{values} for {lasted:.1f} s: calm after {trial.calm:.1f} s, back after {back:.1f} s; "
        f"up to {off:.2f} m off the set point"
    )
    assert trial.rig.watch.not_finite == 0


FREEZES: list[tuple[str, float, tuple[str, ...]]] = [
    ("dp_observer", 1.0, ()),
    ("dp_observer", 5.0, ("DRIVERS-COMMAND-STALE",)),
    ("dp_observer", 30.0, ("CONTROLLER-NO-ODOMETRY", "ALLOCATOR-NO-DEMAND", "DRIVERS-COMMAND-STALE")),
    ("dp_controller", 30.0, ("ALLOCATOR-NO-DEMAND", "DRIVERS-COMMAND-STALE")),
    ("thrust_allocator", 30.0, ("DRIVERS-COMMAND-STALE", "CONTROLLER-NO-TAU-ACHIEVED")),
    ("thruster_drivers", 5.0, ("SIMULATOR-NO-SETPOINT",)),
]
# The rest of docs/reliability.md; as much again as the suite has time for.
MORE_FREEZES: list[tuple[str, float, tuple[str, ...]]] = [
    ("dp_controller", 1.0, ()),
    ("dp_controller", 5.0, ("DRIVERS-COMMAND-STALE",)),
    ("thrust_allocator", 1.0, ()),
    ("thrust_allocator", 5.0, ("DRIVERS-COMMAND-STALE",)),
    ("thruster_drivers", 1.0, ()),
    ("thruster_drivers", 30.0, ("SIMULATOR-NO-SETPOINT",)),
    ("vessel_sim", 1.0, ()),
    ("vessel_sim", 5.0, ()),
    # The observer goes on without poses, and so the controller and the allocator have something to do.
    ("vessel_sim", 30.0, ("OBSERVER-NO-POSE", "OBSERVER-ESTIMATE-INVALID", "DRIVERS-NO-FEEDBACK")),
]


@pytest.mark.parametrize(
    ("node", "seconds", "codes"), FREEZES + (MORE_FREEZES if "DP_ALL_FREEZES" in os.environ else [])
)
def test_a_node_that_is_frozen_is_missed_and_comes_back(
    trial: Trial, node: str, seconds: float, codes: tuple[str, ...]
) -> None:
    """Frozen for so much simulated time, or for as long as it takes the others to report that something is missing."""
    rig = trial.rig
    rig.freeze(node)
    begin, began = rig.time, time.monotonic()
    if node == "vessel_sim":  # simulated time stands still
        rig.wait_until(lambda: time.monotonic() >= began + seconds / RATE, "the time of the freeze")
    else:
        rig.sail(seconds)
    if codes:
        trial.wait_until_shown(*codes)
    lasted = rig.time - begin if node != "vessel_sim" else (time.monotonic() - began) * RATE
    rig.thaw(node)
    print(f"{node} frozen for {lasted:.1f} s: back after {trial.wait_until_back():.1f} s")


def test_a_processor_that_is_saturated_makes_the_graph_late_and_loses_no_command(trial: Trial) -> None:
    rig = trial.rig
    begin, feedback = rig.time, rig.watch.feedback
    rig.watch.largest_gap = 0.0
    busy = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"], stdout=subprocess.DEVNULL)
        for _ in range(2 * (psutil.cpu_count() or 1))
    ]
    try:
        rig.sail(20.0)
        late = rig.watch.largest_gap
    finally:
        for process in busy:
            process.kill()
            process.wait()
    # Every step was made and heard: 50 a simulated second.
    lasted = rig.time - begin
    assert rig.watch.feedback - feedback == round(lasted * 50)
    assert late < LOST
    print(f"commands at most {late:.1f} s apart; back after {trial.wait_until_back():.1f} s")


def test_no_thruster_was_asked_for_a_step_beyond_its_rate(trial: Trial) -> None:
    """Over all that went before: what changes between two commands fits the time between them."""
    fastest = float(np.max(load_vessel("cybership3").thrust_rate))
    steps = trial.rig.watch.read().steps
    assert len(steps) > 50
    for (before, _), (stamp, step) in pairwise(steps):
        # 1e-6 N: sums of thrusts are rounded.
        if stamp > before:
            assert step <= fastest * (stamp - before) + 1e-6, f"at {stamp:.2f} s"
