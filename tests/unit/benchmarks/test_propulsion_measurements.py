"""The bench of the propulsion plant measures what it says."""

from __future__ import annotations

from pathlib import Path

from benchmarks.mixed_propellers import with_every_model
from benchmarks.plan import quick
from benchmarks.propulsion import measure_propulsion
from marine_model import load_vessel
from marine_model.propellers import PropellerModel


def test_every_model_is_measured_and_all_agree(tmp_path: Path) -> None:
    rows = {row.name: row for row in measure_propulsion(quick(tmp_path))}
    for model in ("own", "mixed", "bollard", "wageningen_b", "tabulated", "four_quadrant"):
        step = rows[f"propulsion_step_{model}"]
        assert step.value > 0.0
        assert step.peer_value is not None
        # Many at once cost less each than one call for one: that is what the step is for.
        assert step.value < step.peer_value
        assert rows[f"propulsion_agreement_{model}"].value <= 1e-12
        assert rows[f"propulsion_agreement_{model}"].met
        assert rows[f"propulsion_step_{model}_in_one_thread"].value > 0.0
        assert (step.aim is not None) == (model == "own")


def test_the_mixed_vessel_has_every_model() -> None:
    vessel = with_every_model(load_vessel("cybership3"))
    kinds = {type(model) for model in vessel.propeller_models}
    assert len(kinds) == len(vessel.propeller_models)
    assert all(issubclass(kind, PropellerModel) for kind in kinds)
    assert [thruster.pitch is not None for thruster in vessel.thrusters] == [False, True, False, True]
