"""Each peer does what it is timed for. Only those that are installed."""

import numpy as np
import pytest

from benchmarks.demands import Step, demand_in_waves, record
from benchmarks.peers.ipopt_peer import Ipopt
from benchmarks.peers.natural_form import natural_form
from benchmarks.peers.osqp_peer import NativeOsqp, OsqpThroughQpsolvers
from benchmarks.peers.peer import Peer, polar_form
from benchmarks.peers.pseudo_inverse_peer import PseudoInverse
from benchmarks.peers.quta_peer import EqualProblem, StaticSectors
from benchmarks.peers.slsqp_peer import Slsqp
from benchmarks.reference import optima
from benchmarks.sub_problems import record_sectors, sub_problems, window_counts
from marine_model import load_vessel
from marine_model.frames import wrap_angle
from marine_model.thruster_configuration import generalized_force
from thrust_allocator import AllocatorSettings
from thrust_allocator.sectors import vessel_sectors

VESSEL = load_vessel("cybership3")


def _steps(mode: str, size: float) -> list[Step]:
    demands = size * demand_in_waves(VESSEL, 60, 7)
    return record(VESSEL, AllocatorSettings(azimuth_mode=mode), demands, 0.2)


def _force_errors(peer: Peer, steps: list[Step]) -> tuple[list[float], int]:
    """Return the largest component off the optimum of each answer, and the number of failures."""
    errors, failures = [], 0
    for step, z in zip(steps, optima([step.problem for step in steps]), strict=True):
        commands = peer.commands(step, peer.solve(peer.prepare(step)))
        if commands is None:
            failures += 1
            continue
        force = generalized_force(VESSEL.lever_x, VESSEL.lever_y, *commands)
        errors.append(float(np.abs(force - step.problem.B @ z).max()))
    return errors, failures


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
@pytest.mark.parametrize("kind", [OsqpThroughQpsolvers, NativeOsqp, Slsqp])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_peers_on_the_program_find_its_optimum(mode: str, kind: type[Peer]) -> None:
    pytest.importorskip("osqp", reason="a peer of the benchmarks")
    steps = _steps(mode, 1.5)
    errors, failures = _force_errors(kind(), steps)
    # Few may fail, and are counted then; the others are as accurate as they were asked to be.
    assert failures <= 3
    assert max(errors) < 1e-3


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
def test_ipopt_gives_the_force_that_can_be_given(mode: str) -> None:
    pytest.importorskip("casadi", reason="an optional package of the benchmarks")
    # Where nothing is saturated, arcs or chords make no difference to the force.
    steps = [step for step in _steps(mode, 0.4) if np.abs(step.slack).max() < 1e-4]
    assert len(steps) > 30
    errors, failures = _force_errors(Ipopt(VESSEL, mode == "rotating"), steps)
    assert failures == 0
    assert np.median(errors) < 1e-6


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
def test_mcsimpython_gives_all_that_is_demanded(mode: str) -> None:
    pytest.importorskip("MCSimPython", reason="an optional package of the benchmarks")
    peer = PseudoInverse(VESSEL, mode == "rotating")
    for step in _steps(mode, 3.0):
        commands = peer.commands(step, peer.solve(peer.prepare(step)))
        assert commands is not None
        force = generalized_force(VESSEL.lever_x, VESSEL.lever_y, *commands)
        assert force == pytest.approx(step.tau, abs=1e-9)


def test_quta_finds_the_cheapest_of_the_same_sub_problems() -> None:
    pytest.importorskip("quta", reason="an optional package of the benchmarks")
    peer = EqualProblem(window_counts(VESSEL))
    for one in record_sectors(VESSEL, 1.5 * demand_in_waves(VESSEL, 15, 8), 0.2):
        answer = peer.solve(peer.prepare(sub_problems(one)))
        forces = peer.forces(answer)
        slack = one.step.tau - [*forces.sum(axis=0), VESSEL.lever_x @ forces[:, 1] - VESSEL.lever_y @ forces[:, 0]]
        weights = one.problems[0].weights
        cost = weights.slack @ slack**2 + weights.thrust @ (forces**2).sum(axis=1)
        assert cost == pytest.approx(one.cost, rel=1e-8, abs=1e-12)


def test_quta_as_it_comes_keeps_to_the_sectors_and_knows_no_rates() -> None:
    pytest.importorskip("quta", reason="an optional package of the benchmarks")
    peer = StaticSectors(VESSEL)
    demand = np.array([-8.0, 4.0, 0.5])
    forces = np.asarray(peer.solve(demand)[0]).reshape(-1, 2)
    moment = VESSEL.lever_x @ forces[:, 1] - VESSEL.lever_y @ forces[:, 0]
    assert [*forces.sum(axis=0), moment] == pytest.approx(demand, abs=0.05)
    # 12 N at once, from rest.
    assert np.hypot(*forces.T).max() > 1.1 * float(VESSEL.thrust_rate.max()) * 0.2
    for sectors, force in list(zip(vessel_sectors(VESSEL), forces, strict=True))[1:]:
        angle = float(np.arctan2(force[1], force[0]))
        assert any(abs(wrap_angle(angle - window.centre)) <= window.half_width + 1e-9 for window in sectors.windows)


@pytest.mark.parametrize("mode", ["fixed", "rotating"])
def test_the_natural_form_has_the_cost_of_the_thesis(mode: str) -> None:
    gains = VESSEL.allocator
    for step in _steps(mode, 1.0)[::10]:
        z = optima([step.problem])[0]
        form = natural_form(step.problem)
        slack = step.problem.slack(z)
        x = np.concatenate([z, slack])
        thrust, _ = polar_form(step, z)
        # (4.20): the squares of gamma W_v s and of W_u T.
        expected = np.sum((gains.slack_gain * np.array(gains.slack_weight) * slack) ** 2)
        expected += np.sum((np.array(gains.thrust_weight) * thrust) ** 2)
        assert 0.5 * x @ form.P @ x == pytest.approx(expected, rel=1e-9)
        assert form.E @ x == pytest.approx(form.tau, abs=1e-12)


def test_reverse_thrust_is_the_shorter_turn() -> None:
    step = _steps("rotating", 1.0)[-1]
    problem = step.problem
    j = problem.rotating[0]
    z = np.zeros(problem.variables)
    pointing = float(step.azimuth_before[j]) + 0.1
    z[problem.bounds : problem.bounds + 2] = -2.0 * np.cos(pointing), -2.0 * np.sin(pointing)
    thrust, azimuth = polar_form(step, z)
    assert thrust[j] == pytest.approx(-2.0)
    assert np.cos(azimuth[j] - pointing) == pytest.approx(1.0)
    # Without thrust it stays.
    assert azimuth[problem.rotating[1]] == step.azimuth_before[problem.rotating[1]]
