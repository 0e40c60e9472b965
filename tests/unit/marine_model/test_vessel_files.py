"""Vessel files: what is shipped, and everything that is refused, by file, line and field."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from marine_model import Vessel, load_vessel, vessel_names
from marine_model.errors import DocumentError, DpError, UnknownNameError
from marine_model.load import vessel_path

SHIPPED = vessel_path("cybership3").read_text(encoding="utf-8")


def write(folder: Path, text: str, name: str = "ship.yaml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def line_of(text: str, fragment: str) -> int:
    """Number of the first line that contains ``fragment``."""
    return next(i for i, line in enumerate(text.splitlines(), start=1) if fragment in line)


def problems(path: Path) -> list[str]:
    with pytest.raises(DocumentError) as caught:
        load_vessel(path)
    assert isinstance(caught.value, DpError)
    return str(caught.value).splitlines()


def test_what_is_shipped() -> None:
    models = "cybership3", "cybership3_ch7", "cybership3_trimmed"
    ships = "cybership3_full_scale", "cybership3_trimmed_full_scale", "drillship"
    submerged = "ukwial", "ukwial_azimuth", "mmt300"
    assert set(vessel_names()) == {*models, *ships, *submerged}
    for name in vessel_names():
        vessel = load_vessel(name)
        assert isinstance(vessel, Vessel)
        assert vessel.name == name


def test_appendix_b_numbers() -> None:
    vessel = load_vessel("cybership3")
    np.testing.assert_array_equal(vessel.lever_x, [0.84, 0.76, -0.81, -0.81])  # (B.21)
    np.testing.assert_array_equal(vessel.lever_y, [0.0, 0.0, -0.11, 0.11])  # (B.22)
    # (B.23) prints a minus sign before the bracket as well as inside it; the tunnel thruster shows which is meant.
    np.testing.assert_array_equal(vessel.thrust_min, [-0.47, -4.7, -10.1, -9.0])
    np.testing.assert_array_equal(vessel.thrust_max, [0.58, 8.7, 13.5, 13.0])  # (B.24)
    np.testing.assert_allclose(vessel.thrust_rate * 0.2, 0.2 * vessel.thrust_max)  # (B.25), a sample of 0.2 s
    np.testing.assert_allclose(vessel.azimuth_rate * 0.2, [0.0, 0.21, 0.21, 0.21])  # (B.27)
    np.testing.assert_allclose(np.degrees(vessel.fixed_direction), [90, 90, 45, -45])  # Table 4.2
    assert vessel.can_rotate == (False, True, True, True)
    assert vessel.observer.mass[2] == (0.0, -1.07, 14.7)  # (B.6)
    assert vessel.observer.damping[1] == (0.0, 19.3, 0.59)  # (B.7)
    assert vessel.observer.bias_time_constant == (1e7, 1e7, 1e7)  # (B.10)
    assert vessel.observer.bias_gain == (25.0, 20.0, 25.0)  # (B.12)
    assert vessel.observer.velocity_gain == (300.0, 300.0, 188.0)  # (B.13)
    assert vessel.controller.proportional == (75.0, 77.0, 15.0)  # (B.17)
    assert vessel.allocator.thrust_weight == (14.0, 1.2, 0.85, 0.87)  # (B.32)


def test_chapter_7_differs_in_its_lever_arms_only() -> None:
    one, other = load_vessel("cybership3"), load_vessel("cybership3_ch7")
    np.testing.assert_array_equal(other.lever_x, [0.85, 0.55, -0.875, -0.875])
    np.testing.assert_array_equal(other.lever_y, [0.0, 0.0, -0.1225, 0.1225])
    a, b = one.model_dump(), other.model_dump()
    for dump in (a, b):
        del dump["name"], dump["description"]
        for thruster in dump["thrusters"]:
            del thruster["position"]
    assert a == b


def test_arrays_cannot_be_changed() -> None:
    vessel = load_vessel("cybership3")
    with pytest.raises(ValueError, match="read-only"):
        vessel.lever_x[0] = 1.0
    with pytest.raises(ValueError, match="frozen"):
        vessel.name = "other"


def leaves(value: Any, place: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    if isinstance(value, dict):
        return [leaf for key, child in value.items() for leaf in leaves(child, (*place, key))]
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [leaf for i, child in enumerate(value) for leaf in leaves(child, (*place, i))]
    return [place]


CONTENT = yaml.safe_load(re.sub(r"([0-9])e([0-9])", r"\1e+\2", SHIPPED))
LEAVES = leaves(CONTENT)
# Of drift_coefficient and response one is needed: test_wave_response.py.
OPTIONAL = ("trim", "thrust_slope", "torque_slope", "drift_coefficient", "response", "drift_factor")
OPTIONAL_PLACES = (("wind_forces", "density"),)
# They say which fields are to come, and are missed by the section that they are in.
TAGS = ("type", "model")


def without(place: tuple[str | int, ...]) -> dict[str, Any]:
    content = copy.deepcopy(CONTENT)
    at = content
    for part in place[:-1]:
        at = at[part]
    del at[place[-1]]
    return dict(content)


def with_value(place: tuple[str | int, ...], value: Any) -> dict[str, Any]:
    content = copy.deepcopy(CONTENT)
    at = content
    for part in place[:-1]:
        at = at[part]
    at[place[-1]] = value
    return dict(content)


@pytest.mark.parametrize(
    "place",
    [leaf for leaf in LEAVES if leaf[-1] not in OPTIONAL and leaf not in OPTIONAL_PLACES],
    ids=lambda place: ".".join(map(str, place)),
)
def test_a_missing_field_is_named(tmp_path: Path, place: tuple[str | int, ...]) -> None:
    text = yaml.safe_dump(without(place), sort_keys=False)
    path = write(tmp_path, text)
    found = problems(path)
    if place[-1] in TAGS:
        assert len(found) == 1
        assert found[0].endswith(f"{'.'.join(map(str, place[:-1]))}: expected a field '{place[-1]}'")
    else:
        assert f"{'.'.join(map(str, place))}: Field required" in found[0]
    assert re.match(re.escape(str(path)) + r":\d+: ", found[0])


@pytest.mark.parametrize("place", LEAVES, ids=lambda place: ".".join(map(str, place)))
def test_a_value_of_the_wrong_kind_is_named_with_its_line(tmp_path: Path, place: tuple[str | int, ...]) -> None:
    text = yaml.safe_dump(with_value(place, {"wrong": "kind"}), sort_keys=False)
    path = write(tmp_path, text)
    found = problems(path)
    field = ".".join(map(str, place if place[-1] not in TAGS else place[:-1]))
    assert any(re.match(re.escape(f"{path}:") + r"\d+: " + re.escape(field) + r"[.:]", line) for line in found), found


NUMBERS = [place for place in LEAVES if place[-1] not in ("name", *TAGS, "description", "kind", "thrusters")]


@pytest.mark.parametrize("place", NUMBERS, ids=lambda place: ".".join(map(str, place)))
def test_nothing_but_numbers_for_numbers(tmp_path: Path, place: tuple[str | int, ...]) -> None:
    value = CONTENT
    for part in place:
        value = value[part]
    words: Any = "much"
    if isinstance(value, list) and isinstance(value[0], list):
        words = [["much"] * 3] * 3
    elif isinstance(value, list):
        words = ["much"] * len(value)
    found = problems(write(tmp_path, yaml.safe_dump(with_value(place, words))))
    assert all("found 'much'" in line for line in found)
    assert len(found) == np.array(words).size


@pytest.mark.parametrize(
    "place",
    [(), ("hull",), ("thrusters", 0), ("thrusters", 2, "thrust"), ("observer",), ("drivers", "azimuth")],
    ids=str,
)
def test_an_extra_field_is_named(tmp_path: Path, place: tuple[str | int, ...]) -> None:
    path = write(tmp_path, yaml.safe_dump(with_value((*place, "colour"), "red"), sort_keys=False))
    (found,) = problems(path)
    field = ".".join(map(str, (*place, "colour")))
    line = line_of(path.read_text(), "colour: red")
    assert found == f"{path}:{line}: {field}: Extra inputs are not permitted, found 'red'"


# Replace one fragment of the shipped file; expect one problem at the line of the second column, with this text.
WRONG = [
    (
        "thrust: {min: -4.7, max: 8.7",
        "thrust: {min: 9.7, max: 8.7",
        "thrusters.1.thrust: thrust.min must be below thrust.max, found 9.7 and 8.7",
    ),
    (
        "thrust: {min: -4.7, max: 8.7",
        "thrust: {min: 1.0, max: 8.7",
        "thrusters.1.thrust: thrust.min must not be above 0, found 1.0",
    ),
    (
        "thrust: {min: -4.7, max: 8.7",
        "thrust: {min: -4.7, max: -1.0",
        "thrusters.1.thrust.max: Input should be greater than 0, found -1.0",
    ),
    (
        "max: 8.7, rate: 8.7",
        "max: 8.7, rate: .nan",
        "thrusters.1.thrust.rate: Input should be a finite number, found nan",
    ),
    (
        "max: 8.7, rate: 8.7",
        "max: 8.7, rate: .inf",
        "thrusters.1.thrust.rate: Input should be a finite number, found inf",
    ),
    (
        "name: azimuth_bow",
        "name: Azimuth Bow",
        "thrusters.1.name: String should match pattern '^[a-z][a-z0-9_]*$', found 'Azimuth Bow'",
    ),
    (
        "position: [0.76, 0.0, 0.19]",
        "position: [0.76, 0.0]",
        "thrusters.1.position.2: Field required",
    ),
    (
        "position: [0.76, 0.0, 0.19]",
        "position: [0.76, port, 0.19]",
        "thrusters.1.position.1: Input should be a valid number, found 'port'",
    ),
    (
        "position: [0.76, 0.0, 0.19]",
        "position: [0.76, true, 0.19]",
        "thrusters.1.position.1: Input should be a valid number, found True",
    ),
    (
        "fixed: 0.78",
        "fixed: 45.78",
        "thrusters.2.azimuth.fixed: Input should be less than or equal to 3.141592653589793, found 45.78539816339744",
    ),
    (
        "type: tunnel",
        "type: waterjet",
        "thrusters.0: Input tag 'waterjet' found using 'type' does not match any of the expected tags: "
        "'tunnel', 'azimuth', 'fixed'",
    ),
    (
        "scale: 30.0",
        "scale: 1:30",
        "scale: Input should be a valid number, found '1:30'",
    ),
    (
        "scale: 30.0",
        "scale: -30.0",
        "scale: Input should be greater than 0, found -30.0",
    ),
    (
        "density: 1000.0",
        "density: ",
        "density: Input should be a valid number, found None",
    ),
    (
        "degrees_of_freedom: [surge, sway, yaw]",
        "degrees_of_freedom: [surge, heave, yaw]",
        "degrees_of_freedom: expected surge, sway, yaw without a section underwater, found surge, heave, yaw",
    ),
    (
        "wave_damping: [0.1, 0.1, 0.1]",
        "wave_damping: [0.1, 1.5, 0.1]",
        "observer: wave_damping must be below notch_damping in every axis, found [0.1, 1.5, 0.1] and [1.0, 1.0, 1.0]",
    ),
    (
        "cutoff_ratio: [1.22, 1.22, 1.22]",
        "cutoff_ratio: [1.22, 0.9, 1.22]",
        "observer: cutoff_ratio must be above 1, found [1.22, 0.9, 1.22]",
    ),
    (
        "[0.0, 77.0, -1.07]",
        "[0.0, 77.0, 1.07]",
        "observer: mass must be symmetric",
    ),
    (
        "mass: [[75.0, 0.0, 0.0], [0.0, 77.0, -1.07]",
        "mass: [[-75.0, 0.0, 0.0], [0.0, 77.0, -1.07]",
        "observer: mass must be positive definite",
    ),
    (
        "damping: [[6.9, 0.0, 0.0], [0.0, 19.3, 0.59], [0.0, 0.59, 6.8]]\n",
        "damping: [[0.0, 0.0, 0.0], [0.0, 19.3, 0.59], [0.0, 0.59, 6.8]]\n",
        "observer: damping must be positive definite",
    ),
    (
        "linear_damping: [[6.9,",
        "linear_damping: [[-6.9,",
        "manoeuvring: linear_damping must be positive definite",
    ),
    (
        "added_mass: [[6.2, 0.0, 0.0]",
        "added_mass: [[6.2, 5.0, 0.0]",
        "manoeuvring: rigid_body_mass + added_mass must be symmetric",
    ),
    (
        "added_mass: [[6.2,",
        "added_mass: [[-90.0,",
        "manoeuvring: rigid_body_mass + added_mass must be positive definite",
    ),
    (
        "thrust_weight: [14.0, 1.2, 0.85, 0.87]",
        "thrust_weight: [14.0, 1.2, 0.85]",
        "allocator.thrust_weight: expected 4 numbers, one a thruster, found 3",
    ),
    (
        "approach_fraction: 0.9",
        "approach_fraction: 1.0",
        "allocator.approach_fraction: Input should be less than 1, found 1.0",
    ),
    (
        "dropout: 0.0",
        "dropout: 1.5",
        "measurement.dropout: Input should be less than or equal to 1, found 1.5",
    ),
    (
        "sample_time: 0.2",
        "sample_time: 0.21",
        "measurement.sample_time: expected a whole multiple of simulation.time_step, found 0.21 and 0.02",
    ),
    (
        "time_step: 0.02",
        "time_step: 0.0181818181818181818",
        "simulation.time_step: expected a whole number of nanoseconds, found 0.01818181818181818 s",
    ),
    (
        "mass: 89.0 ",
        "mass: 95.0 ",
        "manoeuvring.rigid_body_mass: expected hull.mass for surge and sway within 1 %, found [89.0, 89.0] and 95.0",
    ),
    (
        "azimuth_drive: {rate_max: 1.05",
        "azimuth_drive: {rate_max: 0.5",
        "thrusters.1: azimuth_drive.rate_max must not be below azimuth.rate, found 0.5 and 1.05",
    ),
    (
        "name: azimuth_starboard",
        "name: azimuth_port",
        "thrusters.3.name: every name must be unique, found 'azimuth_port' twice",
    ),
    (
        "    thrust: {min: -0.47",
        "    azimuth: {fixed: 0.0, rate: 1.0}\n    thrust: {min: -0.47",
        "thrusters.0.azimuth: Extra inputs are not permitted",
    ),
]


@pytest.mark.parametrize(("right", "wrong", "message"), WRONG, ids=[w[2][:50] for w in WRONG])
def test_a_contradiction_is_named_with_its_line(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    assert right in SHIPPED
    text = SHIPPED.replace(right, wrong, 1)
    path = write(tmp_path, text)
    (found,) = problems(path)
    assert message in found
    # The line is that of the field, of the section it is in, or of the thruster that contradicts itself.
    line = text.splitlines()[int(found.removeprefix(f"{path}:").split(":")[0]) - 1]
    names = [part for part in message.split(":")[0].split(".") if not part.isdigit()]
    assert any(f"{name}:" in line for name in names[-2:]) or (names == ["thrusters"] and line.startswith("  - "))


def test_all_lever_arms_zero(tmp_path: Path) -> None:
    text = re.sub(r"position: \[.*\]", "position: [0.0, 0.0, 0.0]", SHIPPED)
    (found,) = problems(write(tmp_path, text))
    assert "thrusters: all lever arms are zero, so that no yaw moment is possible" in found


def test_thrusters_that_cannot_give_every_direction(tmp_path: Path) -> None:
    content = dict(CONTENT)
    content["thrusters"] = [CONTENT["thrusters"][0]]
    content["allocator"] = CONTENT["allocator"] | {"thrust_weight": [14.0]}
    content["drivers"] = {key: value for key, value in CONTENT["drivers"].items() if key != "ventilation"}
    (found,) = problems(write(tmp_path, yaml.safe_dump(content)))
    assert "thrusters: together they cannot produce surge, sway and yaw independently" in found


def test_no_thrusters_at_all(tmp_path: Path) -> None:
    (found,) = problems(write(tmp_path, yaml.safe_dump(CONTENT | {"thrusters": []})))
    assert "thrusters: Tuple should have at least 1 item" in found


def test_every_problem_is_reported_at_once(tmp_path: Path) -> None:
    text = (
        SHIPPED.replace("scale: 30.0", "scale: none").replace("beam: 0.44", "beam: -0.44").replace("draught:", "draft:")
    )
    path = write(tmp_path, text)
    found = problems(path)
    assert {line.split(": ")[1] for line in found} == {"scale", "hull.beam", "hull.draught", "hull.draft"}
    assert f"{path}:{line_of(text, 'beam: -0.44')}: hull.beam: Input should be greater than 0, found -0.44" in found


@pytest.mark.parametrize("name", ["cybership4", "", "."])
def test_an_unknown_vessel_is_answered_with_the_known_ones(name: str) -> None:
    with pytest.raises(UnknownNameError) as caught:
        load_vessel(name)
    expected = f"vessel: expected a path or one of {', '.join(vessel_names())}, found '{name}'"
    assert str(caught.value) == expected


def test_a_path_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"vessel: no such file: .*ship\.yaml"):
        load_vessel(tmp_path / "ship.yaml")
    with pytest.raises(UnknownNameError, match="vessel: no such file"):
        load_vessel(tmp_path)


class TestExtends:
    """Files that say only what is different from another vessel."""

    def test_own_fields_win_and_the_rest_is_the_base(self, tmp_path: Path) -> None:
        path = write(
            tmp_path, "extends: cybership3\nname: mine\nhull: {beam: 0.5}\ncontroller:\n  integral: [0.0, 0.0, 0.0]\n"
        )
        vessel, base = load_vessel(path), load_vessel("cybership3")
        assert (vessel.name, vessel.hull.beam, vessel.hull.length) == ("mine", 0.5, base.hull.length)
        assert vessel.controller.integral == (0.0, 0.0, 0.0)
        assert vessel.controller.proportional == base.controller.proportional

    def test_thrusters_merge_by_name(self, tmp_path: Path) -> None:
        path = write(tmp_path, "extends: cybership3\nthrusters:\n  - name: azimuth_bow\n    thrust: {max: 9.0}\n")
        vessel = load_vessel(path)
        np.testing.assert_array_equal(vessel.thrust_max, [0.58, 9.0, 13.5, 13.0])
        np.testing.assert_array_equal(vessel.thrust_min, [-0.47, -4.7, -10.1, -9.0])

    def test_a_new_name_is_a_new_thruster(self, tmp_path: Path) -> None:
        fifth = CONTENT["thrusters"][0] | {"name": "tunnel_stern", "position": [-0.9, 0.0, 0.0]}
        content = {
            "extends": "cybership3",
            "thrusters": [fifth],
            "allocator": {"thrust_weight": [14, 1.2, 0.85, 0.87, 14]},
            "drivers": {"ventilation": {"speed_min": 5.0}},
        }
        vessel = load_vessel(write(tmp_path, yaml.safe_dump(content)))
        assert vessel.thruster_names[-1] == "tunnel_stern"
        assert vessel.lever_x.shape == (5,)

    def test_a_chain_of_files(self, tmp_path: Path) -> None:
        write(tmp_path, "extends: cybership3_ch7\nscale: 20.0\n", "middle.yaml")
        path = write(tmp_path, "extends: middle.yaml\ndensity: 1025.0\n", "top.yaml")
        vessel = load_vessel(path)
        assert (vessel.scale, vessel.density, vessel.lever_x[1]) == (20.0, 1025.0, 0.55)

    def test_itself(self, tmp_path: Path) -> None:
        path = write(tmp_path, "name: x\nextends: ship.yaml\n")
        assert problems(path) == [f"{path}:2: extends: a vessel file extends itself"]

    def test_a_loop_of_two(self, tmp_path: Path) -> None:
        one = write(tmp_path, "extends: two.yaml\n", "one.yaml")
        write(tmp_path, "extends: one.yaml\n", "two.yaml")
        assert problems(one) == [f"{one}:1: extends: a vessel file extends itself"]

    def test_an_unknown_base(self, tmp_path: Path) -> None:
        path = write(tmp_path, "name: x\nextends: cybership9\n")
        with pytest.raises(UnknownNameError) as caught:
            load_vessel(path)
        expected = f"vessel: expected a path or one of {', '.join(vessel_names())}, found 'cybership9'"
        assert str(caught.value) == f"{path}:2: extends: {expected}"

    @pytest.mark.parametrize("value", ["", "3", "[cybership3]"])
    def test_something_that_is_no_vessel(self, tmp_path: Path, value: str) -> None:
        path = write(tmp_path, f"extends: {value}\n")
        (found,) = problems(path)
        assert f"{path}:1: extends: expected a vessel, found" in found

    def test_a_problem_of_the_base_names_the_base(self, tmp_path: Path) -> None:
        base = write(tmp_path, "extends: cybership3\nname: base\nhull: {beam: -1.0}\n", "base.yaml")
        top = write(tmp_path, "extends: base.yaml\nhull: {length: much}\n", "top.yaml")
        assert problems(top) == [
            f"{top}:2: hull.length: Input should be a valid number, found 'much'",
            f"{base}:3: hull.beam: Input should be greater than 0, found -1.0",
        ]

    def test_a_name_twice(self, tmp_path: Path) -> None:
        text = "extends: cybership3\nthrusters:\n- {name: tunnel_bow}\n- {name: tunnel_bow, direction: 1.0}\n"
        path = write(tmp_path, text)
        assert problems(path) == [f"{path}:4: thrusters.1.name: every name must be unique, found 'tunnel_bow' twice"]

    def test_a_list_without_names_replaces_the_base_and_its_lines(self, tmp_path: Path) -> None:
        path = write(tmp_path, "extends: cybership3\nname: x\nthrusters:\n  - {position: [1.0, 0.0, 0.0]}\n")
        assert problems(path) == [f"{path}:4: thrusters.0: expected a field 'type'"]

    def test_lines_are_those_of_the_file_that_says_it(self, tmp_path: Path) -> None:
        path = write(
            tmp_path, "extends: cybership3\n\nthrusters:\n  - name: azimuth_port\n    thrust:\n      max: -1.0\n"
        )
        assert problems(path) == [f"{path}:6: thrusters.2.thrust.max: Input should be greater than 0, found -1.0"]
