"""Settings: declared once, with description, unit and range."""

from __future__ import annotations

import math

import pytest
from pydantic import ValidationError

from marine_model.settings import Settings, setting


class Inner(Settings):
    limit: float = setting(1.0, "A limit.", unit="m", ge=0.0, le=2.0)


class Outer(Settings):
    count: int = setting(3, "A count.", ge=1, read_only=True)
    inner: Inner = Inner()


def test_defaults_and_metadata() -> None:
    assert Outer().inner.limit == 1.0
    field = Inner.model_fields["limit"]
    assert field.description == "A limit."
    assert field.json_schema_extra == {"unit": "m", "read_only": False}
    assert Outer.model_fields["count"].json_schema_extra == {"unit": "", "read_only": True}


@pytest.mark.parametrize(
    "bad", [{"limit": 2.1}, {"limit": -0.1}, {"limit": math.nan}, {"limit": "1"}, {"limit": True}, {"limitt": 1.0}]
)
def test_out_of_range_wrong_type_and_unknown_are_refused(bad: dict[str, object]) -> None:
    with pytest.raises(ValidationError, match=next(iter(bad))):
        Inner.model_validate(bad)


def test_frozen() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        Inner().limit = 0.5
