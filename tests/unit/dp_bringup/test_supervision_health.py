"""What the supervisor says of itself, from the state of its processes."""

from __future__ import annotations

from dp_bringup.supervisor.policy import Action, Phase, Policy
from dp_bringup.supervisor.rules import Rules
from dp_bringup.supervisor.supervision_health import supervision_health
from dp_node import Health, Level

RULES = Rules(attempts=2)


def brought_up() -> Policy:
    policy = Policy(RULES)
    assert policy.look(0.0) is Action.START
    policy.up(0.0)
    return policy


def codes(health: Health) -> list[str]:
    return [alarm.kind.code for alarm in health.alarms]


def test_a_process_that_is_up_is_nominal() -> None:
    health = supervision_health({"dp_observer": brought_up()}, 0.1)
    assert (health.level, health.message) == (Level.OK, "nominal")
    assert health.values == {"dp_observer.phase": "up", "dp_observer.restarts": 0}


def test_a_process_that_died_is_told_on_its_way_and_when_it_is_back() -> None:
    policy = brought_up()
    policy.died("killed by SIGKILL", 1.0)
    health = supervision_health({"dp_observer": policy}, 1.0)
    assert (health.level, codes(health)) == (Level.WARN, ["SUPERVISOR-NODE-RESTARTED"])
    assert health.message.endswith("dp_observer, killed by SIGKILL; it is on its way")
    assert policy.look(policy.due) is Action.START
    policy.up(policy.due)
    health = supervision_health({"dp_observer": policy}, policy.due)
    assert health.message.endswith("it runs again")
    assert health.values["dp_observer.restarts"] == 1


def test_a_process_that_cannot_be_kept_up_is_given_up() -> None:
    policy, now = brought_up(), 0.0
    for _ in range(RULES.attempts + 1):
        policy.died("exit code 1", now)
        if policy.phase is Phase.GIVEN_UP:
            break
        now = policy.due
        assert policy.look(now) is Action.START
        policy.up(now)
    health = supervision_health({"dp_observer": policy}, now)
    assert (health.level, codes(health)) == (Level.ERROR, ["SUPERVISOR-NODE-GIVEN-UP"])
    assert health.alarms[0].detail.startswith("dp_observer")


def test_a_process_that_does_not_answer_is_named() -> None:
    policy = brought_up()
    now = 0.0
    while not policy.silent(now):
        assert policy.look(now) is None, "it is told before it is killed"
        now += 0.5
    assert codes(supervision_health({"dp_observer": policy}, now)) == ["SUPERVISOR-NODE-SILENT"]
    policy.heard(now)
    assert codes(supervision_health({"dp_observer": policy}, now)) == []
