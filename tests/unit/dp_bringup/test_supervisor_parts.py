"""Last parameters, the next transition, and what the supervisor says of its processes."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from dp_bringup.parameter_file import read_parameter_file, to_parameter_file
from dp_bringup.supervisor.last_parameters import LastParameters
from dp_bringup.supervisor.life_cycle import Aim, Step, next_step
from dp_bringup.supervisor.policy import Action, Policy
from dp_bringup.supervisor.rules import Rules
from dp_bringup.supervisor.supervision_health import supervision_health
from dp_node.health import Level

CHANGES = st.lists(st.tuples(st.sampled_from("abc"), st.integers()), max_size=20)


@given(CHANGES, CHANGES, CHANGES)
def test_the_last_change_stands_whenever_the_snapshot_was_taken(
    before: list[tuple[str, int]], meanwhile: list[tuple[str, int]], after: list[tuple[str, int]]
) -> None:
    """The snapshot has what was so when it was asked for; changes may be heard before it comes."""
    kept, truth = LastParameters({"node": {"a": 0}}), {"a": 0, "b": 1, "c": 2}
    truth.update(before)  # made before anybody listened
    kept.expect_snapshot("node")
    snapshot = dict(truth)
    for name, value in meanwhile:
        truth[name] = value
        kept.changed("node", {name: value})
    kept.snapshot("node", snapshot)
    for name, value in after:
        truth[name] = value
        kept.changed("node", {name: value})
    assert kept.of("node") == truth


def test_what_has_no_form_in_a_file_or_is_the_supervisor_s_is_left_out(tmp_path: Any) -> None:
    kept = LastParameters({"node": {"vessel": "cybership3", "autostart": True}})
    kept.snapshot("node", {"none": None, "empty": [], "list": [1.5, 2.0], "text": "on", "use_sim_time": False})
    values = {"vessel": "cybership3", "list": [1.5, 2.0], "text": "on", "use_sim_time": False}
    assert kept.of("node") == values
    assert kept.of("unknown") == {}
    file = tmp_path / "node.yaml"
    file.write_text(to_parameter_file({"node": kept.of("node")}), encoding="utf-8")
    assert read_parameter_file(file) == {"node": values}
    assert yaml.safe_load(file.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("state", "aim", "turn", "step"),
    [
        ("unconfigured", Aim.ACTIVE, False, Step.CONFIGURE),
        ("unconfigured", Aim.INACTIVE, True, Step.CONFIGURE),
        ("unconfigured", Aim.UNCONFIGURED, True, None),
        ("inactive", Aim.ACTIVE, False, None),
        ("inactive", Aim.ACTIVE, True, Step.ACTIVATE),
        ("inactive", Aim.INACTIVE, True, None),
        ("active", Aim.ACTIVE, True, None),
        ("configuring", Aim.ACTIVE, True, None),
        ("finalized", Aim.ACTIVE, True, None),
    ],
)
def test_the_next_transition(state: str, aim: Aim, turn: bool, step: Step | None) -> None:
    assert next_step(state, aim, turn) is step


def test_health_names_who_was_restarted_who_is_silent_and_who_was_given_up() -> None:
    rules = Rules(attempts=1)
    policies = {name: Policy(rules) for name in ("good", "restarted", "silent", "lost")}
    for policy in policies.values():
        assert policy.look(0.0) is Action.START
        policy.up(0.0)
    health = supervision_health(policies, 0.0)
    assert (health.level, health.message, health.alarms) == (Level.OK, "nominal", ())
    policies["restarted"].died("killed by SIGKILL", 1.0)
    health = supervision_health(policies, 1.0)
    assert [alarm.kind.code for alarm in health.alarms] == ["SUPERVISOR-NODE-RESTARTED"]
    assert health.message.endswith("restarted, killed by SIGKILL; it is on its way")
    assert policies["restarted"].look(2.0) is Action.START
    policies["restarted"].up(3.0)
    policies["lost"].died("exit code 1", 3.0)
    policies["lost"].look(4.0)
    policies["lost"].up(4.0)
    policies["lost"].died("exit code 2", 4.0)
    for name in ("good", "restarted"):
        policies[name].heard(5.0)
    health = supervision_health(policies, 5.0)
    assert [(alarm.kind.code, alarm.detail) for alarm in health.alarms] == [
        ("SUPERVISOR-NODE-RESTARTED", "restarted, killed by SIGKILL; it runs again"),
        ("SUPERVISOR-NODE-SILENT", "silent"),
        ("SUPERVISOR-NODE-GIVEN-UP", "lost, exit code 2"),
    ]
    assert health.level is Level.ERROR
    assert health.values["lost.phase"] == "given_up"
    assert health.values["restarted.restarts"] == 1
