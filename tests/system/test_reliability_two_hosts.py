"""Nodes on two hosts: control on one, thrusters and vessel on the other, and the link between them is cut."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.domains import reserve_domain_id
from support.graph_rig import GraphRig
from support.two_hosts import two_hosts

pytestmark = pytest.mark.timeout(300)

RATE = 2.0
CUT = 10.0  # s of simulated time, 5 s on the wall clock
CONTROL = ("dp_observer", "dp_controller", "thrust_allocator")
VESSEL = ("thruster_drivers", "vessel_sim", "watch")


def test_a_link_that_is_cut_stops_the_thrusters_and_comes_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with two_hosts() as hosts, reserve_domain_id() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        # Beyond this machine, but no further than the two namespaces reach.
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
        where = {name: hosts.on(hosts.first) for name in CONTROL} | {name: hosts.on(hosts.second) for name in VESSEL}
        with GraphRig(tmp_path, RATE, {"dp_controller": {"mode": "setpoint"}}, prefix=where) as rig:
            rig.wait_until(lambda: rig.watch.last.get("thruster_command", 0.0) > 2.0, "commands over the link")
            rig.wait_until_calm()
            hosts.set_link(up=False)
            cut = rig.time
            rig.sail(CUT)
            # The vessel's side stops the thrusters and says why; it goes on by itself.
            rig.wait_until(lambda: "DRIVERS-COMMAND-STALE" in rig.watch.active["thruster_drivers"], "the alarm")
            last = rig.watch.last["thruster_command"]
            assert last < cut + 2.0  # nothing came through: two samples may have been on their way
            hosts.set_link(up=True)
            restored = rig.time
            rig.wait_until(lambda: rig.watch.last["thruster_command"] > restored, "commands after the cut")
            again = rig.time - restored
            rig.wait_until_calm()
            print(
                f"cut for {restored - cut:.1f} s; commands again after {again:.1f} s, all calm after "
                f"{rig.time - restored:.1f} s of simulated time at {RATE:g} times real time"
            )
