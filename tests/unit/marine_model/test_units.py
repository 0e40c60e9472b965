"""Units: what they are made of, where fields have them, and that none is missing."""

from __future__ import annotations

from typing import Annotated

import pytest

from dp_tools.node_settings import default_settings
from dp_tools.scenario import Scenario
from marine_model import Vessel, load_vessel
from marine_model.errors import InputError
from marine_model.schema import Positive, Section
from marine_model.settings import Settings, setting
from marine_model.units import Unit, dimension, numbers_without_unit, parameter_units


@pytest.mark.parametrize(
    ("unit", "powers"),
    [
        ("1", (0, 0, 0)),
        ("rad", (0, 0, 0)),
        ("hull lengths", (0, 0, 0)),
        ("m", (0, 1, 0)),
        ("kg m^2", (1, 2, 0)),
        ("N", (1, 1, -2)),
        ("N s/m", (1, 0, -1)),
        ("N/(m s)", (1, 0, -3)),
        ("N m/(rad s)", (1, 2, -3)),
        ("W", (1, 2, -3)),
        ("1/Hz", (0, 0, 1)),
        ("step/rad^2", (0, 0, 0)),
        ("W^2/Hz", (2, 4, -5)),
        ("W²", (2, 4, -6)),
        ("(N m)²", (2, 4, -4)),
    ],
)
def test_what_a_unit_is_made_of(unit: str, powers: tuple[int, int, int]) -> None:
    assert dimension(unit) == powers


@pytest.mark.parametrize("unit", ["furlong", "N*m", "", "m^x"])
def test_an_unknown_unit_is_refused(unit: str) -> None:
    if unit:
        with pytest.raises(InputError, match="unit: expected products of"):
            dimension(unit)
    else:
        assert dimension(unit) == (0, 0, 0), "an empty product"


class _Arm(Section):
    length: Annotated[Positive, Unit("m")]
    mass: Positive


class _Crane(Section):
    arms: tuple[_Arm, ...]
    boom: _Arm | None = None
    load: float | None = None
    count: int = 1


class _Group(Settings):
    gain: float = setting(1.0, "A gain", unit="N/m")
    share: float = setting(0.5, "A share")


class _Options(Settings):
    group: _Group = _Group()
    name: str = setting("", "A word")


def test_what_has_no_unit_is_found_at_any_depth() -> None:
    assert list(numbers_without_unit(_Crane)) == ["arms.mass", "boom.mass", "load"]
    assert list(numbers_without_unit(_Options)) == ["group.share"]
    assert parameter_units(_Options) == {"group.gain": "N/m"}


def test_every_number_of_a_vessel_has_a_unit() -> None:
    assert list(numbers_without_unit(Vessel)) == []


def test_every_number_of_a_scenario_has_a_unit() -> None:
    assert list(numbers_without_unit(Scenario)) == []


@pytest.mark.parametrize("node", sorted(default_settings(load_vessel("cybership3"))))
def test_every_parameter_has_a_unit(node: str) -> None:
    settings = type(default_settings(load_vessel("cybership3"))[node])
    assert list(numbers_without_unit(settings)) == []
    for unit in parameter_units(settings).values():
        for part in unit.split(","):
            dimension(part)  # raises where it is not known
