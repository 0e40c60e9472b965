"""Simulated against wall time, with a wall clock made by hand."""

from __future__ import annotations

import pytest

from vessel_sim.pace import Pace


def test_a_step_is_allowed_once_its_wall_time_has_come() -> None:
    pace = Pace(2.0)
    pace.restart(wall=100.0, simulated=7.0)
    assert pace.allows(100.0, 7.0)
    assert not pace.allows(100.004, 7.01)
    assert pace.allows(100.005, 7.01)


def test_no_limit_at_rate_zero() -> None:
    pace = Pace(0.0)
    pace.restart(0.0, 0.0)
    assert pace.allows(0.0, 1e6)


def test_the_rate_achieved_is_measured_over_two_seconds() -> None:
    pace = Pace(1.0)
    pace.restart(0.0, 0.0)
    pace.note(1.9, 1.9)
    assert pace.achieved is None
    pace.note(2.0, 1.0)
    assert pace.achieved == pytest.approx(0.5)


def test_a_debt_too_large_is_forgiven_rather_than_caught_up_with() -> None:
    pace = Pace(1.0)
    pace.restart(0.0, 0.0)
    pace.note(10.0, 9.6)  # 0.4 s behind: is caught up with
    assert pace.forgiven == 0.0
    assert pace.allows(10.0, 9.9)
    pace.note(13.0, 10.0)
    assert pace.forgiven == pytest.approx(3.0)
    assert pace.allows(13.0, 10.0)
    assert not pace.allows(13.0, 10.1)
