"""YAML documents: 1.2 scalars, and every kind of broken file told apart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from marine_model.errors import DocumentError
from marine_model.yaml_document import read_yaml


def read(folder: Path, text: str) -> dict[str, Any]:
    path = folder / "document.yaml"
    path.write_text(text, encoding="utf-8")
    return read_yaml(path).content


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e7", 1e7), ("1.0e7", 1e7), ("-2.5E-3", -2.5e-3), (".5", 0.5), ("3.", 3.0), ("+1.5", 1.5),
        ("7", 7), ("-7", -7), ("010", 10), ("0x1f", 31), ("0o17", 15), ("1_000", "1_000"),
        ("1:30", "1:30"), ("2020-01-01", "2020-01-01"),
        ("true", True), ("False", False), ("yes", "yes"), ("no", "no"), ("on", "on"), ("y", "y"),
        ("null", None), ("~", None), ("", None), ("'7'", "7"), ("north", "north"), ("<<", "<<"), ("=", "="),
        ("[1, 2.0, a]", [1, 2.0, "a"]), ("{b: {c: 1}}", {"b": {"c": 1}}),
    ],
)  # fmt: skip
def test_scalars_are_those_of_yaml_1_2(tmp_path: Path, text: str, value: Any) -> None:
    found = read(tmp_path, f"a: {text}\n")["a"]
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(("text", "positive"), [(".inf", True), ("-.inf", False)])
def test_infinity_is_read_as_such(tmp_path: Path, text: str, positive: bool) -> None:
    found = read(tmp_path, f"a: {text}\n")["a"]
    assert found == (float("inf") if positive else -float("inf"))


BROKEN = {
    "a: [1, 2\nb: 3\n": "2: document: not valid YAML: expected ',' or ']'",
    "a:\n\t- b\n": "2: document: not valid YAML: found character '\\t' that cannot start any token",
    "a: 1\nb: 2\na: 3\n": "3: document: not valid YAML: field 'a' appears twice",
    "a:\n  b: {c: 1, c: 2}\n": "2: document: not valid YAML: field 'c' appears twice",
    "a: 1\n---\nb: 2\n": "2: document: not valid YAML: but found another document",
    "a: *nowhere\n": "1: document: not valid YAML: found undefined alias 'nowhere'",
    "a: !!python/object:os.system x\n": "1: document: not valid YAML: could not determine a constructor for the tag",
    "b: 1\na: !mine x\n": "2: document: not valid YAML: could not determine a constructor for the tag '!mine'",
    "? [a, b]\n: 1\n": "1: document: not valid YAML: expected a word for a field name",
    "a: 1\n2: 3\n": "2: document: not valid YAML: expected a word for a field name",
    "null: 3\n": "1: document: not valid YAML: expected a word for a field name",
    "a: &a [*a]\n": "1: document: not valid YAML: a part contains itself",
    "a: &a {b: *a}\n": "1: document: not valid YAML: a part contains itself",
    "a: " + "[" * 3000 + "]" * 3000: "1: document: not valid YAML: nested too deeply",
    "a: " + "9" * 5000: "1: document: not valid YAML: Exceeds the limit",
    "a: !!timestamp 2020-13-45\n": "1: document: not valid YAML: month must be in 1..12",
    "a: \x01\n": "1: document: not valid YAML: unacceptable character #x0001",
    "- a\n": "1: document: expected a mapping, found list",
    "just words\n": "1: document: expected a mapping, found str",
    "": "1: document: expected a mapping, found NoneType",
    "# only a remark\n": "1: document: expected a mapping, found NoneType",
}


@pytest.mark.parametrize("text", BROKEN, ids=lambda text: repr(text[:20]))
def test_what_is_wrong_is_said_with_its_line(tmp_path: Path, text: str) -> None:
    with pytest.raises(DocumentError) as caught:
        read(tmp_path, text)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'document.yaml'}:{BROKEN[text]}")
    assert "\n" not in message


def test_repeated_aliases_do_not_multiply_without_end(tmp_path: Path) -> None:
    text = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n"
    for i in range(1, 30):
        text += f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n"
    with pytest.raises(DocumentError, match="more than 100000 values"):
        read(tmp_path, text)


def test_aliases_are_welcome(tmp_path: Path) -> None:
    assert read(tmp_path, "a: &x {b: 1}\nc: *x\n") == {"a": {"b": 1}, "c": {"b": 1}}


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(DocumentError, match=r"nowhere\.yaml: cannot be read: No such file or directory"):
        read_yaml(tmp_path / "nowhere.yaml")
    with pytest.raises(DocumentError, match="cannot be read: Is a directory"):
        read_yaml(tmp_path)
    path = tmp_path / "latin.yaml"
    path.write_bytes(b"a: \xff\n")
    with pytest.raises(DocumentError, match="cannot be read: 'utf-8' codec can't decode byte 0xff"):
        read_yaml(path)


def test_lines_of_fields_and_of_their_nearest_parent(tmp_path: Path) -> None:
    path = tmp_path / "document.yaml"
    path.write_text("a: 1\n\nb:\n  c:\n    - d: 2\n    - e: 3\n")
    document = read_yaml(path)
    assert document.problem(("b", "c", 1, "e"), "bad") == f"{path}:6: b.c.1.e: bad"
    assert document.problem(("b", "c", 0, "missing"), "bad") == f"{path}:5: b.c.0.missing: bad"
    assert document.problem(("z",), "bad") == f"{path}:1: z: bad"
    assert document.problem((), "bad") == f"{path}:1: document: bad"


@given(text=st.text(alphabet=st.sampled_from(list("ab:-[]{}&*!?,'\"#|>%@ \n\t0123456789.e~<=")), max_size=60))
@settings(max_examples=500, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_text_is_read_or_refused(tmp_path: Path, text: str) -> None:
    try:
        content = read(tmp_path, text)
    except DocumentError:
        return  # the one way out that is allowed
    assert isinstance(content, dict)
