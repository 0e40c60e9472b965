"""`dp open-water` and `dp detection`: what they print, what they write, what they refuse."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from dp_tools.detection_report.campaigns import confusion, run_campaigns
from marine_model import load_vessel
from marine_model.load import vessel_path
from support.dp_here import Dp, dp_here
from support.open_water_files import TRIALS, VENTILATION, small_trial, write_trial

__all__ = ["dp_here"]


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def share(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An install prefix whose ament index holds dp_bringup with two trials."""
    index = tmp_path / "share" / "ament_index" / "resource_index" / "packages"
    folder = tmp_path / "share" / "dp_bringup" / "open_water"
    index.mkdir(parents=True)
    folder.mkdir(parents=True)
    (index / "dp_bringup").touch()
    for name in ("anti_spin", "section_3_7"):
        (folder / f"{name}.yaml").write_bytes((TRIALS / f"{name}.yaml").read_bytes())
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))


@pytest.mark.usefixtures("share")
def test_list_and_check(dp_here: Dp) -> None:
    code, output = dp_here("open-water", "list")
    assert code == 0
    assert re.search(r"anti_spin .* Power control with and without low-level anti-spin .* 120 ", output)
    assert re.search(r"section_3_7 .* 220 .* \[Ruth\] 3\.7, Table 3\.4", output)
    assert dp_here("open-water", "check", "section_3_7") == (0, "section_3_7: valid, 4 cases of 220 s\n")
    code, output = dp_here("open-water", "run", "section_3_8")
    assert code == 1
    assert "trial: expected a path or one of anti_spin, section_3_7, found 'section_3_8'" in output


def test_run_writes_everything(dp_here: Dp, tmp_path: Path) -> None:
    document = small_trial()
    document["figures"][0].update(thesis=1.0, source="[Ruth] nowhere", reason="A reason.")
    document["sweep"] = {
        "kind": "mean_power",
        "window": [1.0, 2.0],
        "thesis": [1.0, 1.1],
        "source": "[Ruth] there",
        "variants": [{"title": "half", "thrust": {"mean": 100.0}}],
    }
    path = write_trial(tmp_path, document)
    code, output = dp_here("open-water", "run", path)
    assert code == 0
    folder = tmp_path / "open_water" / "small"
    assert output.rstrip().endswith(f"written {folder}")
    assert re.search(r"Corrected mean power .* W .* W", output)
    assert "Beside the thesis" in output
    numbers = json.loads((folder / "open_water.json").read_text(encoding="utf-8"))
    table, (figure,) = numbers["table"], numbers["figures"]
    assert set(table["cases"]) == {"speed", "power"}
    assert figure["unit"] == "1"
    assert figure["thesis"] == 1.0
    assert re.search(rf"Power .* {figure['value']:.3f} .* 1\.000 ", output)
    assert numbers["sweep"]["ratios"]["half"][0] == 1.0
    with (folder / "series.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 20
    assert [float(row["time_s"]) for row in rows] == pytest.approx(np.arange(1, 21) * 0.1)
    # In a steady current power control holds P_d, and the figure is P over the speed controller's.
    last = {name: float(rows[-1][f"{name}.power_W"]) for name in ("speed", "power")}
    assert last["power"] / last["speed"] == pytest.approx(figure["value"], rel=1e-3)
    page = (folder / "open_water.html").read_text(encoding="utf-8")
    assert "A reason. ([Ruth] nowhere)" in page
    assert '<td class="title">half</td>' in page
    assert page.count("data:image/svg+xml;base64,") == 1
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)
    assert (folder / "open_water.png").read_bytes().startswith(b"\x89PNG")


def test_page_of_a_propeller_that_ventilates(dp_here: Dp, tmp_path: Path) -> None:
    document = small_trial()
    document["ventilation"] = VENTILATION
    document["submergence_ratio"] = {"mean": 1.0, "amplitude": 1.0, "period": 2.0}
    document["close_up"] = "all"
    folder = tmp_path / "made" / "here"
    code, _ = dp_here("open-water", "run", write_trial(tmp_path, document), "--output", folder)
    assert code == 0
    page = (folder / "open_water.html").read_text(encoding="utf-8")
    assert page.count("data:image/svg+xml;base64,") == 3  # the run, the close up, the conditions
    head = (folder / "series.csv").read_text(encoding="utf-8").splitlines()[0]
    assert head.startswith("time_s,advance_speed_m_per_s,submergence_ratio,speed.thrust_demanded_N,")


def test_refusals(dp_here: Dp, tmp_path: Path) -> None:
    document = small_trial()
    document["duration"] = -1.0
    code, output = dp_here("open-water", "run", write_trial(tmp_path, document))
    assert code == 1
    assert re.search(r"error: .*trial\.yaml:\d+: duration: Input should be greater than 0, found -1\.0", output)
    (tmp_path / "file").touch()
    code, output = dp_here("open-water", "run", write_trial(tmp_path, small_trial()), "--output", tmp_path / "file")
    assert code == 1
    assert "cannot be written" in output


def test_a_ratio_to_nothing_is_refused(dp_here: Dp, tmp_path: Path) -> None:
    document = small_trial()
    document["thrust"] = {"mean": 0.0}
    document["inflow"] = {}
    code, output = dp_here("open-water", "run", write_trial(tmp_path, document))
    assert code == 1
    assert "error: corrected_mean_power of case 'speed' in window 'all': expected a finite number, found nan" in output
    document["table"]["kinds"] = ["mean_power"]
    code, output = dp_here("open-water", "run", write_trial(tmp_path, document))
    assert code == 1
    assert "error: figures.ratio: expected a case 'speed' with more than 0, found 0.0" in output


def test_detection(dp_here: Dp, tmp_path: Path) -> None:
    code, output = dp_here("detection", "cybership3", "--duration", "120", "--seed", "2")
    assert code == 0
    folder = tmp_path / "detection" / "cybership3"
    numbers = json.loads((folder / "detection.json").read_text(encoding="utf-8"))
    results = run_campaigns(load_vessel("cybership3"), 120.0, 2)
    for (method, written), result in zip(numbers["methods"].items(), results, strict=True):
        assert method == result.ventilation.method
        assert written["rows"] == dict(confusion(result))
        assert written["delays"] == result.ventilation.delays.tolist()
        assert int(written["rows"]["Events longer than 0.5 s"]) == result.ventilation.events > 10
        assert len(written["delays"]) == int(written["rows"]["found before they ended"])
    assert re.search(rf"Events longer than 0\.5 s .* {results[0].ventilation.events} ", output)
    page = (folder / "detection.html").read_text(encoding="utf-8")
    assert page.count("data:image/svg+xml;base64,") == 2
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)


def test_detection_needs_its_section(dp_here: Dp, tmp_path: Path) -> None:
    document: dict[str, Any] = yaml.safe_load(vessel_path("cybership3").read_text(encoding="utf-8"))
    del document["drivers"]["ventilation"]
    path = tmp_path / "dry.yaml"
    path.write_text(yaml.safe_dump(document), encoding="utf-8")
    code, output = dp_here("detection", path, "--duration", "60")
    assert code == 1
    assert "drivers.ventilation: expected this section in vessel 'cybership3', found none" in output
