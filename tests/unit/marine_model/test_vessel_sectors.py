"""Sectors and supervisor numbers in vessel files: what is read, and what is refused by file, line and field."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from marine_model import load_vessel
from marine_model.errors import DocumentError
from marine_model.load import vessel_path
from marine_model.schema import FieldError
from marine_model.sector import Sector, check_sectors

SHIPPED = vessel_path("cybership3").read_text(encoding="utf-8")
DEGREE = math.pi / 180.0


def sector(start: float, end: float) -> Sector:
    """A forbidden sector, from degrees."""
    return Sector(start=math.radians(start), end=math.radians(end), kind="forbidden")


def test_figure_6_2() -> None:
    vessel = load_vessel("cybership3")
    found = [
        [(round(s.start / DEGREE, 9), round(s.end / DEGREE, 9), s.kind, s.thrust_factor) for s in sectors]
        for sectors in vessel.sectors
    ]
    assert found == [
        [],
        [(-30.0, 30.0, "forbidden", 1.0)],
        [(-110.0, -70.0, "forbidden", 1.0), (159.0, -150.0, "forbidden", 1.0)],
        [(70.0, 110.0, "forbidden", 1.0), (150.0, -159.0, "forbidden", 1.0)],
    ]


def test_tables_6_2_and_6_3() -> None:
    allocator = load_vessel("cybership3").allocator
    assert allocator.sectors is not None
    assert (allocator.sectors.dwell_time, allocator.sectors.hysteresis) == (3.0, 0.04)
    rotating = allocator.fixed_rotating
    assert rotating is not None
    assert (rotating.force_limit, rotating.hysteresis, rotating.dwell_time) == (1.5, 0.2, 5.0)
    assert rotating.filter_frequency == 1.0 / rotating.dwell_time  # the reason that the file gives


def edited(folder: Path, *changes: tuple[str, str]) -> Path:
    text = SHIPPED
    for right, wrong in changes:
        assert right in text
        text = text.replace(right, wrong, 1)
    path = folder / "ship.yaml"
    path.write_text(text, encoding="utf-8")
    return path


BOW = "{start: -0.5235987755982988, end: 0.5235987755982988, kind: forbidden}"

# What stands in place of the bow thruster's sector, field that is blamed, message.
WRONG = [
    ("{start: 0.5, end: 0.5, kind: forbidden}", ".0", "expected start and end that differ, found 0.5 and 0.5"),
    (
        "{start: 3.141592653589793, end: -3.141592653589793, kind: forbidden}",
        ".0",
        "expected start and end that differ, found 3.141592653589793 and -3.141592653589793",
    ),
    ("{start: 0.5, end: 3.5, kind: forbidden}", ".0.end", "Input should be less than or equal to 3.14159"),
    ("{start: -30, end: 0.5, kind: forbidden}", ".0.start", "Input should be greater than or equal to -3.14159"),
    ("{start: -0.5, end: 0.5, kind: closed}", ".0.kind", "Input should be 'forbidden' or 'reduced', found 'closed'"),
    (
        "{start: -0.5, end: 0.5, kind: forbidden, thrust_factor: 1.1}",
        ".0.thrust_factor",
        "Input should be less than or equal to 1, found 1.1",
    ),
    (
        "{start: -0.5, end: 0.5, kind: reduced, thrust_factor: -0.1}",
        ".0.thrust_factor",
        "Input should be greater than or equal to 0, found -0.1",
    ),
    (
        "{start: -0.5, end: 0.5, kind: reduced}",
        ".0.thrust_factor",
        "a reduced sector has to say how much thrust is left",
    ),
    (
        "{start: -0.5, end: 0.5, kind: forbidden}\n        - {start: 0.4, end: 0.6, kind: forbidden}",
        ".1",
        "must not overlap another sector, found 0.4 to 0.6 beside sectors.0, -0.5 to 0.5",
    ),
    (
        "{start: 3.0, end: -3.0, kind: forbidden}\n"
        "        - {start: -3.1, end: -2.0, kind: reduced, thrust_factor: 0.5}",
        ".1",
        "must not overlap another sector, found -3.1 to -2.0 beside sectors.0, 3.0 to -3.0",
    ),
    (
        "{start: -3.141592653589793, end: 3.141592653589793, kind: forbidden}",
        "",
        "together they forbid every direction",
    ),
    (
        "{start: -2.0, end: 2.0, kind: forbidden}\n        - {start: 2.0, end: -2.0, kind: forbidden}",
        "",
        "together they forbid every direction",
    ),
]


@pytest.mark.parametrize(("sectors", "place", "message"), WRONG, ids=[w[2][:60] for w in WRONG])
def test_wrong_sectors_are_named(tmp_path: Path, sectors: str, place: str, message: str) -> None:
    path = edited(tmp_path, (BOW, sectors))
    with pytest.raises(DocumentError) as caught:
        load_vessel(path)
    (found,) = str(caught.value).splitlines()
    assert f": thrusters.1.azimuth.sectors{place}: {message}" in found
    line = path.read_text().splitlines()[int(found.removeprefix(f"{path}:").split(":")[0]) - 1]
    assert "start:" in line or "sectors:" in line


def test_a_fixed_direction_in_a_forbidden_sector(tmp_path: Path) -> None:
    path = edited(tmp_path, (BOW, "{start: 1.0, end: 2.0, kind: forbidden}"))
    with pytest.raises(DocumentError) as caught:
        load_vessel(path)
    assert "thrusters.1.azimuth.fixed: must not lie in a forbidden sector, found 1.57079632679" in str(caught.value)
    load_vessel(edited(tmp_path, (BOW, "{start: 1.0, end: 2.0, kind: reduced, thrust_factor: 0.3}")))
    load_vessel(edited(tmp_path, (BOW, "{start: 1.5707963267948966, end: 2.0, kind: forbidden}")))  # its end is allowed


def test_sectors_need_the_numbers_of_the_supervisor(tmp_path: Path) -> None:
    line = "  sectors: {dwell_time: 3.0, hysteresis: 0.04}"
    with pytest.raises(DocumentError) as caught:
        load_vessel(edited(tmp_path, (line, "  #")))
    assert "allocator: expected a field 'sectors', because thruster 'azimuth_bow' has sectors" in str(caught.value)


def test_both_sections_may_be_left_out(tmp_path: Path) -> None:
    text = "extends: cybership3\nthrusters:\n"
    for name in ("azimuth_bow", "azimuth_port", "azimuth_starboard"):
        text += f"  - {{name: {name}, azimuth: {{sectors: []}}}}\n"
    path = tmp_path / "ship.yaml"
    path.write_text(text + "allocator: {sectors: null, fixed_rotating: null}\n")
    vessel = load_vessel(path)
    assert vessel.sectors == ((), (), (), ())
    assert vessel.allocator.sectors is None
    assert vessel.allocator.fixed_rotating is None


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("dwell_time: 3.0", "dwell_time: -3.0", "allocator.sectors.dwell_time: Input should be greater than or equal"),
        ("hysteresis: 0.04", "hysteresis: -0.04", "allocator.sectors.hysteresis: Input should be greater than or"),
        ("filter_frequency: 0.2", "filter_frequency: 0.0", "fixed_rotating.filter_frequency: Input should be greater"),
        ("force_limit: 1.5", "force_limit: 0.2", "allocator.fixed_rotating: hysteresis must be below force_limit"),
    ],
)
def test_wrong_numbers_of_the_supervisors(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    with pytest.raises(DocumentError) as caught:
        load_vessel(edited(tmp_path, (right, wrong)))
    (found,) = str(caught.value).splitlines()
    assert message in found


whole_degrees = st.integers(-180, 180)


@given(whole_degrees, whole_degrees, whole_degrees)
def test_has_inside_is_what_counting_degrees_says(start: int, end: int, angle: int) -> None:
    if (end - start) % 360 == 0:
        return
    inside = 0 < (angle - start) % 360 < (end - start) % 360
    assert sector(start, end).has_inside(math.radians(angle)) == inside


@given(st.lists(whole_degrees, min_size=4, max_size=4))
def test_overlap_is_what_counting_degrees_says(ends: list[int]) -> None:
    a, b, c, d = ends
    if (b - a) % 360 == 0 or (d - c) % 360 == 0:
        return
    one = {(a + k) % 360 for k in range((b - a) % 360)}
    other = {(c + k) % 360 for k in range((d - c) % 360)}
    overlapping = bool(one & other)
    assert sector(a, b).overlaps(sector(c, d)) == overlapping
    assert sector(c, d).overlaps(sector(a, b)) == overlapping
    if overlapping:
        with pytest.raises(FieldError, match="must not overlap"):
            check_sectors([sector(a, b), sector(c, d)], 0.0)


def test_the_whole_circle() -> None:
    assert sector(-180, 180).width == pytest.approx(2.0 * math.pi)
    assert sector(159, -150).width == pytest.approx(51 * DEGREE)
