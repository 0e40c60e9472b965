"""`dp vessel`: list, check, scale."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from marine_model.load import vessel_names, vessel_path
from support.dp_here import Dp, dp_here

__all__ = ["dp_here"]


@pytest.mark.parametrize("model", ["cybership3", "cybership3_trimmed"])
def test_full_scale_vessel_is_what_its_command_makes(dp_here: Dp, model: str) -> None:
    shipped = vessel_path(f"{model}_full_scale").read_text(encoding="utf-8")
    first = shipped.splitlines()[0]
    assert first.startswith(f"# Made by: dp vessel scale {model} 30 ")
    code, output = dp_here(*shlex.split(first.removeprefix("# Made by: dp ")))
    assert code == 0
    assert output == shipped


def test_a_file_is_written_and_checked(dp_here: Dp, tmp_path: Path) -> None:
    path = tmp_path / "half.yaml"
    code, output = dp_here("vessel", "scale", "cybership3_trimmed", 0.5, "--output", path)
    assert code == 0, output
    assert output.split() == ["vessel", str(path)]
    assert dp_here("vessel", "check", path) == (0, "cybership3_trimmed_0_5: valid, 4 thrusters, 0.985 m\n")


def test_every_vessel_is_listed(dp_here: Dp) -> None:
    code, output = dp_here("vessel", "list")
    assert code == 0
    for name in vessel_names():
        assert f" {name} " in output


def test_what_is_wrong_is_said(dp_here: Dp, tmp_path: Path) -> None:
    for words, message in (
        (("scale", "cybership3", 0.0), "length_ratio: expected a number above 0"),
        (("scale", "cybership9", 2.0), "vessel: expected a path or one of"),
        (("scale", "cybership3", 2.0, "--output", tmp_path / "no" / "x.yaml"), "cannot be written: No such file"),
    ):
        code, output = dp_here("vessel", *words)
        assert code == 1
        assert message in output
