"""`dp design`: what it prints, what it writes, what it refuses."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from marine_model.load import vessel_path
from support.dp_here import Dp, dp_here

__all__ = ["dp_here"]


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def tugboat(tmp_path: Path) -> Path:
    """CyberShip III with tunnel and bow azimuth only."""
    document: dict[str, Any] = yaml.safe_load(vessel_path("cybership3").read_text(encoding="utf-8"))
    document["name"] = "tugboat"
    document["thrusters"] = document["thrusters"][:2]
    del document["power"]
    document["allocator"]["thrust_weight"] = [14.0, 1.2]
    document["drivers"]["ventilation"]["speed_min"] = 50.0
    path = tmp_path / "tugboat.yaml"
    path.write_text(yaml.safe_dump(document), encoding="utf-8")
    return path


def test_tables_and_the_best_split(dp_here: Dp, tmp_path: Path) -> None:
    code, output = dp_here("design", "cybership3_ch7", "--azimuth-degrees", "35,-45,45")
    assert code == 0
    assert re.search(r"1 2 3 4 .* 3 .* 1\.20 .* 1\.73", output)
    assert re.search(r"2 3 4 .* - tunnel bow .* 3 .* 1\.19 .* 1\.21", output)
    assert "Best split with equal thrusts: 1 3 | 2 4 or 1 4 | 2 3, minimum gain 0.99 after the loss of either" in output
    assert "Loss of bus_a, as the vessel file has it: leaves 2 4, minimum gain 1.17, 1.19 with equal" in output
    assert "Lemma 7.2 as printed 6.00, without its 1/√2 8.48, exact 12.32 (12.46 if" in output
    assert "fixed at 90, 35, -45, 45 deg (Table 7.1)" in output
    assert re.search(r"1 2 3 .* - azimuth starboard .* 0\.68", output)
    # Without a folder nothing is written.
    assert list(tmp_path.iterdir()) == []


def test_files(dp_here: Dp, tmp_path: Path) -> None:
    folder = tmp_path / "made" / "here"
    code, output = dp_here("design", "cybership3_ch7", "--map", "--output", folder)
    assert code == 0
    assert output.rstrip().endswith(f"written {folder}")
    content = json.loads((folder / "design.json").read_text(encoding="utf-8"))
    assert content["freely_rotating"]["combinations"][0]["gain"] == pytest.approx(1.20, abs=0.01)
    best = [split["buses"] for split in content["freely_rotating"]["splits"] if split["equal_best"]]
    assert best == [[[1, 3], [2, 4]], [[1, 4], [2, 3]]]
    assert len(content["maps"]) == 13
    for one in content["maps"]:
        picture = (folder / one["file"]).read_bytes()
        assert picture.startswith(b"\x89PNG")
        with (folder / one["file"]).with_suffix(".csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == 73 * 73
        assert max(float(row["gain"]) for row in rows) == pytest.approx(one["largest_gain"], abs=1e-6)
    for name in ("gains.png", "attainable.png", "maps.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")
    with (folder / "splits.csv").open(encoding="utf-8") as file:
        assert [row["buses"] for row in csv.DictReader(file)][:2] == ["1 3 | 2 4", "1 4 | 2 3"]
    with (folder / "fixed.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 15


def test_a_vessel_of_ones_own(dp_here: Dp, tugboat: Path, tmp_path: Path) -> None:
    folder = tmp_path / "tugboat"
    code, output = dp_here("design", tugboat, "--azimuth-degrees", "-20", "--output", folder)
    assert code == 0
    assert "Best split with equal thrusts: none; whichever way, one bus alone cannot produce every force" in output
    assert json.loads((folder / "design.json").read_text(encoding="utf-8"))["maps"] == []


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("titanic",), r"error: vessel: expected a path or one of .*found 'titanic'"),
        (("no/ship.yaml",), r"error: vessel: no such file: no/ship\.yaml"),
        (("--azimuth-degrees", "1,2"), r"error: --azimuth-degrees: expected 3 numbers .* found '1,2'"),
        (("--azimuth-degrees", "1,2,ahead"), r"error: --azimuth-degrees: expected 3 numbers .* found '1,2,ahead'"),
        (("--azimuth-degrees", "1,2,nan"), r"error: --azimuth-degrees: expected 3 numbers .* found '1,2,nan'"),
        (("--output", "a_file/folder"), r"error: .*a_file/folder: cannot be written: Not a directory"),
    ],
)
def test_refusals(dp_here: Dp, tmp_path: Path, words: tuple[str, ...], message: str) -> None:
    (tmp_path / "a_file").touch()
    code, output = dp_here("design", *words)
    assert code == 1
    assert re.fullmatch(message, output.strip()), output
    assert [path.name for path in tmp_path.iterdir()] == ["a_file"]


def test_a_map_needs_two_azimuth_thrusters(dp_here: Dp, tugboat: Path, tmp_path: Path) -> None:
    code, output = dp_here("design", tugboat, "--map")
    assert (code, output) == (
        1,
        "error: map: expected at least two azimuth thrusters to turn, found 1 on tugboat\n",
    )
    assert list(tmp_path.iterdir()) == [tugboat]
