"""Every parameter of every node: described, with a unit and a range, in the file that comes with it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterType
from typer.testing import CliRunner

from dp_bringup.parameter_file import read_parameter_file
from dp_node.parameters import describe, limits, parameter_field
from dp_tools.commands.parameters import parameters_app
from dp_tools.node_settings import changed_settings, declared_settings
from dp_tools.parameter_template import parameter_template
from marine_model import load_vessel
from marine_model.errors import InputError, UnknownNameError
from marine_model.settings import Settings, parameters_of, read_only_parameters

CONFIG = Path(__file__).parents[3] / "src" / "dp_bringup" / "config"
VESSEL = load_vessel("cybership3")
DECLARED = declared_settings(VESSEL)
NAMES = [(node, name) for node, settings in DECLARED.items() for name in parameters_of(settings)]
NUMBERS = {
    ParameterType.PARAMETER_INTEGER,
    ParameterType.PARAMETER_DOUBLE,
    ParameterType.PARAMETER_INTEGER_ARRAY,
    ParameterType.PARAMETER_DOUBLE_ARRAY,
}
REALS = {ParameterType.PARAMETER_DOUBLE, ParameterType.PARAMETER_DOUBLE_ARRAY}


@pytest.mark.parametrize(("node", "name"), NAMES)
def test_a_parameter_has_a_meaning_a_unit_and_a_range(node: str, name: str) -> None:
    model = type(DECLARED[node])
    descriptor, field = describe(model, name), parameter_field(model, name)
    extra: Any = field.json_schema_extra
    assert field.description
    assert len(field.description) > 5
    assert field.description[0].isupper() or field.description.startswith("m "), "m is a symbol"
    if descriptor.type in REALS:
        assert extra["unit"], "a real number has a unit; 1 for a plain one"
    if descriptor.type not in NUMBERS:
        return
    low, _ = limits(field)
    assert low is not None, "a number has a least value"
    shown = [*descriptor.floating_point_range, *descriptor.integer_range]
    assert [one.from_value for one in shown] == [low]


@pytest.mark.parametrize(("node", "name"), NAMES)
def test_a_number_out_of_its_range_or_not_finite_is_refused(node: str, name: str) -> None:
    settings = DECLARED[node]
    descriptor = describe(type(settings), name)
    if descriptor.type not in NUMBERS:
        pytest.skip("not a number")
    low, high = limits(parameter_field(type(settings), name))
    wrong: list[float] = [] if descriptor.type == ParameterType.PARAMETER_INTEGER else [math.nan, math.inf, -math.inf]
    wrong += [
        value for value in (None if low is None else low - 1, None if high is None else high + 1) if value is not None
    ]
    if descriptor.type == ParameterType.PARAMETER_INTEGER:
        wrong = [int(value) for value in wrong]
    present = parameters_of(settings)[name]
    for value in wrong:
        if descriptor.type == ParameterType.PARAMETER_DOUBLE_ARRAY:
            with pytest.raises(InputError, match=name.partition(".")[0]):
                changed_settings(node, settings, {name: [value, *present[1:]]}, VESSEL)
        else:
            with pytest.raises(InputError, match=name.partition(".")[0]):
                changed_settings(node, settings, {name: value}, VESSEL)


@pytest.mark.parametrize("node", DECLARED)
def test_the_file_of_a_node_says_what_the_declarations_say(node: str) -> None:
    text = parameter_template(node, "cybership3", VESSEL)
    assert (CONFIG / f"{node}.yaml").read_text(encoding="utf-8") == text, f"dp param template {node} --output ..."


@pytest.mark.parametrize("vessel", ["cybership3", "drillship", "cybership3_full_scale"])
@pytest.mark.parametrize("node", DECLARED)
def test_a_file_holds_every_default_that_can_change(node: str, vessel: str, tmp_path: Path) -> None:
    model = load_vessel(vessel)
    settings: Settings = declared_settings(model)[node]
    path = tmp_path / "file.yaml"
    result = CliRunner().invoke(parameters_app, ["template", node, "--vessel", vessel, "--output", str(path)])
    assert result.exit_code == 0, result.output
    ((found_node, values),) = read_parameter_file(path).items()
    assert found_node == node
    defaults = {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in parameters_of(settings).items()
        if name not in read_only_parameters(type(settings)) and value not in (None, ())
    }
    assert values == defaults
    assert changed_settings(node, settings, values, model) == settings


def test_the_file_of_an_unknown_node_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"node: expected one of vessel_sim, .*found 'pilot'"):
        parameter_template("pilot", "cybership3", VESSEL)
