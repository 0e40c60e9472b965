"""When a process is started, killed, restarted and given up."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from dp_bringup.supervisor.policy import Action, Phase, Policy
from dp_bringup.supervisor.rules import Rules
from marine_model.errors import InputError

RULES = Rules()


def brought_up(now: float = 0.0, rules: Rules = RULES) -> Policy:
    policy = Policy(rules)
    assert policy.look(now) is Action.START
    policy.up(now)
    return policy


def restart(policy: Policy, now: float, killed: str = "killed by SIGKILL") -> float:
    """Let the process die at ``now``; return when it is up again."""
    policy.died(killed, now)
    assert policy.phase is Phase.BACK_OFF
    then = policy.due
    assert policy.look(then) is Action.START
    policy.up(then)
    return then


def test_the_back_off_doubles_up_to_the_longest() -> None:
    rules = Rules(attempts=100)
    policy, now, delays = brought_up(rules=rules), 0.0, []
    for _ in range(8):
        then = restart(policy, now)
        delays.append(then - now)
        now = then
    assert delays == [1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0, 30.0]
    assert policy.restarts == 8


def test_nothing_is_done_before_the_back_off_is_over() -> None:
    policy = brought_up()
    policy.died("exit code 1", 10.0)
    assert policy.look(10.9) is None
    assert policy.look(11.0) is Action.START
    assert policy.look(11.1) is None, "once"


def test_a_process_that_was_up_for_long_is_in_order_again() -> None:
    policy = brought_up()
    now = restart(policy, 0.0)
    now = restart(policy, now)
    policy.heard(now)
    now += RULES.stable_after
    assert restart(policy, now) - now == RULES.first_delay


def test_it_is_given_up_after_too_many_deaths_within_the_window_and_a_request_forgives() -> None:
    policy, now = brought_up(), 0.0
    for _ in range(RULES.attempts):
        now = restart(policy, now)
    policy.died("exit code 1", now)
    assert (policy.phase, policy.reason, policy.deaths) == (Phase.GIVEN_UP, "exit code 1", RULES.attempts + 1)
    assert policy.look(now + 1e6) is None
    assert policy.asked(now + 1e6) is None
    assert policy.look(now + 1e6) is Action.START
    policy.up(now + 1e6)
    assert restart(policy, now + 1e6) == now + 1e6 + RULES.first_delay


def test_deaths_that_are_far_apart_do_not_add_up() -> None:
    policy, now = brought_up(), 0.0
    for _ in range(5 * RULES.attempts):
        now = restart(policy, now) + RULES.window
        policy.heard(now)
    assert policy.phase is Phase.UP


def test_who_dies_before_it_was_ever_up_cannot_be_started() -> None:
    policy = Policy(RULES)
    policy.look(0.0)
    policy.died("exit code 1", 1.0)
    assert policy.phase is Phase.GIVEN_UP


def test_who_is_silent_is_told_of_first_and_killed_then() -> None:
    policy, now = brought_up(), 0.0
    seen: dict[float, tuple[bool, Action | None]] = {}
    while now < RULES.hang_timeout + 1.0:
        now += 0.5
        action = policy.look(now)
        seen[now] = policy.silent(now), action
    assert [t for t, (silent, _) in seen.items() if silent] == [
        t for t in seen if RULES.silent_after <= t < RULES.hang_timeout
    ]
    assert [t for t, (_, action) in seen.items() if action] == [RULES.hang_timeout]
    assert policy.phase is Phase.ENDING
    policy.died("killed by SIGKILL", now)
    assert (policy.phase, policy.reason) == (Phase.BACK_OFF, "silent for 10 s")


def test_who_is_heard_of_lives() -> None:
    policy = brought_up()
    for tenth in range(1000):
        policy.heard(0.1 * tenth)
        assert policy.look(0.1 * tenth) is None


def test_time_in_which_the_supervisor_itself_slept_does_not_count() -> None:
    policy = brought_up()
    assert policy.look(0.5) is None
    assert policy.look(1000.0) is None, "what was heard meanwhile has not been taken yet"
    assert not policy.silent(1000.0)
    policy.heard(1000.1)
    assert policy.look(1000.2) is None


def test_who_does_not_come_up_is_killed_but_not_for_waiting_for_others() -> None:
    policy = brought_up()
    policy.died("exit code 1", 0.0)
    now = policy.due
    assert policy.look(now) is Action.START
    for _ in range(400):
        now += 1.0
        policy.waits(now)
        assert policy.look(now) is None
    for _ in range(int(RULES.start_timeout) - 1):
        now += 1.0
        assert policy.look(now) is None
    assert policy.look(now + 1.0) is Action.KILL


def test_who_refuses_to_come_up_is_killed_and_restarted_later() -> None:
    policy = brought_up()
    policy.died("exit code 1", 0.0)
    assert policy.look(1.0) is Action.START
    assert policy.failed("dp_observer refused to configure", 1.5) is Action.KILL
    policy.died("killed by SIGKILL", 1.6)
    assert (policy.phase, policy.reason) == (Phase.BACK_OFF, "dp_observer refused to configure")
    assert policy.delay == 2.0


def test_a_restart_that_is_asked_for_costs_no_back_off_and_counts_for_nothing() -> None:
    policy = brought_up()
    assert policy.asked(1.0) is Action.STOP
    assert policy.asked(1.1) is None, "it is on its way already"
    policy.died("exit code 0", 1.5)
    assert policy.look(1.5) is Action.START
    policy.up(2.0)
    assert not policy.shaken(2.0)
    assert policy.deaths == 0


def test_who_does_not_end_when_asked_is_killed() -> None:
    policy = brought_up()
    assert policy.asked(1.0) is Action.STOP
    assert policy.look(1.0 + RULES.stop_timeout - 0.1) is None
    assert policy.look(1.0 + RULES.stop_timeout) is Action.KILL
    assert policy.look(1.2 + RULES.stop_timeout) is None, "once"


def test_a_restart_in_the_middle_of_a_back_off_is_at_once() -> None:
    policy = brought_up()
    policy.died("exit code 1", 1.0)
    assert policy.asked(1.1) is None
    assert policy.look(1.1) is Action.START


def test_a_restart_is_told_of_until_the_process_is_stable() -> None:
    policy = brought_up()
    assert not policy.shaken(0.0)
    now = restart(policy, 5.0)
    assert policy.shaken(now + RULES.stable_after - 0.1)
    assert not policy.shaken(now + RULES.stable_after)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"first_delay": 0.0}, "first_delay: expected a number above 0, found 0"),
        ({"window": float("nan")}, "window: expected a number above 0, found nan"),
        ({"hang_timeout": 2.0}, "hang_timeout: expected at least silent_after, 3 s, found 2 s"),
        ({"first_delay": 5.0, "longest_delay": 1.0}, "longest_delay: expected at least first_delay, 5 s, found 1 s"),
    ],
)
def test_rules_that_make_no_sense_are_refused(values: dict[str, float], text: str) -> None:
    with pytest.raises(InputError, match=text):
        Rules(**values)


class AnyLife(RuleBasedStateMachine):
    """Whatever happens in whatever order: at most one process at a time, and none after it was given up."""

    def __init__(self) -> None:
        super().__init__()
        self.policy = Policy(RULES)
        self.now = 0.0
        self.alive = False
        self.was_up = False
        self.started_at: list[float] = []
        self.died_at: float | None = None
        self.forgiven = False

    def do(self, action: Action | None) -> None:
        if action is Action.START:
            assert not self.alive
            if self.died_at is not None and not self.forgiven:
                assert self.now - self.died_at >= RULES.first_delay - 1e-9
            self.alive, self.forgiven = True, False
            self.started_at.append(self.now)
        elif action is not None:
            assert self.alive

    @rule(seconds=st.floats(0.0, 50.0))
    def time_passes(self, seconds: float) -> None:
        self.now += seconds
        self.do(self.policy.look(self.now))

    @precondition(lambda self: self.alive)
    @rule()
    def comes_up(self) -> None:
        self.policy.up(self.now)
        self.was_up = self.policy.was_up

    @rule()
    def is_heard_of(self) -> None:
        self.policy.heard(self.now)

    @precondition(lambda self: self.alive)
    @rule()
    def dies(self) -> None:
        self.policy.died("exit code 1", self.now)
        self.alive, self.died_at = False, self.now
        self.forgiven = self.forgiven or self.policy.phase is Phase.DUE

    @rule()
    def somebody_asks(self) -> None:
        self.do(self.policy.asked(self.now))
        self.forgiven = self.forgiven or self.policy.phase is Phase.DUE

    @precondition(lambda self: self.alive)
    @rule()
    def refuses(self) -> None:
        self.do(self.policy.failed("refused", self.now))

    @invariant()
    def phase_and_process_agree(self) -> None:
        assert self.alive == (self.policy.phase in (Phase.STARTING, Phase.UP, Phase.ENDING))

    @invariant()
    def no_more_deaths_than_are_made_good(self) -> None:
        assert self.policy.phase is Phase.GIVEN_UP or self.policy.deaths <= RULES.attempts

    @invariant()
    def back_offs_are_within_their_limits(self) -> None:
        assert RULES.first_delay <= self.policy.delay <= RULES.longest_delay


AnyLife.TestCase.settings = settings(max_examples=200, stateful_step_count=60, deadline=None)
TestAnyLife = AnyLife.TestCase


@given(st.lists(st.floats(0.01, 20.0), min_size=1, max_size=60))
def test_a_process_that_is_restarted_for_ever_is_given_up_unless_it_lasts(lives: list[float]) -> None:
    """However long its lives: given up exactly when more deaths than allowed fall within one window."""
    policy, now = brought_up(), 0.0
    deaths: list[float] = []
    for life in lives:
        now += life
        policy.heard(now)
        policy.died("exit code 1", now)
        deaths.append(now)
        recent = [at for at in deaths if at >= now - RULES.window]
        if len(recent) > RULES.attempts:
            assert policy.phase is Phase.GIVEN_UP
            return
        assert policy.phase is Phase.BACK_OFF
        now = policy.due
        assert policy.look(now) is Action.START
        policy.up(now)
