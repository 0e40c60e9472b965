"""`dp propeller`: what it prints, what it writes, what it refuses."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from dp_tools.cli import app
from dp_tools.propeller.plots import pictures_of
from dp_tools.propeller.study import study
from dp_tools.propeller.subject import subject_of, subjects_of
from marine_model import load_vessel
from marine_model.load import vessel_path
from marine_model.propeller_file import load_propeller
from marine_model.propellers.optimal import advance_number, optimal_pitch
from marine_model.ventilation.static import VentilationModel
from support.dp_here import Dp, dp_here
from thruster_drivers.sensitivity import closed_form, nominal_coefficients
from thruster_drivers.sensitivity.efficiency import fixed_pitch, torque_shaft_speed

__all__ = ["dp_here"]

SHIP = load_vessel("cybership3")
B4_70 = load_propeller("wageningen_b4_70").propeller.build()


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with everything about the B4-70."""
    folder = tmp_path_factory.mktemp("made")
    answer = CliRunner().invoke(app, ["propeller", "--propeller", "wageningen_b4_70", "--output", str(folder)])
    assert answer.exit_code == 0, answer.output
    return folder / "wageningen_b4_70"


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    values = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows[1:]])
    return dict(zip(rows[0], values.T, strict=True))


def test_every_picture_shows_something(made: Path) -> None:
    pictures = sorted(path.name for path in made.glob("*.png"))
    assert pictures == [
        "controllers.png",
        "efficiency.png",
        "maps.png",
        "open_water.png",
        "sensitivity.png",
        "torque_shaft_speed.png",
    ]
    for name in pictures:
        image = matplotlib.image.imread(made / name)[..., :3].astype(np.float64)
        assert image.shape[0] > 300
        assert image.shape[1] > 700
        # Lines and letters: at least one point in a hundred is not white, and there are many colours.
        assert np.mean(np.any(image < 0.98, axis=-1)) > 0.01
        assert len(np.unique(image @ np.array([1.0, 3.0, 9.0]))) > 50


def test_numbers_in_the_files_are_those_of_the_functions(made: Path) -> None:
    content: dict[str, Any] = json.loads((made / "propeller.json").read_text(encoding="utf-8"))
    at_rest = (content["summary"]["thrust_coefficient"], content["summary"]["torque_coefficient"])
    assert at_rest == nominal_coefficients(B4_70)
    assert content["summary"]["bollard_pitch_ratio"] == float(optimal_pitch(B4_70, 0.0))
    assert content["summary"]["largest_loading"] is None  # no limit
    optimal = table(made / "optimal.csv")
    tau = optimal["tau"]
    np.testing.assert_array_equal(optimal["pitch_ratio"], optimal_pitch(B4_70, tau))
    K_T, K_Q = B4_70.coefficients(advance_number(B4_70, tau, optimal["pitch_ratio"]), optimal["pitch_ratio"])
    np.testing.assert_array_equal(optimal["h"], K_Q / K_T)
    np.testing.assert_array_equal(optimal["m"], 1.0 / np.sqrt(K_T))
    rows = {row["name"]: row for row in content["comparison"]}
    assert rows["fixed, largest pitch"]["relative"] == fixed_pitch(B4_70, tau, 1.4).relative
    assert rows["fixed, largest pitch"]["printed"] == [0.045, 0.24]
    K_Qc = content["torque_coefficients"]["least error"]
    assert rows["torque/shaft speed, least error"]["absolute"] == torque_shaft_speed(B4_70, tau, K_Qc).absolute
    sensitivity = table(made / "sensitivity_torque.csv")
    expected = closed_form.torque(B4_70, sensitivity["advance_number"])
    np.testing.assert_array_equal(sensitivity["thrust"], expected.thrust)
    np.testing.assert_array_equal(sensitivity["desired_loading"], expected.desired_loading)
    for name in (*content["tables"].values(), *content["pictures"]):
        assert (made / name).is_file()


def test_the_optimal_path_jumps_to_the_largest_pitch(made: Path) -> None:
    """Emergent: with the polynomials of 1975 at tau 2.04, from P/D 1.19; 2.61 with those of 1969."""
    content = json.loads((made / "propeller.json").read_text(encoding="utf-8"))
    assert content["full_pitch_tau"] == pytest.approx(2.036, abs=0.005)
    pitch = table(made / "optimal.csv")["pitch_ratio"]
    assert pitch[pitch < 1.4].max() < 1.2


def test_what_is_printed(dp_here: Dp, tmp_path: Path) -> None:
    code, output = dp_here("propeller", "--propeller", "wageningen_b4_70", "--no-plots", "--tau", "3")
    assert code == 0
    assert "tau 0 to 3 (Table 3.3)" in output
    assert re.search(r"torque/shaft speed, least error .* 1\.0 % .* 1\.3 % .* 1\.6 % .* 2\.3 %", output)
    assert re.search(r"K_Q at J = 0, design pitch .* 0\.0233 .* 0\.0226", output)
    assert re.search(r"tau of the best efficiency .* 3\.48 .* 3\.05", output)
    assert "no ventilation maps: there are no ventilation data" in output
    # Without plots and without a folder nothing is written.
    assert list(tmp_path.iterdir()) == []


def test_a_fixed_pitch_thruster(dp_here: Dp, tmp_path: Path) -> None:
    code, output = dp_here("propeller", "cybership3", "--thruster", "azimuth_port")
    assert code == 0
    assert "tunnel bow" not in output
    assert "azimuth_port: no efficiency over (tau, P/D), g, h, k, m, torque/shaft-speed control: the pitch is" in output
    folder = tmp_path / "propeller" / "cybership3" / "azimuth_port"
    assert output.rstrip().endswith(f"written {folder.parent}")
    content = json.loads((folder / "propeller.json").read_text(encoding="utf-8"))
    assert content["pictures"] == ["open_water.png", "sensitivity.png", "ventilation.png"]
    assert content["comparison"] == []
    ventilation = table(folder / "ventilation.csv")
    assert SHIP.ventilation is not None
    # The map is over F_nh2 and h/R; any shaft speed, diameter and pitch that give them will do.
    at = 5000
    F, x = ventilation["F_nh2"][at], ventilation["h_over_R"][at]
    D, pitch = 0.09, 0.93
    n = F / pitch * np.sqrt((1.0 + x) * 9.81 / D)
    losses = VentilationModel(SHIP.ventilation).loss_factors(n, D, pitch, x)
    assert float(losses.thrust) == pytest.approx(ventilation["beta_T"][at], rel=1e-9)
    assert float(losses.torque) == pytest.approx(ventilation["beta_Q"][at], rel=1e-9)


def test_numbers_without_pictures(dp_here: Dp, tmp_path: Path) -> None:
    code, _ = dp_here("propeller", "cybership3", "--no-plots", "--output", tmp_path / "numbers")
    assert code == 0
    assert sorted(path.name for path in (tmp_path / "numbers").iterdir()) == sorted(SHIP.thruster_names)
    assert list(tmp_path.rglob("*.png")) == []
    assert len(list(tmp_path.rglob("propeller.json"))) == len(SHIP.thrusters)


def test_a_propeller_known_at_rest_alone(dp_here: Dp, tmp_path: Path) -> None:
    (tmp_path / "one.yaml").write_text(
        "name: one\ndescription: a bollard propeller\ndensity: 1000.0\n"
        "propeller: {diameter: 1.0, pitch_ratio: 1.0, thrust_coefficient: 0.4, torque_coefficient: 0.05}\n",
        encoding="utf-8",
    )
    code, output = dp_here("propeller", "--propeller", "one.yaml")
    assert code == 0
    assert "no open-water curves: the propeller is known at zero advance alone" in output
    assert "no sensitivity functions: the propeller is known at zero advance alone" in output
    assert re.search(r"range of J .* 0 alone", output)
    content = json.loads((tmp_path / "propeller" / "one" / "one" / "propeller.json").read_text(encoding="utf-8"))
    assert content["pictures"] == []


def test_a_controllable_pitch_thruster_keeps_to_its_actuator(tmp_path: Path) -> None:
    document = yaml.safe_load(vessel_path("cybership3").read_text(encoding="utf-8"))
    document["name"] = "other"
    document["thrusters"][1]["propeller"] = {
        "model": "wageningen_b", "diameter": 0.06, "blades": 4, "area_ratio": 0.7, "pitch_ratio": 0.9,
    }  # fmt: skip
    document["thrusters"][1]["pitch"] = {"min": 0.6, "max": 1.1, "rate": 0.5, "time_constant": 0.1}
    document["thrusters"][1]["shaft"]["torque_max"] = 1.0
    path = tmp_path / "other.yaml"
    path.write_text(yaml.safe_dump(document), encoding="utf-8")
    (subject,) = subjects_of(load_vessel(path), "azimuth_bow")
    found = study(subject, 3.0)
    for one in found.paths.values():
        assert one.pitch_ratio.min() >= 0.6
        assert one.pitch_ratio.max() <= 1.1
    assert found.tables["open_water"]["pitch_ratio"].min() == 0.6
    assert "ventilation.png" in pictures_of(found)


@pytest.mark.parametrize(("torque_coefficient", "told"), [(0.0152, True), (0.045, False)])
def test_impossible_data_are_told(dp_here: Dp, tmp_path: Path, torque_coefficient: float, told: bool) -> None:
    """A thrust and a power that no propeller has."""
    (tmp_path / "one.yaml").write_text(
        "name: one\ndescription: linear in J\ndensity: 1000.0\npropeller: {diameter: 1.0, pitch_ratio: 0.8, "
        f"thrust_coefficient: 0.36, torque_coefficient: {torque_coefficient}, thrust_slope: -0.35, "
        "torque_slope: -0.01}\n",
        encoding="utf-8",
    )
    code, output = dp_here("propeller", "--propeller", "one.yaml", "--no-plots")
    assert code == 0
    assert ("one: the data contradict each other: efficiency" in output) is told


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("titanic",), 1, r"error: vessel: expected a path or one of .*found 'titanic'"),
        (
            ("cybership3", "--thruster", "rudder"),
            1,
            r"error: --thruster: expected one of tunnel_bow, azimuth_bow, .*, found 'rudder'",
        ),
        (("--propeller", "oar"), 1, r"error: propeller: expected a path or one of wageningen_b4_70, found 'oar'"),
        (("--propeller", "no/oar.yaml"), 1, r"error: propeller: no such file: no/oar\.yaml"),
        (("cybership3", "--tau", "-1"), 1, r"error: --tau: expected a number above 0, found -1"),
        (("cybership3", "--output", "a_file/x"), 1, r"error: .*a_file/x: cannot be written: Not a directory"),
        ((), 2, r"(?s).*expected a vessel, or --propeller NAME, and not both.*"),
        (("cybership3", "--propeller", "wageningen_b4_70"), 2, r"(?s).*expected a vessel, or --propeller NAME, and.*"),
        (("--propeller", "wageningen_b4_70", "--thruster", "x"), 2, r"(?s).*--thruster is of a vessel.*"),
    ],
)
def test_refusals(dp_here: Dp, tmp_path: Path, words: tuple[str, ...], code: int, message: str) -> None:
    (tmp_path / "a_file").touch()
    found, output = dp_here("propeller", *words)
    assert found == code
    assert re.fullmatch(message, output.strip()), output
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["a_file"]


def test_the_subject_of_a_file_has_its_figures() -> None:
    subject = subject_of(load_propeller("wageningen_b4_70"))
    assert subject.pitch_range == (0.5, 1.4)
    assert subject.printed is not None
    assert subject.printed.torque_coefficient == 0.0226
