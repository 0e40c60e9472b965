"""Child processes of a run: what died and why, and that all are stopped."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

import pytest

from dp_bringup.processes import Child, ChildDiedError, Children, explain_exit
from support.waiting import wait_until

READY = "print('ready', flush=True)"
SLEEP = "import time; time.sleep(600)"
CLEAN = f"import signal, sys; signal.signal(signal.SIGINT, lambda *a: sys.exit(0)); {READY}; {SLEEP}"
DEAF = f"import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); {READY}; {SLEEP}"
STUBBORN = (
    f"import signal; [signal.signal(s, signal.SIG_IGN) for s in (signal.SIGINT, signal.SIGTERM)]; {READY}; {SLEEP}"
)


def start(children: Children, name: str, program: str) -> Child:
    # -S: an interpreter that starts in milliseconds; nothing of the workspace is needed.
    return children.start(name, [sys.executable, "-S", "-c", program])


def wait_until_ready(child: Child) -> None:
    wait_until(lambda: "ready" in child.log_file.read_text(encoding="utf-8"), message=f"{child.name} to be ready")


def test_a_clean_stop_has_nothing_to_tell(tmp_path: Path) -> None:
    children = Children(tmp_path / "logs")
    started = [start(children, name, CLEAN) for name in ("a", "b")]
    for child in started:
        wait_until_ready(child)
    children.check()
    assert children.running == tuple(started)
    assert children.stop() == []
    assert [child.exit_code for child in started] == [0, 0]
    assert children.all == ()


def test_who_ends_by_itself_is_named_with_code_and_last_words(tmp_path: Path) -> None:
    children = Children(tmp_path)
    program = "import sys; [print('line', i) for i in range(20)]; print('no such vessel', file=sys.stderr); sys.exit(3)"
    start(children, "good", CLEAN)
    bad = start(children, "bad", program)
    wait_until(lambda: bad.exit_code is not None)
    with pytest.raises(ChildDiedError) as died:
        children.check()
    text = str(died.value)
    assert text.startswith(f"bad ended by itself (exit code 3), its last words ({tmp_path}/bad.log):\n")
    assert text.endswith("\n    no such vessel")
    assert "line 19" in text
    assert "line 0\n" not in text
    assert "line 0\n" in (tmp_path / "bad.log").read_text(encoding="utf-8")
    assert children.stop([bad]) == [], "it has been told already"
    children.stop()


def test_a_signal_is_named(tmp_path: Path) -> None:
    children = Children(tmp_path)
    child = start(children, "victim", CLEAN)
    child.request_stop(signal.SIGKILL)
    wait_until(lambda: child.exit_code is not None)
    with pytest.raises(ChildDiedError, match=r"^victim ended by itself \(killed by SIGKILL\)"):
        children.check()
    children.stop()


def test_who_does_not_listen_to_sigint_gets_sigterm(tmp_path: Path) -> None:
    children = Children(tmp_path, patience=0.2)
    child = start(children, "deaf", DEAF)
    wait_until_ready(child)
    (problem,) = children.stop()
    assert problem.startswith("deaf stopped with killed by SIGTERM")


def test_who_listens_to_nothing_is_killed_and_told(tmp_path: Path) -> None:
    children = Children(tmp_path, patience=0.2)
    stubborn, clean = start(children, "stubborn", STUBBORN), start(children, "clean", CLEAN)
    for child in (stubborn, clean):
        wait_until_ready(child)
    assert children.stop() == ["stubborn did not stop and was killed"]
    assert (stubborn.exit_code, clean.exit_code) == (-signal.SIGKILL, 0)


def test_groups_stop_one_after_the_other(tmp_path: Path) -> None:
    children = Children(tmp_path)
    first, last = start(children, "first", CLEAN), start(children, "last", CLEAN)
    for child in (first, last):
        wait_until_ready(child)
    assert children.stop([first]) == []
    assert first.exit_code == 0
    assert last.exit_code is None
    assert children.all == (last,)
    assert children.stop() == []


@pytest.mark.parametrize(
    ("code", "words"),
    [(0, "exit code 0"), (2, "exit code 2"), (-11, "killed by SIGSEGV"), (-99, "killed by signal 99")],
)
def test_exit_codes_in_words(code: int, words: str) -> None:
    assert explain_exit(code) == words
