"""Values and files as `dp param` reads and writes them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import ParameterType

from dp_bringup.parameter_file import read_parameter_file, to_parameter_file
from dp_bringup.parameter_service import _fit
from marine_model.errors import DocumentError
from marine_model.yaml_document import parse_value

NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
VALUES = st.one_of(
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    NUMBERS,
    st.text(st.characters(codec="utf-8", exclude_categories=("C",)), max_size=12),
    st.lists(st.booleans(), max_size=4),
    st.lists(NUMBERS, max_size=4),
)


@given(st.dictionaries(NAMES, st.dictionaries(NAMES, VALUES, min_size=1, max_size=4), min_size=1, max_size=3))
def test_what_was_written_is_read_again(tmp_path_factory: pytest.TempPathFactory, values: dict[str, Any]) -> None:
    path = tmp_path_factory.mktemp("parameters") / "file.yaml"
    path.write_text(to_parameter_file(values), encoding="utf-8")
    found = read_parameter_file(path)
    assert found == values
    assert repr(found) == repr(values), "types and all bits"


def test_files_are_in_the_format_of_ros() -> None:
    text = to_parameter_file({"vessel_sim": {"waves.amplitude": 0.06, "seed": 1}})
    assert yaml.safe_load(text) == {"/**/vessel_sim": {"ros__parameters": {"waves.amplitude": 0.06, "seed": 1}}}


def test_groups_and_namespaces_of_other_tools_are_understood(tmp_path: Path) -> None:
    path = tmp_path / "file.yaml"
    path.write_text(
        "/ship/vessel_sim:\n  ros__parameters:\n    waves: {amplitude: 0.1}\n    seed: 3\n", encoding="utf-8"
    )
    assert read_parameter_file(path) == {"vessel_sim": {"waves.amplitude": 0.1, "seed": 3}}


@pytest.mark.parametrize("content", ["vessel_sim: {seed: 1}", "vessel_sim: 3", "vessel_sim:\n  ros__parameters: 3"])
def test_a_file_of_another_structure_is_refused_with_file_and_line(tmp_path: Path, content: str) -> None:
    path = tmp_path / "file.yaml"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(DocumentError, match=r"file\.yaml:1: vessel_sim.*: expected one mapping ros__parameters"):
        read_parameter_file(path)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("3", 3),
        ("-0.5", -0.5),
        ("1.0e-3", 0.001),
        ("[1.0, 2.0]", [1.0, 2.0]),
        ("[true, false]", [True, False]),
        ("rotating", "rotating"),
        ("'3'", "3"),
        ("[broken", "[broken"),
    ],
)
def test_words_of_the_command_line(text: str, value: Any) -> None:
    found = parse_value(text)
    assert found == value
    assert type(found) is type(value)


def test_not_a_number_is_for_the_node_to_refuse() -> None:
    assert math.isnan(parse_value(".nan"))


@pytest.mark.parametrize(
    ("value", "kind", "fitted"),
    [
        (2, ParameterType.PARAMETER_DOUBLE, 2.0),
        ([1, 2.5], ParameterType.PARAMETER_DOUBLE_ARRAY, [1.0, 2.5]),
        ((True, False), ParameterType.PARAMETER_BOOL_ARRAY, [True, False]),
        # Everything else is the node's to judge.
        (True, ParameterType.PARAMETER_DOUBLE, True),
        ("2", ParameterType.PARAMETER_DOUBLE, "2"),
        (2.0, ParameterType.PARAMETER_INTEGER, 2.0),
    ],
)
def test_a_whole_number_does_for_a_real_one_and_nothing_else(value: Any, kind: int, fitted: Any) -> None:
    found = _fit(value, kind)
    assert found == fitted
    assert type(found) is type(fitted)
