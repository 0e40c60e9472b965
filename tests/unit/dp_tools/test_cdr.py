"""Messages made and read in bulk are those that rosbags serializes one by one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dp_tools.cdr.bulk import batches, serialized
from dp_tools.cdr.layout import LayoutError, layout_found, layout_of
from dp_tools.cdr.types import types_of
from support.repository import MESSAGES

# Every alignment and length that there is: a byte between doubles, texts between numbers, sequences of all sorts.
MIXED = """\
bool first
float64 second
string word
uint8 third
float32[3] fixed
string[] names
int16 fourth
float64[] many
bool[] flags
int32[] whole
string[2] pair
uint64 last
"""
KIND = "test_msgs/msg/Mixed"


@pytest.fixture(scope="module")
def types() -> Any:
    return types_of({KIND: MIXED})


texts = st.text(st.characters(min_codepoint=1, max_codepoint=0x24F), max_size=9)
numbers = st.floats(width=64, allow_nan=False)


def _message(types: Any, word: str, names: list[str], many: list[float], flags: list[bool], whole: list[int]) -> Any:
    return types.types[KIND](
        True, 2.5, word, 7, np.array([1, 2, 3], np.float32), names, -4,
        np.array(many), np.array(flags, bool), np.array(whole, np.int32), ["a", word], 2**63,
    )  # fmt: skip


@given(
    word=texts,
    names=st.lists(texts, max_size=3),
    many=st.lists(numbers, max_size=3),
    flags=st.lists(st.booleans(), max_size=5),
    whole=st.lists(st.integers(-(2**31), 2**31 - 1), max_size=3),
)
def test_bytes_are_those_of_rosbags(types: Any, word: str, names: Any, many: Any, flags: Any, whole: Any) -> None:
    expected = bytes(types.serialize_cdr(_message(types, word, names, many, flags, whole), KIND))
    layout = layout_of(
        types, KIND, {"word": word, "names": names, "pair": ("a", word)},
        {"many": len(many), "flags": len(flags), "whole": len(whole)},
    )  # fmt: skip
    made = serialized(layout, 2, {
        "first": True, "second": 2.5, "third": 7, "fixed": [1, 2, 3], "fourth": -4, "last": 2**63,
        "many": many, "flags": flags, "whole": whole,
    })  # fmt: skip
    assert made == [expected, expected]

    (batch,) = batches(types, KIND, [expected, expected], ["word"])
    assert batch.index.tolist() == [0, 1]
    assert batch.texts == {"word": word, "names": tuple(names), "pair": ("a", word)}
    assert batch.rows["many"].tolist() == [many, many]
    assert batch.rows["flags"].tolist() == [flags, flags]
    assert batch.rows["last"].tolist() == [2**63] * 2


def test_messages_are_sorted_by_lengths_and_by_the_texts_that_matter(types: Any) -> None:
    contents: list[tuple[Any, ...]] = [
        ("on", [], [1.0], [], []), ("up", [], [2.0], [], []), ("on", [], [3.0, 4.0], [], []), ("on", [], [5.0], [], []),
    ]  # fmt: skip
    data = [bytes(types.serialize_cdr(_message(types, *content), KIND)) for content in contents]
    by_word = {(b.texts["word"], tuple(b.index.tolist())) for b in batches(types, KIND, data, ["word"])}
    assert by_word == {("on", (0, 3)), ("up", (1,)), ("on", (2,))}
    by_length = {tuple(b.index.tolist()) for b in batches(types, KIND, data, [])}
    assert by_length == {(0, 1, 3), (2,)}


def test_bytes_at_the_end_do_not_matter(types: Any) -> None:
    data = bytes(types.serialize_cdr(_message(types, "x", [], [math.pi], [], []), KIND))
    (batch,) = batches(types, KIND, [data + b"\0\0\0"], [])
    assert batch.rows["many"].tolist() == [[math.pi]]


def test_what_is_no_message_is_refused(types: Any) -> None:
    data = bytes(types.serialize_cdr(_message(types, "x", [], [1.0], [], []), KIND))
    with pytest.raises(LayoutError, match=r"expected plain CDR, little endian, found the head 00000000"):
        layout_found(types, KIND, b"\0\0\0\0" + data[4:])
    with pytest.raises(LayoutError, match=r"test_msgs/msg/Mixed: expected \d+ bytes, found \d+"):
        layout_found(types, KIND, data[:-1])
    with pytest.raises(LayoutError, match=r"word: expected a length within the message, found 4294967295"):
        layout_found(types, KIND, data[:20] + b"\xff\xff\xff\xff" + data[24:])


def test_sequences_of_messages_are_not_laid_out() -> None:
    nested = types_of({"test_msgs/msg/Outer": f"Inner[] inside\n{'=' * 80}\nMSG: test_msgs/Inner\nfloat64 x\n"})
    with pytest.raises(LayoutError, match=r"inside: expected an array of numbers or texts"):
        layout_of(nested, "test_msgs/msg/Outer", {}, {"inside": 1})


def test_every_message_of_the_project_has_a_layout() -> None:
    header = f"\n{'=' * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    time = f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    for path in sorted((MESSAGES / "msg").glob("*.msg")):
        kind = f"dp_msgs/msg/{path.stem}"
        types = types_of({kind: path.read_text(encoding="utf-8") + header + time})
        layout = layout_of(types, kind, {"axis_mode": ("", "", "")}, {})
        (data,) = serialized(layout, 1, {})
        assert bytes(types.serialize_cdr(types.deserialize_cdr(data, kind), kind)) == data
