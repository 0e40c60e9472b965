"""Lockstep: the same to the bit in five processes and in one, and equal to the loop without middleware."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from dp_tools.bag_reader import bag_file, read_bag
from support.dp_command import dp, own_domain, write_scenario
from support.recordings import differences_from_in_process_loop, messages_by_topic, repeatable

pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The same scenario, sailed by five processes and by one."""
    folder = tmp_path_factory.mktemp("lockstep")
    scenario = write_scenario(folder)
    options: dict[str, tuple[str, ...]] = {"separate": (), "composed": ("--composed",)}
    for name, how in options.items():
        with own_domain() as domain:
            words = ("up", "--scenario", str(scenario), "--lockstep", "--record", "--output", str(folder / name), *how)
            code, output = dp(*words, environment=domain)
        assert code == 0, output
    return {name: folder / name / "bag" for name in options}


def test_five_processes_and_one_send_the_same_bytes(bags: dict[str, Path]) -> None:
    separate, composed = messages_by_topic(bags["separate"]), messages_by_topic(bags["composed"])
    topics = repeatable(separate)
    assert {"/pose", "/odometry", "/tau_desired", "/thruster_command", "/thruster_feedback", "/clock"} < set(topics)
    assert topics == repeatable(composed)
    for topic in topics:
        assert len(separate[topic]) == len(composed[topic]), topic
        first = next(
            (i for i, pair in enumerate(zip(separate[topic], composed[topic], strict=True)) if len(set(pair)) > 1), None
        )
        assert first is None, f"{topic}: message {first} differs"


def test_the_run_has_noise_waves_and_every_event(bags: dict[str, Path]) -> None:
    """So that equal bytes mean something."""
    recorded = read_bag(bags["composed"]).run
    assert len(np.unique(recorded["pose"].values[:, 0])) == 100
    assert np.abs(recorded["wave_position"].values).max() > 0.001
    assert recorded.labels["azimuth_mode"].words == ("fixed", "rotating", "fixed")
    assert np.abs(recorded["reference_position"].values[-1]).max() > 0.05


@pytest.mark.parametrize("how", ["separate", "composed"])
def test_graph_equals_the_loop_without_middleware(bags: dict[str, Path], how: str) -> None:
    """Equal in every bit: the same cores, fed the same doubles in the same order, on one machine."""
    differences = differences_from_in_process_loop(bags[how])
    assert len(differences) > 40
    assert {name: value for name, value in differences.items() if value != 0.0} == {}


# Sectors, limits of power with measured power, and thrusters held or rotating by the demand: each switched on while
# the ring turns; at last a motor and an azimuth motor fail. The allocator begins to listen to thruster_feedback in the
# middle of the run.
SWITCHED_ON = [
    {"at": 0.0, "setpoint": [0.0, 0.0, 0.0]},
    {"at": 1.0, "setpoint": [0.6, 0.4, 0.3]},
    {"at": 3.0, "parameters": {"thrust_allocator": {"sectors.enabled": True, "sectors.dwell_time": 1.0}}},
    {"at": 5.0, "parameters": {"thrust_allocator": {"power.limit": "total", "power.available": 0.2}}},
    {
        "at": 7.0,
        "setpoint": [0.0, 0.0, 0.0],
        "parameters": {
            "thrust_allocator": {
                "power.limit": "both",
                "power.bus_limit": [0.1, 0.1],
                "thruster_enabled": [True, True, True, False],
            }
        },
    },
    {
        "at": 9.0,
        "parameters": {
            "thrust_allocator": {"azimuth_mode": "auto", "auto.force_limit": 8.0, "auto.hysteresis": 0.5}
            | {"auto.dwell_time": 0.5, "auto.filter_frequency": 1.0, "power.limit": "none", "feather_time": 1.0}
            | {"thruster_enabled": [True, True, True, True]}
        },
    },
    {
        "at": 11.0,
        "setpoint": [0.6, 0.4, 0.3],
        "parameters": {
            "vessel_sim": {
                "propulsion.failed": [True, False, False, False],
                "propulsion.azimuth_failed": [False, False, True, False],
            },
            "thrust_allocator": {"azimuth_mode": "rotating"},
        },
    },
    {
        "at": 12.0,
        "parameters": {
            "thrust_allocator": {
                "thruster_enabled": [False, True, True, True],
                "azimuth_enabled": [True, True, False, True],
            }
        },
    },
]


@pytest.mark.timeout(120)
def test_what_the_allocator_is_told_while_running_is_the_same_without_middleware(tmp_path: Path) -> None:
    scenario = write_scenario(tmp_path, 14.0, events=SWITCHED_ON, parameters={
        "vessel_sim": {"waves.amplitude": 0.02, "waves.period": 0.9, "waves.direction": 2.8},
        "dp_controller": {"mode": "setpoint"},
        "thrust_allocator": {"azimuth_mode": "rotating"},
    })  # fmt: skip
    with own_domain() as domain:
        words = ("up", "--scenario", str(scenario), "--lockstep", "--record", "--output", str(tmp_path / "run"))
        code, output = dp(*words, environment=domain)
    assert code == 0, output
    bag = tmp_path / "run" / "bag"
    with bag_file(bag).open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = [status for *_, status in reader.iter_decoded_messages(topics=["/allocation_status"])]
    assert len(found) == 70
    # So that equality means something: every part had its say.
    assert any(any(status.crossing) for status in found)
    assert {status.power_stage for status in found} > {"", "within"}
    assert any(any(status.bus_limited) for status in found)
    assert {status.azimuth_mode for status in found[45:]} == {"fixed", "rotating"}
    differences = differences_from_in_process_loop(bag)
    assert {name: value for name, value in differences.items() if value != 0.0} == {}
