"""Rows of results.json: ratio, aim and schema."""

import json
import math
from pathlib import Path

import pytest

from benchmarks.result import Aim, Result, write_results

AT_LEAST = Aim("value", ">=", 8.0)
NEAR_PEER = Aim("ratio", "<=", 1.5)


@pytest.mark.parametrize(("value", "met"), [(7.9, False), (8.0, True), (9.0, True)])
def test_aim_at_the_value(value: float, met: bool) -> None:
    assert Result("factor", value, "x real time", aim=AT_LEAST).met is met


@pytest.mark.parametrize(("value", "met"), [(300.0, True), (301.0, False)])
def test_aim_at_the_ratio(value: float, met: bool) -> None:
    result = Result("hop", value, "us", "echo", 200.0, NEAR_PEER)
    assert result.ratio == value / 200.0
    assert result.met is met


def test_without_the_peers_value_an_aim_at_the_ratio_is_not_met() -> None:
    result = Result("hop", 300.0, "us", "not measured: no such package", None, NEAR_PEER)
    assert result.ratio is None
    assert result.met is False


def test_without_an_aim_nothing_is_met_or_missed() -> None:
    assert Result("start_up", 3.0, "s").met is None


@pytest.mark.parametrize(("value", "peer"), [(math.nan, 1.0), (1.0, math.inf)])
def test_a_figure_that_is_not_finite_is_refused(value: float, peer: float) -> None:
    with pytest.raises(ValueError, match=r"hop\.(value|peer_value): expected a finite number"):
        Result("hop", value, "us", "echo", peer)


def test_the_file_has_every_field_of_every_row(tmp_path: Path) -> None:
    file = tmp_path / "new" / "results.json"
    write_results(file, [Result("hop", 300.0, "us", "echo", 200.0, NEAR_PEER, "a note"), Result("start_up", 3.0, "s")])
    assert json.loads(file.read_text(encoding="utf-8")) == [
        {
            "name": "hop",
            "value": 300.0,
            "unit": "us",
            "peer": "echo",
            "peer_value": 200.0,
            "ratio": 1.5,
            "aim": "ratio <= 1.5",
            "met": True,
        },
        {
            "name": "start_up",
            "value": 3.0,
            "unit": "s",
            "peer": None,
            "peer_value": None,
            "ratio": None,
            "aim": None,
            "met": None,
        },
    ]
