"""Trial files: what is refused, with file, line and field."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from dp_tools.open_water.load import load_trial
from marine_model.errors import DocumentError, UnknownNameError
from support.open_water_files import DETECTION, TRIALS, VENTILATION, small_trial, write_trial

Change = Callable[[dict[str, Any]], object]
NAMES = sorted(path.stem for path in TRIALS.glob("*.yaml"))


@pytest.mark.parametrize("name", NAMES)
def test_every_trial_that_comes_with_the_project_is_valid(name: str) -> None:
    trial = load_trial(TRIALS / f"{name}.yaml")
    assert trial.name == name
    assert trial.source.startswith("[Ruth] ")


def test_the_list_is_whole() -> None:
    assert NAMES == [
        "anti_spin",
        "pitch_comparison",
        "section_3_7",
        "ventilation_fast",
        "ventilation_power",
        "ventilation_slow",
    ]


PITCH = {"min": 0.6, "max": 1.3, "rate": 0.2, "time_constant": 0.02}
SINE = {"mean": 1.0, "amplitude": 1.0, "period": 5.0}
VARIANT = {"title": "other", "thrust": {"mean": 100.0}}


def sweep(**changes: Any) -> dict[str, Any]:
    return {"kind": "mean_power", "window": [1.0, 2.0], "variants": [VARIANT], **changes}


CASES: list[tuple[Change, str]] = [
    (lambda d: d.update(colour="red"), r"colour: Extra inputs are not permitted"),
    (lambda d: d["propeller"].update(diameter=0.0), r"propeller\.diameter: .*greater than 0"),
    (lambda d: d["propeller"].update(pitch_ratio=2.0), r"propeller\.pitch_ratio: .*1\.4"),
    (
        lambda d: d["cases"][0].update(controller="autopilot"),
        r"cases\.0\.controller: Input should be 'shaft_speed'.*found 'autopilot'",
    ),
    (
        lambda d: d["cases"][0].update(controller="pitch"),
        r"cases\.0\.controller: 'pitch' works through the pitch; expected a section 'pitch'",
    ),
    (
        lambda d: (d.update(pitch=PITCH), d["cases"][0].update(controller="pitch", pitch_ratio=0.8)),
        r"cases\.0\.pitch_ratio: expected none, because 'pitch' works through the pitch, found one",
    ),
    (
        lambda d: d["cases"][1].update(shaft_speed=10.0),
        r"cases\.1\.shaft_speed: expected none with 'power', which holds no shaft speed",
    ),
    (lambda d: d["cases"][0].update(pitch_ratio=1.5), r"cases\.0\.pitch_ratio: expected a number from 0\.5 to 1\.4"),
    (lambda d: d["cases"][1].update(name="speed"), r"cases\.1\.name: every name must be unique, found 'speed' twice"),
    (
        lambda d: d["cases"][0].update(anti_spin=True),
        r"cases\.0\.anti_spin: expected a section 'gains\.ventilation', which detects; found none",
    ),
    (
        lambda d: (
            d.update(pitch=PITCH),
            d["gains"].update(ventilation=DETECTION),
            d["cases"][0].update(controller="pitch", anti_spin=True),
        ),
        r"cases\.0\.anti_spin: expected a fixed pitch, found 'pitch'",
    ),
    (
        lambda d: d["gains"].update(ventilation={**DETECTION, "speed_min": [5.0, 5.0]}),
        r"gains\.ventilation\.speed_min: expected 1 number, that of the thruster, found 2",
    ),
    (lambda d: d.update(anti_spin={"enabled": True}), r"anti_spin\.enabled: expected none: every case says"),
    (lambda d: d.update(pitch={**PITCH, "max": 1.6}), r"pitch: expected min and max from 0\.5 to 1\.4"),
    (lambda d: d.pop("thrust"), r"thrust: expected this section, because cases\.0 'speed' follows it; found none"),
    (lambda d: d.update(thrust={}), r"thrust: expected a mean or steps, found neither"),
    (lambda d: d["thrust"].update(steps=[[0.0, 1.0]]), r"thrust: expected a mean or steps, found both"),
    (lambda d: d["thrust"].update(amplitude=10.0), r"thrust\.period: expected a period, because there is an amplitude"),
    (
        lambda d: d.update(thrust={"steps": [[1.0, 50.0]]}),
        r"thrust\.steps: expected times that begin at 0 and increase, found \[1\.0\]",
    ),
    (
        lambda d: d.update(thrust={"steps": [[0.0, 50.0]], "amplitude": 1.0}),
        r"thrust\.steps: expected none beside amplitude and period",
    ),
    (
        lambda d: d["thrust"].update(mean=500.0),
        r"thrust: expected thrust within limits, 0 to 400 N, found 500 to 500 N",
    ),
    (
        lambda d: d["shaft"].update(torque_max=5.0),
        r"shaft\.torque_max: expected at least 14\.4 N m, .* found 5 \(case 'speed'\)",
    ),
    (
        lambda d: (
            d.update(pitch=PITCH),
            d["cases"][0].update(controller="torque_shaft_speed"),
            d["gains"].update(torque_shaft_speed={"torque_coefficient": 0.5}),
        ),
        r"cases\.0\.controller: drivers\.torque_shaft_speed\.torque_coefficient: expected .* found 0\.5",
    ),
    (
        lambda d: d.update(submergence_ratio=SINE),
        r"ventilation: expected this section, because there is 'submergence_ratio'; found none",
    ),
    (
        lambda d: d.update(ventilation=VENTILATION),
        r"submergence_ratio: expected this section, because there is 'ventilation'; found none",
    ),
    (
        lambda d: d["inflow"].update(waves={"spectrum": "regular", "amplitude": 0.1, "period": 2.0}),
        r"inflow\.depth: expected the depth of the shaft, because there are waves; found none",
    ),
    (
        lambda d: d["inflow"].update(
            depth=1.0, waves={"spectrum": "jonswap", "significant_height": 1.0, "peak_period": 5.0, "peakedness": 0.5}
        ),
        r"inflow\.waves\..*peakedness: Input should be greater than or equal to 1, found 0\.5",
    ),
    (
        lambda d: d["windows"].update(all=[1.0, 3.0]),
        r"windows\.all: expected 0 <= start < end <= 2, found \[1\.0, 3\.0\]",
    ),
    (
        lambda d: d["table"].update(window="some"),
        r"table\.window: expected a name out of windows \(all\), found 'some'",
    ),
    (lambda d: d.update(close_up="some"), r"close_up: expected a name out of windows \(all\), found 'some'"),
    (lambda d: d["table"].update(kinds=["beauty"]), r"table\.kinds\.0: Input should be 'corrected_mean_power'"),
    (
        lambda d: d["figures"][0].update(over="nobody"),
        r"figures\.0\.over: expected one of the cases speed, power, found 'nobody'",
    ),
    (
        lambda d: d["figures"].append(d["figures"][0]),
        r"figures\.1\.name: every name must be unique, found 'ratio' twice",
    ),
    (lambda d: d.update(sweep=sweep(thesis=[1.0])), r"sweep\.thesis: expected 2 numbers, one a case, found 1"),
    (lambda d: d.update(sweep=sweep(window=[2.0, 1.0])), r"sweep\.window: expected 0 <= start < end, found"),
    (
        lambda d: d.update(sweep=sweep(variants=[{"title": "much", "thrust": {"mean": 401.0}}])),
        r"sweep\.variants\.0\.thrust: expected thrust within limits",
    ),
    (lambda d: d.update(duration=2.005), r"duration: expected a whole multiple of time_step, 0\.01 s, found 2\.005"),
    (lambda d: d.update(series_step=0.001), r"series_step: expected a whole multiple of time_step"),
    (lambda d: d["cases"].clear(), r"cases: Tuple should have at least 1 item"),
]


@pytest.mark.parametrize(("change", "message"), CASES, ids=[message[:40] for _, message in CASES])
def test_refusals(change: Change, message: str, tmp_path: Path) -> None:
    document = small_trial()
    change(document)
    path = write_trial(tmp_path, document)
    with pytest.raises(DocumentError, match=rf"trial\.yaml:\d+: {message}"):
        load_trial(path)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"trial: no such file: .*nowhere\.yaml"):
        load_trial(tmp_path / "nowhere.yaml")
