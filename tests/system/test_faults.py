"""What `dp up` does when a process dies, somebody interrupts it, or there is no room for the recording."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest
from dp_msgs.msg import ThrusterFeedback

from dp_bringup.operator_node import operator
from dp_node import RING
from dp_tools.bag_reader import bag_file, read_bag
from dp_tools.recorder.bag_writer import BagWriter
from support.dp_command import DpProcess, dp, write_scenario

pytestmark = [pytest.mark.timeout(240), pytest.mark.usefixtures("ros_domain_id")]

NODES = ("vessel_sim", "dp_observer", "dp_controller", "thrust_allocator", "thruster_drivers")


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    """Longer than any test waits; nothing happens in it."""
    return write_scenario(tmp_path, 3600.0, events=[{"at": 0.0, "setpoint": [0.1, 0.0, 0.0]}])


def up(scenario: Path, *more: str | Path, **options: Any) -> DpProcess:
    # Paced, so that the test need not hurry.
    return DpProcess(
        *("up", "--scenario", scenario, "--lockstep", "--rate", "5", "--record", "--output", scenario.parent / "run"),
        *more,
        **options,
    )


def wait_until_under_way(process: DpProcess) -> dict[str, Any]:
    """Wait until 2 s have been sailed, as anybody in the ROS domain can see; return the processes."""
    with operator() as listener:
        heard: list[ThrusterFeedback] = []
        listener.node.create_subscription(ThrusterFeedback, "thruster_feedback", heard.append, RING)

        def sails() -> bool:
            listener.executor.spin_once(timeout_sec=0.05)
            return len(heard) >= 100

        process.wait_until(sails, "2 s to be sailed")
    return process.children()


def check_bag(folder: Path) -> None:
    """The recording is closed, and whole up to where it ends."""
    assert {path.name for path in folder.iterdir()} == {"bag_0.mcap", "metadata.yaml"}
    run = read_bag(folder).run
    assert len(run["power"].t) > 50
    assert len(run["tau_achieved"].t) > 5


@pytest.mark.parametrize("node", ["vessel_sim", "dp_controller", "thruster_drivers"])
def test_a_node_that_is_killed_stops_the_run_and_is_named(scenario: Path, node: str) -> None:
    with up(scenario) as process:
        children = wait_until_under_way(process)
        assert set(children) == {*NODES, "recorder"}
        children[node].send_signal(signal.SIGKILL)
        assert process.wait() == 1
        assert f"error: {node} ended by itself (killed by SIGKILL)" in process.output
        assert "Traceback" not in process.output
        assert process.left_behind() == []
    check_bag(scenario.parent / "run" / "bag")


@pytest.mark.parametrize("when", ["start", "event"])
def test_what_a_node_would_refuse_is_refused_before_anything_starts(when: str, tmp_path: Path) -> None:
    """The vessel has four thrusters."""
    refused = {"thrust_allocator": {"thruster_enabled": [True, True]}}
    how = {"events": [], "parameters": refused} if when == "start" else {"events": [{"at": 1.0, "parameters": refused}]}
    scenario = write_scenario(tmp_path, 4.0, **how)
    code, output = dp("up", "--scenario", scenario, "--lockstep", "--composed", "--output", tmp_path / "run")
    assert code == 1
    where = "parameters" if when == "start" else "events.0.parameters"
    assert f"{where}.thrust_allocator" in output
    assert "thruster_enabled: expected 4 elements" in output
    assert not (tmp_path / "run" / "logs").exists()


@pytest.mark.parametrize(
    ("number", "how", "processes"),
    [(signal.SIGINT, (), {*NODES, "recorder"}), (signal.SIGTERM, ("--composed",), {"composed", "recorder"})],
)
def test_an_interrupt_leaves_a_whole_recording_and_no_process(
    scenario: Path, number: signal.Signals, how: tuple[str, ...], processes: set[str]
) -> None:
    with up(scenario, *how) as process:
        assert set(wait_until_under_way(process)) == processes
        process.signal(number)
        assert process.wait() == 130
        assert "interrupted; every process is stopped" in process.output
        assert f"{scenario.parent}/run/bag" in process.output
        assert "Traceback" not in process.output
        assert process.left_behind() == []
    check_bag(scenario.parent / "run" / "bag")


def test_an_interrupt_while_nodes_are_starting(scenario: Path) -> None:
    with up(scenario) as process:
        process.wait_until(lambda: len(process.children()) == 6, "processes to start")
        process.signal(signal.SIGINT)
        # Who is impatient asks again.
        process.wait_until(lambda: len(process.children()) < 6, "the stop")
        process.signal(signal.SIGINT)
        assert process.wait() == 130, process.output
        assert process.left_behind() == []


# Recording -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def small_disk(tmp_path: Path) -> tuple[str | Path, ...]:
    """A prefix that runs a command with 2 MiB of room under ``run``, and moves what is there to ``kept`` in the end."""
    (tmp_path / "run").mkdir()
    mount = ("unshare", "-Urm", "sh", "-c", 'mount -t tmpfs -o size=2m tmpfs "$0" || exit 99; "$@"; code=$?; ')
    try:
        possible = subprocess.run([*mount, tmp_path / "run", "true"], check=False, capture_output=True).returncode == 0
    except FileNotFoundError:
        possible = False
    if not possible:
        pytest.skip("a file system of our own needs unshare and user namespaces")
    return (*mount[:-1], mount[-1] + f'cp -r "$0" "{tmp_path}/kept"; exit $code', tmp_path / "run")


def test_a_disk_that_fills_up_stops_the_recording_not_the_run_and_leaves_a_readable_bag(
    tmp_path: Path, small_disk: tuple[str | Path, ...]
) -> None:
    # Long enough for several times what the disk takes.
    scenario = write_scenario(tmp_path, 120.0, events=[{"at": 0.0, "setpoint": [0.1, 0.0, 0.0]}])
    with up(scenario, "--composed", "--rate", "0", prefix=small_disk) as process:
        assert process.wait() == 1
        # At once, and again in the end.
        now, _, later = process.output.partition("the graph sails on without a recording")
        assert "bag_0.mcap: recording stopped: No space left on device" in now
        assert "120 of 120 s" in later
        assert "error: recorder stopped with exit code 1" in later
        assert "Traceback" not in process.output
        assert process.left_behind() == []
    check_bag(scenario.parent / "kept" / "bag")
    assert read_bag(scenario.parent / "kept" / "bag").run["power"].t[-1] < 110.0


def test_no_room_for_a_recording_is_said_before_a_node_starts(scenario: Path) -> None:
    def no_file_beyond_half_a_mebibyte() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 19, 1 << 19))

    # The recorder reserves 1 MiB to close the bag.
    with up(scenario, before=no_file_beyond_half_a_mebibyte) as process:
        assert process.wait() == 1
        assert f"{scenario.parent}/run/bag: cannot be written: File too large" in process.output
    assert not (scenario.parent / "run" / "logs" / "vessel_sim.log").exists()
    assert not (scenario.parent / "run" / "bag").exists()


def test_a_folder_that_cannot_be_written(scenario: Path) -> None:
    (scenario.parent / "run").write_text("a file", encoding="utf-8")
    code, output = dp("up", "--scenario", scenario, "--record", "--output", scenario.parent / "run")
    assert code == 1
    assert output.splitlines() == [f"error: {scenario.parent}/run: cannot be written: File exists"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(scenario: Path) -> None:
    scenario.parent.chmod(0o500)
    try:
        code, output = dp("up", "--scenario", scenario, "--record", "--output", scenario.parent / "run")
    finally:
        scenario.parent.chmod(0o700)
    assert code == 1
    assert output.splitlines() == [f"error: {scenario.parent}/run: cannot be written: Permission denied"]


def test_an_existing_recording_is_kept_unless_asked_for(tmp_path: Path) -> None:
    BagWriter(tmp_path / "run" / "bag").close()
    file = bag_file(tmp_path / "run" / "bag")
    before = file.read_bytes()
    scenario = write_scenario(tmp_path, 1.0, events=[])
    options = ("up", "--scenario", scenario, "--lockstep", "--composed", "--record", "--output", tmp_path / "run")
    code, output = dp(*options)
    assert code == 1
    assert output.splitlines() == [
        f"error: {tmp_path}/run/bag: holds a recording; choose another --output, or --overwrite it"
    ]
    assert file.read_bytes() == before
    code, output = dp(*options, "--overwrite")
    assert code == 0, output
    assert len(read_bag(file).run["power"].t) == 50
