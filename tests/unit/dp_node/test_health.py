from dp_node import Health, Level
from dp_node.health import to_status


def test_the_worse_of_two_wins_and_values_of_both_are_kept() -> None:
    calm = Health(values={"a": 1})
    bad = Health(Level.ERROR, "solver failed", {"b": 2.0})
    both = calm.worse_of(bad)
    assert (both.level, both.message) == (Level.ERROR, "solver failed")
    assert both.values == {"a": 1, "b": 2.0}
    assert bad.worse_of(Health(Level.WARN, "late")).message == "solver failed"


def test_two_warnings_are_both_told_and_two_calm_ones_once() -> None:
    late, refused = Health(Level.WARN, "late"), Health(Level.WARN, "refused: x")
    assert late.worse_of(refused).message == "late; refused: x"
    assert late.worse_of(late).message == "late"
    assert Health().worse_of(Health(message="sailing")).message == "nominal"


def test_the_message_carries_level_name_text_and_values() -> None:
    status = to_status("dp_observer", Health(Level.WARN, "late", {"age_s": 0.25, "count": 3, "state": "active"}))
    assert status.level == b"\x01"
    assert (status.name, status.message) == ("dp_observer", "late")
    assert {v.key: v.value for v in status.values} == {"age_s": "0.25", "count": "3", "state": "active"}
