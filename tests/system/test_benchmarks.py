"""`python -m benchmarks` from the shell, as far as a test may: it works, and what it writes has the agreed form."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FIELDS = {"name", "value", "unit", "peer", "peer_value", "ratio", "aim", "met"}


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "benchmarks", *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=100, check=False)


def test_quick_in_process_writes_results_and_machine(tmp_path: Path) -> None:
    done = run("--quick", "--only", "in_process", "--output", str(tmp_path))
    assert done.returncode == 0, done.stderr
    rows = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    first = rows[0]
    assert first["name"] == "real_time_factor_in_process"
    assert first["name"] in done.stdout
    assert "MCSimPython" in first["peer"]
    for row in rows:
        assert set(row) == FIELDS
        assert row["value"] > 0.0
        assert row["ratio"] is None or row["ratio"] == row["value"] / row["peer_value"]
        assert row["met"] in (None, True, False)
    machine = json.loads((tmp_path / "machine.json").read_text(encoding="utf-8"))
    assert machine["usable_cores"] >= 1
    assert machine["versions"]["numpy"] != "not installed"


def test_a_measurement_that_fails_is_named_and_ends_in_an_exit_code(tmp_path: Path) -> None:
    code = (
        "import sys; import benchmarks.__main__ as bench\n"
        "def broken(plan): raise OSError('no such clock')\n"
        "bench._MEASUREMENTS['hop'] = ('Broken', broken)\n"
        f"sys.exit(bench.main(['--quick', '--only', 'hop', '--output', {str(tmp_path)!r}]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 1
    assert "hop: failed: OSError: no such clock" in done.stdout
    assert json.loads((tmp_path / "results.json").read_text(encoding="utf-8")) == []
