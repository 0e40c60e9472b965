"""`dp compare`: what it prints, what it writes, what it refuses."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from dp_tools.compare.page import parts, render
from dp_tools.compare.plots import drawings
from dp_tools.compare.study import compare_vessel, groups_to_compare
from dp_tools.report.style import plot_style
from support.dp_here import Dp, dp_here
from support.marching_thruster import driven_vessel

__all__ = ["dp_here"]


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


def test_tables_and_files(dp_here: Dp, tmp_path: Path) -> None:
    code, output = dp_here("compare", "ukwial_azimuth", "--demands", "60")
    folder = tmp_path / "compare" / "ukwial_azimuth"
    assert code == 0, output
    assert output.rstrip().endswith(f"written {folder}")
    assert (
        "[Garus-F] has (3.1) as 'if and only if'. It is not: the octahedron has 0.6667 of the attainable volume"
        in output
    )
    assert "One axis by itself: all sets are the same" in output
    assert re.search(r"asteroid, \(17\) .* 0\.7157 .* 501\.0, −85\.89 N .* 29\.1°", output)
    assert re.search(r"at one common angle, any thrusts .* 1\.154e\+06 .* 0\.5744", output)
    names = ["asteroid.png", "compare.html", "compare.json", "sections_1.png", "sets_1.png"]
    assert sorted(path.name for path in folder.iterdir()) == names
    for picture in folder.glob("*.png"):
        assert picture.read_bytes().startswith(b"\x89PNG")
    page = (folder / "compare.html").read_text(encoding="utf-8")
    assert page.count('<img src="data:image/svg+xml;base64,') == 3
    # Self-contained: nothing is fetched.
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)
    for heading in (
        "Surge, sway, yaw (azimuth thrusters along their fixed directions)",
        "Heave",
        "Four azimuth propellers",
    ):
        assert heading in page
    content = json.loads((folder / "compare.json").read_text(encoding="utf-8"))
    assert (content["vessel"], content["demands"], content["seed"]) == ("ukwial_azimuth", 60, 1)
    assert content["groups"][0]["volumes"]["printed"] / content["groups"][0]["volumes"]["exact"] == pytest.approx(2 / 3)
    assert content["azimuth"]["cases"][1]["needed_at"] == pytest.approx(937.0, abs=0.5)
    assert (content["portions"], content["drives"]) == (None, [])


def test_page_of_a_cross_with_drives() -> None:
    vessel = driven_vessel()
    done: list[int] = []
    comparison = compare_vessel(vessel, groups_to_compare(vessel, 30, 3), 30, 3, done.append)
    assert sum(done) == 30
    assert [part.name for part in parts(comparison)] == ["group-1", "portions", "speed-1"]
    with plot_style():
        drawn = [one for one in drawings(comparison) if one.name in ("portions", "speed_1")]
        page = render(comparison, drawn)
    assert len(drawn) == 2
    assert page.count("<img") == 2
    # Lines of the picture are the numbers: without compensation at the right end, demanded T_max.
    right = drawn[1].figure.axes[1]
    without = {line.get_label(): line for line in right.lines}["without, (7), Table 2"]
    np.testing.assert_array_equal(without.get_ydata(), comparison.speeds[0].at_top["map", False])
    assert "At 2 m/s 24.8 N fall short by 14.78 N by Table 2" in page
    assert "Drive of upper and others" in page
    assert "pitch of 65.75 N m needs 1.136 times the thrust there is" in page


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("titanic",), r"error: vessel: expected a path or one of .*found 'titanic'"),
        (("ukwial", "--demands", "0"), r"error: --demands: expected 1 or more, found 0"),
        (("ukwial", "--seed", "-1"), r"error: --seed: expected 0 or more, found -1"),
        (("ukwial", "--output", "a_file/folder"), r"error: .*a_file/folder: cannot be written: Not a directory"),
    ],
)
def test_refusals(dp_here: Dp, tmp_path: Path, words: tuple[str, ...], message: str) -> None:
    (tmp_path / "a_file").touch()
    code, output = dp_here("compare", *words)
    assert code == 1
    assert re.fullmatch(message, output.strip()), output
    assert [path.name for path in tmp_path.iterdir()] == ["a_file"]
