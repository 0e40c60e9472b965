"""Parameters of the five nodes: their files are read, and what is refused changes nothing, at start and live."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterType

from dp_bringup.parameter_file import read_parameter_file
from dp_controller.node import ControllerNode
from dp_node.parameters import describe
from dp_observer.node import ObserverNode
from marine_model.errors import InputError
from marine_model.settings import parameters_of
from support.node_bench import NodeBench, node_bench
from thrust_allocator.node import AllocatorNode
from thruster_drivers.node import DriversNode
from vessel_sim.node import VesselSimNode

pytestmark = pytest.mark.usefixtures("ros_domain_id")

CONFIG = Path(__file__).parents[2] / "src" / "dp_bringup" / "config"
NODES: dict[str, Any] = {
    "vessel_sim": VesselSimNode,
    "dp_observer": ObserverNode,
    "dp_controller": ControllerNode,
    "thrust_allocator": AllocatorNode,
    "thruster_drivers": DriversNode,
}
# A good change of two, and sets that are wrong only together or only for this vessel, with the reason.
GOOD: dict[str, dict[str, Any]] = {
    "vessel_sim": {"waves.amplitude": 0.02, "waves.period": 1.5},
    "dp_observer": {"dead_reckoning_limit": 7.0, "reacceptance_count": 9},
    "dp_controller": {"joystick_timeout": 3.0, "transfer_time": 4.0},
    "thrust_allocator": {"auto.force_limit": 2.0, "auto.hysteresis": 0.3},
    "thruster_drivers": {"antispin.enabled": True, "antispin.thrust_floor": 0.3},
}
INCONSISTENT: dict[str, tuple[dict[str, Any], str]] = {
    "vessel_sim": ({"waves.period": 1.5, "rate": 0.0}, "rate: expected above 0 unless lockstep is on"),
    "dp_controller": ({"transfer_time": 9.0, "tau_max": [1.0, 2.0]}, "tau_max"),
    "thrust_allocator": ({"azimuth_mode": "rotating", "thruster_enabled": [True]}, "thruster_enabled"),
    "thruster_drivers": ({"antispin.enabled": True, "ventilation.enabled": False}, "antispin.enabled must be false"),
}
WRONG = {
    ParameterType.PARAMETER_BOOL: ["yes", 1, 0.5],
    ParameterType.PARAMETER_INTEGER: ["3", 3.5, True, -(2**63)],
    ParameterType.PARAMETER_DOUBLE: ["3.0", True, math.nan, math.inf, -math.inf, [1.0]],
    ParameterType.PARAMETER_STRING: [3, True, "no such choice"],
    ParameterType.PARAMETER_BOOL_ARRAY: [True, [1.0], [True] * 99],
    ParameterType.PARAMETER_DOUBLE_ARRAY: [1.0, [math.nan] * 4, [1.0] * 99, [True]],
}


def shown(bench: NodeBench) -> dict[str, Any]:
    """What the node has for its settings: both the object in force and the parameters that ROS shows."""
    found = {}
    for name, value in parameters_of(bench.node.settings).items():
        parameter = bench.node.get_parameter(name).value
        parameter = tuple(parameter) if isinstance(value, tuple) else parameter
        assert parameter == value, f"{name}: ROS shows {parameter}, in force is {value}"
        found[name] = value
    return found


@pytest.mark.parametrize("name", NODES)
def test_a_node_takes_its_file_and_refuses_everything_else_with_the_reason(name: str) -> None:
    path = CONFIG / f"{name}.yaml"
    with node_bench(partial(NODES[name], cli_args=["--ros-args", "--params-file", str(path)])) as bench:
        before = shown(bench)
        for parameter, value in read_parameter_file(path)[name].items():
            assert before[parameter] == (tuple(value) if isinstance(value, list) else value)
        for parameter in before:
            descriptor = describe(type(bench.node.settings), parameter)
            for value in WRONG[descriptor.type]:
                result = bench.set_parameters(**{parameter: value})
                assert not result.successful, f"{parameter}: {value!r} was taken"
                assert result.reason
        refused = bench.set_parameters(no_such_parameter=1.0)
        assert not refused.successful
        assert "no_such_parameter" in refused.reason
        assert shown(bench) == before, "whatever was refused, nothing has changed"

        wrong = next(p for p in before if "range" in str(describe(type(bench.node.settings), p)))
        good = GOOD[name]
        assert not bench.set_parameters(**{**good, wrong: math.nan}).successful, "all or none"
        assert shown(bench) == before
        # One by one, each is judged for itself: the good ones are taken.
        results = bench.set_one_by_one(**{**good, "no_such_parameter": 1.0})
        assert [result.successful for result in results] == [True] * len(good) + [False]
        after = shown(bench)
        assert {key: value for key, value in after.items() if value != before[key]} == good
        if name in INCONSISTENT:
            values, reason = INCONSISTENT[name]
            result = bench.set_parameters(**values)
            assert not result.successful
            assert reason in result.reason
            assert shown(bench) == after


@pytest.mark.parametrize("name", INCONSISTENT)
def test_a_set_that_does_not_fit_is_refused_at_start_with_the_same_reason(name: str) -> None:
    values, reason = INCONSISTENT[name]
    with (
        pytest.raises(InputError, match=reason),
        node_bench(NODES[name], **{k.replace(".", "__"): v for k, v in values.items()}),
    ):
        pass
