"""Which topics are recorded."""

from __future__ import annotations

import pytest

from dp_tools.recorder.errors import RecordingRefusedError
from dp_tools.recorder.selection import Selection


def test_everything_that_is_not_hidden_and_every_change_of_a_parameter() -> None:
    selection = Selection()
    assert selection.wants("/a")
    assert selection.wants("/ship/a")
    assert not selection.wants("/_hidden/a")
    assert not selection.wants("/ship/_hidden")


def test_a_namespace_and_what_all_graphs_share() -> None:
    selection = Selection(namespace="/ship")
    assert selection.wants("/ship/pose")
    assert not selection.wants("/shipyard/pose")
    assert not selection.wants("/pose")
    assert selection.wants("/diagnostics")
    assert selection.wants("/parameter_events")


def test_names_and_patterns_add_up_and_what_is_excluded_is_never_recorded() -> None:
    selection = Selection(["pose", "/other/pose"], regex="thruster_.*", exclude="feedback$", namespace="/ship")
    assert selection.wants("/ship/pose")
    assert selection.wants("/other/pose")
    assert not selection.wants("/pose")
    assert selection.wants("/anywhere/thruster_command")
    assert not selection.wants("/ship/thruster_feedback")
    assert not selection.wants("/diagnostics")
    # Parameters are part of every bag.
    assert selection.wants("/parameter_events")
    assert Selection(exclude="pose").wants("/odometry")
    assert not Selection(["/pose"], exclude="pose").wants("/pose")


def test_what_is_no_regular_expression_is_refused() -> None:
    with pytest.raises(RecordingRefusedError, match=r"regex: expected a regular expression, found '\[': "):
        Selection(regex="[")
    with pytest.raises(RecordingRefusedError, match=r"exclude: expected a regular expression, found '\*': "):
        Selection(exclude="*")
