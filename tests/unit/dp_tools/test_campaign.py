"""`dp scenario run --inprocess` and the table of all runs, on short scenarios."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path
from typing import Any

import psutil
import pytest
import yaml

from dp_tools.bag_reader import read_bag
from dp_tools.campaign.fingerprint import fingerprint
from dp_tools.campaign.index import find_entries
from dp_tools.campaign.order import Order, Outcome
from dp_tools.campaign.plan import plan
from dp_tools.campaign.summary import read_summary
from dp_tools.campaign.workers import RunFailedError, fill_all
from dp_tools.run_folder import FolderError
from marine_model import load_vessel
from marine_model.errors import DocumentError, InputError, UnknownNameError
from support.dp_command import DpProcess, dp, write_scenario
from support.dp_here import Dp, dp_here

__all__ = ["dp_here"]

pytestmark = pytest.mark.timeout(300)

FIGURES: list[dict[str, Any]] = [
    {"name": "power", "kind": "mean_power", "title": "Mean power", "window": "end", "at_least": 0.001},
    {"name": "printed", "kind": "mean_power", "title": "Printed", "window": "end", "thesis": 1e6, "reason": "made up"},
    {"name": "silent", "kind": "mean_power", "title": "No reason", "window": "end", "thesis": 1e6},
    {"name": "never", "kind": "limit_violation_count", "title": "Broken limits", "at_most": 0},
]  # fmt: skip


def _write(folder: Path, name: str, duration: float = 8.0, **fields: Any) -> Path:
    given = {"events": [{"at": 0.0, "setpoint": [0.2, 0.0, 0.0]}], "windows": {"end": [2.0, duration]}}
    written = write_scenario(folder, duration, **(given | {"name": name, "figures": FIGURES} | fields))
    return written.rename(folder / f"{name}.yaml")


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int, str]:
    """Two scenarios, three seeds, two processes; one more that cannot be sailed to its end."""
    folder = tmp_path_factory.mktemp("campaign")
    # Detection is not in this vessel: known only when anti-spin first asks for it.
    asks = {"at": 4.0, "parameters": {"thrust_allocator": {"antispin.enabled": True}}}
    broken = _write(folder, "broken", events=[asks], vessel=_blind(folder))
    files = [_write(folder, "first"), _write(folder, "second", duration=10.0), broken]
    code, output = dp(
        *("scenario", "run", *files, "--inprocess", "--repeat", "3", "--jobs", "2", "--output", folder / "runs")
    )
    return folder / "runs", code, output


def _blind(folder: Path) -> str:
    """Write a vessel whose drivers do not look for ventilation and return its file's name."""
    content = load_vessel("cybership3").model_dump(mode="json")
    content["drivers"]["ventilation"] = None
    (folder / "blind.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    return "blind.yaml"


def test_one_run_that_fails_is_told_and_the_others_go_on(sailed: tuple[Path, int, str]) -> None:
    folder, code, output = sailed
    assert code == 1
    for seed in (7, 8, 9):
        assert f"broken, seed {seed}: at 4.000 s: thrust_allocator waits for ventilation" in output
    assert read_summary(folder / "first" / "seeds.json").seeds == (7, 8, 9)
    assert read_summary(folder / "broken" / "seeds.json").seeds == ()
    assert [seed for seed, _ in read_summary(folder / "broken" / "seeds.json").failures] == [7, 8, 9]


def test_the_first_seed_leaves_everything_the_others_their_figures(sailed: tuple[Path, int, str]) -> None:
    folder, _, output = sailed
    for name in ("first", "second"):
        assert {path.name for path in (folder / name).iterdir()} == {"bag", "report.html", "figures.json", "seeds.json"}
        recorded = read_bag(folder / name / "bag")
        summary = read_summary(folder / name / "seeds.json")
        assert recorded.run.info.seed == 7
        assert fingerprint(recorded.run) == summary.outcomes[0].fingerprint
        assert len({outcome.fingerprint for outcome in summary.outcomes}) == 3
        document = json.loads((folder / name / "figures.json").read_text(encoding="utf-8"))
        assert document["figures"][0]["value"] == summary.outcomes[0].figures["power"].value
        assert summary.outcomes[0].fingerprint in output
    assert str(folder / "index.html") in output


def test_the_table_says_what_is_to_be_said(sailed: tuple[Path, int, str]) -> None:
    folder, _, output = sailed
    document = json.loads((folder / "index.json").read_text(encoding="utf-8"))
    first = next(run for run in document["runs"] if run["run"] == "first")
    assert (first["seeds"], first["sailed"], first["report"]) == ([7, 8, 9], "in process", "first/report.html")
    verdicts = {figure["name"]: figure["verdicts"] for figure in first["figures"]}
    assert verdicts == {"power": ["holds"], "printed": ["differs"], "silent": ["differs"], "never": ["holds"]}
    power = first["figures"][0]
    assert power["low"] < power["least"] < power["mean"] < power["most"] < power["high"]
    assert "differs (no reason given)" in output
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert 'href="first/report.html"' in page
    assert "made up" in page
    links = set(re.findall(r'(?:href|src)="([^"#]+)"', page))
    assert links == {"first/report.html", "second/report.html"}
    rows = [line for line in (folder / "index.md").read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    assert all(row.count(" | ") == 5 for row in rows)
    assert sum("differs (no reason given)" in row for row in rows) == output.count("differs (no reason given)")


def test_the_same_seed_gives_the_same_run_to_the_bit(sailed: tuple[Path, int, str], dp_here: Dp) -> None:
    folder, _, _ = sailed
    again = folder.parent / "again"
    words = ("--inprocess", "--seeds", "8,7", "--output", again, "--no-bag")
    code, output = dp_here("scenario", "run", folder.parent / "first.yaml", *words)
    assert code == 0, output
    before, after = (read_summary(path / "first" / "seeds.json") for path in (folder, again))
    assert after.seeds == (8, 7)
    assert [one.fingerprint for one in after.outcomes] == [
        before.outcomes[1].fingerprint,
        before.outcomes[0].fingerprint,
    ]
    assert {name: one.value for name, one in after.outcomes[0].figures.items()} == {
        name: one.value for name, one in before.outcomes[1].figures.items()
    }
    assert not (again / "first" / "bag").exists()


def test_report_of_a_folder_of_runs_and_of_recordings(
    sailed: tuple[Path, int, str], dp_here: Dp, tmp_path: Path
) -> None:
    folder, _, _ = sailed
    before = (folder / "index.json").read_text(encoding="utf-8")
    code, output = dp_here("report", folder)
    assert code == 0, output
    assert (folder / "index.json").read_text(encoding="utf-8") == before
    code, output = dp_here("report", folder / "first" / "bag", folder / "second" / "bag", "--output", tmp_path)
    assert code == 0, output
    runs = json.loads((tmp_path / "index.json").read_text(encoding="utf-8"))["runs"]
    assert [(run["run"], run["seeds"]) for run in runs] == [("first", [7]), ("second", [7])]
    assert (tmp_path / runs[0]["report"]).resolve() == (folder / "first" / "report.html").resolve()
    kept = read_summary(folder / "first" / "seeds.json").outcomes[0]
    assert runs[0]["fingerprints"] == [kept.fingerprint]
    assert runs[0]["figures"][0]["mean"] == kept.figures["power"].value


def test_a_newer_recording_counts(sailed: tuple[Path, int, str], tmp_path: Path) -> None:
    """As after `dp up --record --overwrite` in the folder of a campaign."""
    folder, _, _ = sailed
    bag = tmp_path / "first" / "bag"
    bag.mkdir(parents=True)
    (tmp_path / "first" / "seeds.json").write_bytes((folder / "second" / "seeds.json").read_bytes())
    (bag / "bag_0.mcap").write_bytes((folder / "first" / "bag" / "bag_0.mcap").read_bytes())
    (entry,) = find_entries([tmp_path], tmp_path)
    assert (entry.summary.name, entry.summary.seeds) == ("first", (7,))


def test_ctrl_c_stops_everything(tmp_path: Path) -> None:
    scenario = _write(tmp_path, "long", duration=2000.0)
    with DpProcess("scenario", "run", scenario, "--inprocess", "--repeat", "4", "--output", tmp_path) as process:
        found: list[psutil.Process] = []

        def sailing() -> bool:
            found[:] = psutil.Process(process._process.pid).children(recursive=True)
            return sum("spawn_main" in " ".join(child.cmdline()) for child in found) >= 1

        process.wait_until(sailing, "processes that sail")
        process.signal(signal.SIGINT)
        assert process.wait() == 130, process.output
        assert "interrupted; every process is stopped" in process.output
        assert "Traceback" not in process.output
        # The library's own helper of spawned processes ends when it sees that its parent has ended: just after it.
        _, left = psutil.wait_procs(found, timeout=10.0)
        assert left == []


def test_a_process_that_dies_is_told_and_replaced(tmp_path: Path) -> None:
    scenario = str(_write(tmp_path, "short"))
    orders = [Order(scenario, "", seed) for seed in (1, 2, 3)]
    results: dict[int, Outcome | RunFailedError] = {}
    killed: list[int] = []

    def progress(number: int, simulated: float) -> None:
        if not killed:
            killed.append(number)
            for child in psutil.Process().children():
                if "spawn_main" in " ".join(child.cmdline()):
                    child.kill()

    fill_all(orders, 1, progress, results.__setitem__)
    assert sorted(results) == [0, 1, 2]
    assert isinstance(results[killed[0]], RunFailedError)
    assert "ended by itself, exit code -9" in str(results[killed[0]])
    assert sum(isinstance(result, Outcome) for result in results.values()) == 2


def test_what_is_planned(tmp_path: Path) -> None:
    plans = plan(["a", "run_b"], None, (), 3, tmp_path, overwrite=False)
    assert [one.scenario.name for one in plans] == ["run_a", "run_b"]
    own = plans[0].scenario.seed
    assert plans[0].seeds == (own, own + 1, own + 2)
    assert plans[1].folder == tmp_path / "run_b"
    everything = plan(["all"], None, (5, 3), 1, tmp_path, overwrite=False)
    names = [one.scenario.name for one in everything]
    assert {"run_a", "run_b", "run_c"} <= set(names)
    assert all(re.fullmatch("run_[a-z]", name) for name in names)
    assert {one.seeds for one in everything} == {(5, 3)}


def test_a_vessel_of_another_scale_sails_the_scaled_scenario(tmp_path: Path) -> None:
    vessel = load_vessel("cybership3_full_scale")
    (one,) = plan(["a"], vessel, (), 1, tmp_path, overwrite=False)
    assert one.scenario.path is None
    assert one.folder == tmp_path / one.scenario.name
    sailed, scenario = Order(str(one.file), vessel.name, 5).load()
    assert sailed.name == vessel.name
    assert (scenario.name, scenario.seed) == (one.scenario.name, 5)
    assert scenario.duration == one.scenario.duration > 1000.0


def test_what_cannot_be_planned(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"scenario: expected every one once, found run_a more than once"):
        plan(["all", "a"], None, (), 1, tmp_path, overwrite=False)
    with pytest.raises(InputError, match=r"seed: expected every one once, found 3 more than once"):
        plan(["a"], None, (3, 3), 1, tmp_path, overwrite=False)
    with pytest.raises(UnknownNameError, match=r"run_x"):
        plan(["x"], None, (), 1, tmp_path, overwrite=False)
    (tmp_path / "run_a" / "bag").mkdir(parents=True)
    with pytest.raises(FolderError, match=r"run_a/bag: holds a recording; choose another --output, or --overwrite it"):
        plan(["a"], None, (), 1, tmp_path, overwrite=False)
    assert plan(["a"], None, (), 1, tmp_path, overwrite=True)


def test_no_runs_and_no_summary(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"runs: expected folders of runs or recordings, found none"):
        find_entries([], tmp_path)
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "seeds.json").write_text('{"name": "x"}', encoding="utf-8")
    with pytest.raises(DocumentError, match=r"seeds\.json: expected a summary of runs"):
        find_entries([tmp_path], tmp_path)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--inprocess", "--separate"), "--separate and --compare are about the graph"),
        (("--no-bag",), "--no-bag needs --inprocess"),
        (("--inprocess", "--seeds", "1,x"), "expected whole numbers such as 1,2,3, found 1,x"),
        (("--inprocess", "--seeds", "-1"), "expected numbers from 0"),
    ],
)
def test_wrong_usage(dp_here: Dp, words: tuple[str, ...], message: str) -> None:
    code, output = dp_here("scenario", "run", "a", *words)
    assert code == 2
    assert message in re.sub(r"[│\s]+", " ", output)
