"""Methods beside the quadratic program, in the allocator: limits of every step, switching, what is told."""

from __future__ import annotations

from itertools import pairwise
from math import atan, cbrt, cos, degrees, radians, sin

import numpy as np
import pytest

from marine_model import load_vessel
from marine_model.errors import InputError
from marine_model.frames import wrap_angles
from marine_model.guards import FloatArray
from support.marching_thruster import drive_data
from thrust_allocator import AllocationResult, Allocator, AllocatorSettings, Status

UKWIAL, AZIMUTH, MMT300, SHIP = map(load_vessel, ("ukwial", "ukwial_azimuth", "mmt300", "cybership3"))
DT = 0.2
# Of [Garus-F]'s angles: surge, sway, yaw.
LIMITS = 1000.0 * np.array([cos(radians(29.0)), sin(radians(29.0)), 0.4 * sin(radians(55.5))])
ROUNDING = 1e-9  # N, N m, rad: sums of a few hundred newtons


def sail(allocator: Allocator, tau: FloatArray, steps: int) -> list[AllocationResult]:
    return [allocator.step(tau, DT) for _ in range(steps)]


def settings(vessel, **changes) -> AllocatorSettings:
    return AllocatorSettings.for_vessel(vessel, **changes)


def with_group(vessel, group: str, way: str, **changes) -> AllocatorSettings:
    base = settings(vessel, method=way)
    return base.model_copy(update={group: getattr(base, group).model_copy(update=changes)})


def test_example_of_garus_in_the_allocator() -> None:
    """From rest in three steps of rate; heave is a group of its own and costs nothing."""
    allocator = Allocator(UKWIAL, settings(UKWIAL, method="pseudo_inverse", feasible="proportional"))
    result = sail(allocator, np.array([700.0, -120.0, 480.0, 30.0]), 4)[-1]
    load = 700.0 / LIMITS[0] + 120.0 / LIMITS[1] + 30.0 / LIMITS[2]
    assert result.feasible_load == pytest.approx(load, rel=1e-9)
    expected = np.array([700.0 / load, -120.0 / load, 480.0, 30.0 / load])
    np.testing.assert_allclose(result.tau_feasible, expected, rtol=1e-9)
    np.testing.assert_allclose(result.tau_achieved, result.tau_feasible, atol=ROUNDING)
    assert np.abs(result.thrust).max() == pytest.approx(250.0, rel=1e-9)
    assert result.detail == "1.14 times the octahedron demanded"
    # What the thrusters could do: 668 N in that direction, by the closed form 1 / (surge + sway).
    assert result.margin.fixed == pytest.approx(0.9543, abs=1e-4)
    assert result.method == "pseudo_inverse"
    assert result.status is Status.OPTIMAL


def test_refused_by_the_octahedron_and_attained_by_the_program() -> None:
    tau = np.array([400.0, -200.0, 0.0, 100.0])
    allocator = Allocator(UKWIAL, settings(UKWIAL, method="pseudo_inverse", feasible="proportional"))
    result = sail(allocator, tau, 4)[-1]
    assert result.feasible_load > 1.17
    assert result.margin.fixed > 1.14
    np.testing.assert_allclose(result.tau_achieved, tau / result.feasible_load, atol=ROUNDING)
    # Slack of the program's weights: 1e-6 of the demand.
    np.testing.assert_allclose(result.tau_qp, tau, atol=1e-3)
    attained = sail(Allocator(UKWIAL), tau, 4)[-1]
    np.testing.assert_allclose(attained.tau_achieved, tau, atol=1e-3)


def test_priority_in_the_allocator() -> None:
    chosen = settings(UKWIAL, method="pseudo_inverse", feasible="priority")
    chosen = chosen.model_copy(update={"priority": chosen.priority.model_copy(update={"axis": "surge"})})
    result = sail(Allocator(UKWIAL, chosen), np.array([700.0, -120.0, 600.0, 50.0]), 4)[-1]
    assert result.tau_achieved[0] == pytest.approx(700.0)
    # Heave is not in the group of the kept axis.
    assert result.tau_achieved[2] == pytest.approx(500.0)
    left = (1.0 - 700.0 / LIMITS[0]) / (120.0 / LIMITS[1] + 50.0 / LIMITS[2])
    np.testing.assert_allclose(result.tau_achieved[[1, 3]], [-120.0 * left, 50.0 * left], rtol=1e-9)


def test_pseudo_inverse_alone_is_cut_by_its_limits() -> None:
    result = sail(
        Allocator(UKWIAL, settings(UKWIAL, method="pseudo_inverse")), np.array([700.0, -120.0, 0.0, 30.0]), 4
    )[-1]
    np.testing.assert_array_equal(result.tau_feasible, result.tau_desired)
    assert np.abs(result.thrust).max() == 250.0
    assert abs(result.slack).max() > 1.0


def test_azimuth_propellers_turn_together() -> None:
    """[Garus-A]'s example from 45 deg: no faster than the drive, yaw as asked on the way, tau' at the end."""
    start = AZIMUTH.fixed_direction.copy()
    angle = radians(45.0)
    start[:4] = [angle, -angle, np.pi - angle, angle - np.pi]
    allocator = Allocator(AZIMUTH, settings(AZIMUTH, method="garus_azimuth"), azimuth=start)
    assert allocator.settings.garus_azimuth.reserved_moment == pytest.approx(50.0)
    tau = np.array([700.0, -120.0, 0.0, 50.0])
    results = sail(allocator, tau, 10)
    angles = [start, *[result.azimuth for result in results]]
    for before, after in pairwise(angles):
        turn = wrap_angles(after - before)[:4]
        assert (np.abs(turn) <= AZIMUTH.azimuth_rate[:4] * DT + ROUNDING).all()
        np.testing.assert_allclose(np.abs(turn), np.abs(turn[0]), atol=ROUNDING)
    assert degrees(angles[1][0]) == pytest.approx(45.0 - degrees(DT), abs=1e-6)
    last = results[-1]
    np.testing.assert_allclose(np.degrees(last.azimuth[:4]), [29.1, -29.1, 150.9, -150.9], atol=0.05)
    np.testing.assert_allclose(last.tau_achieved, [501.0, -85.9, 0.0, 50.0], atol=0.5)
    np.testing.assert_allclose(last.tau_achieved, last.tau_feasible, atol=1e-6)
    # Three steps bring the thrusts up; from then on yaw is served whatever the angle.
    for result in results[3:]:
        assert result.tau_achieved[3] == pytest.approx(50.0, abs=1e-6)
    assert np.abs(last.thrust).max() <= 250.0 * (1.0 + 1e-12)
    assert last.feasible_load == pytest.approx(700.0 / 500.75, abs=1e-3)


def test_the_slip_of_step_2_and_its_repair() -> None:
    # With the reserved moment in use: 937 / 4 N and 36 N of every propeller at 29 deg.
    tau = np.array([100.0, 400.0, 0.0, 50.0])
    for rule, served in (("as_printed", False), ("as_needed", True)):
        allocator = Allocator(AZIMUTH, with_group(AZIMUTH, "garus_azimuth", "garus_azimuth", angle_rule=rule))
        result = sail(allocator, tau, 12)[-1]
        assert result.feasible_load < 1.0
        if served:
            np.testing.assert_allclose(result.tau_achieved, tau, atol=1e-6)
            # Only as far as it must: the present angle serves before the best one is reached.
            assert radians(29.0) < result.azimuth[0] <= atan(cbrt(4.0))
        else:
            assert result.azimuth[0] == pytest.approx(radians(29.0))
            assert 0.85 * 400.0 < result.tau_achieved[1] < 0.95 * 400.0
            assert result.tau_achieved[3] == pytest.approx(50.0)
            assert "at the present angles" in result.detail


def test_angles_stay_without_a_demand_and_with_one_that_they_serve() -> None:
    allocator = Allocator(AZIMUTH, settings(AZIMUTH, method="garus_azimuth"))
    start = allocator.step(np.zeros(4), DT).azimuth
    for tau in (np.zeros(4), np.array([100.0, 20.0, 30.0, 10.0])):
        for result in sail(allocator, tau, 5):
            np.testing.assert_array_equal(result.azimuth, start)
    assert result.feasible_load < 1.0
    np.testing.assert_allclose(result.tau_achieved, tau, atol=ROUNDING)


def test_yaw_beyond_the_reserved_moment_is_told() -> None:
    result = sail(Allocator(AZIMUTH, settings(AZIMUTH, method="garus_azimuth")), np.array([0.0, 0.0, 0.0, 80.0]), 4)[-1]
    assert result.tau_achieved[3] == pytest.approx(50.0)
    assert result.detail == "yaw of 80 N m is beyond the reserved 50 N m"
    assert result.feasible_load == pytest.approx(1.6)


def test_portions_in_the_allocator() -> None:
    chosen = with_group(MMT300, "portions", "portioned", surge=0.6, yaw=0.4, pitch=0.4)
    delta = radians(22.5)
    tau = np.array([500.0, 3.0, 2.0, -4.0])
    result = sail(Allocator(MMT300, chosen), tau, 6)[-1]
    surge = 4.0 * cos(delta) * 0.6 * 42.0
    np.testing.assert_allclose(result.tau_achieved, [surge, 3.0, 2.0, -4.0], atol=ROUNDING)
    assert result.feasible_load == pytest.approx(500.0 / surge)
    # Yaw of the stern thrusters pushes it sideways: the by-product F_z of (5).
    np.testing.assert_allclose(result.wrench, [surge, 4.0, 3.0, 0.0, 2.0, -4.0], atol=ROUNDING)


def test_portions_and_their_independence_in_the_allocator() -> None:
    """A surge demand from nothing to all there is leaves heave, pitch and yaw as they are."""
    chosen = with_group(MMT300, "portions", "portioned", surge=0.6, yaw=0.4, pitch=0.4)
    allocator = Allocator(MMT300, chosen)
    sail(allocator, np.array([0.0, 3.0, 2.0, -4.0]), 4)
    for surge in (10.0, 60.0, 90.0, 1000.0):
        # The rate of thrust lets 16.8 N more of every thruster through in a step: some steps to get there.
        result = sail(allocator, np.array([surge, 3.0, 2.0, -4.0]), 4)[-1]
        np.testing.assert_allclose(result.tau_achieved[1:], [3.0, 2.0, -4.0], atol=ROUNDING)


@pytest.mark.parametrize("vessel", [UKWIAL, AZIMUTH, MMT300])
def test_no_switch_and_no_failure_leads_beyond_a_limit(vessel) -> None:
    """Random demands, methods, failures and limits: windows of thrust and azimuth rate hold in every step."""
    rng = np.random.default_rng(3)
    methods = {"ukwial": [], "ukwial_azimuth": ["garus_azimuth"], "mmt300": ["portioned"]}[vessel.name]
    methods = ["qp", "pseudo_inverse", *methods]
    n, m = len(vessel.thrusters), len(vessel.degrees_of_freedom)
    allocator = Allocator(vessel)
    size = np.abs(vessel.columns).sum(axis=(0, 2)) * vessel.thrust_max.max()
    thrust, azimuth = np.zeros(n), vessel.fixed_direction
    approach = vessel.allocator.approach_fraction
    for _ in range(40):
        enabled = rng.random(n) > 0.15
        scale = np.where(rng.random(n) > 0.2, 1.0, rng.random(n))
        chosen = settings(
            vessel,
            method=str(rng.choice(methods)),
            feasible=str(rng.choice(["none", "proportional", "priority"])),
            azimuth_mode=str(rng.choice(["fixed", "rotating"])),
            thruster_enabled=tuple(enabled.tolist()),
            azimuth_enabled=tuple((rng.random(n) > 0.1).tolist()),
            thrust_limit_scale=tuple(scale.tolist()),
            compare_qp=bool(rng.random() > 0.5),
        )
        allocator.apply(chosen)
        allocator.measure_azimuth(azimuth)
        tau = rng.normal(size=m) * size * rng.choice([0.0, 0.1, 1.0])
        for _ in range(3):
            result = allocator.step(tau, DT)
            assert result.status in (Status.OPTIMAL, Status.NO_THRUSTER)
            step = vessel.thrust_rate * DT
            assert (np.abs(result.thrust - thrust) <= step + ROUNDING).all()
            turn = np.abs(wrap_angles(result.azimuth - azimuth))
            assert (turn <= vessel.azimuth_rate * DT + ROUNDING).all()
            limit = scale * vessel.thrust_max
            back = np.maximum(limit, np.abs(thrust) - approach * step)
            assert (np.abs(result.thrust)[enabled] <= back[enabled] + ROUNDING).all()
            assert np.isfinite(result.tau_achieved).all()
            thrust, azimuth = result.thrust, result.azimuth


def test_a_lost_propeller_leaves_the_others_to_the_pseudo_inverse() -> None:
    chosen = settings(AZIMUTH, method="garus_azimuth", thruster_enabled=(False, *[True] * 5))
    result = sail(Allocator(AZIMUTH, chosen), np.array([150.0, 40.0, 10.0, 10.0]), 5)[-1]
    np.testing.assert_allclose(result.tau_achieved, [150.0, 40.0, 10.0, 10.0], atol=1e-6)
    assert result.thrust[0] == 0.0


def test_the_operating_point_stays_through_a_switch() -> None:
    """A demand that both serve: the first step of the other method starts from the thrusts of the one before."""
    allocator = Allocator(UKWIAL)
    tau = np.array([200.0, 50.0, 30.0, 20.0])
    before = sail(allocator, tau, 4)[-1]
    allocator.apply(settings(UKWIAL, method="pseudo_inverse"))
    after = allocator.step(tau, DT)
    # The program's answer without a limit is the pseudo-inverse but for its slack, 1e-6 of the demand.
    np.testing.assert_allclose(after.thrust, before.thrust, atol=1e-3)
    allocator.apply(settings(UKWIAL))
    np.testing.assert_allclose(allocator.step(tau, DT).thrust, before.thrust, atol=1e-6)


def test_the_program_beside_is_the_program() -> None:
    """tau_qp is what a step of qp from the same commands gives, to the bit."""
    tau = np.array([500.0, -200.0, 0.0, 100.0])
    other = Allocator(UKWIAL, settings(UKWIAL, method="pseudo_inverse"))
    for _ in range(3):
        before = other.step(0.5 * tau, DT)
    program = Allocator(UKWIAL, thrust=before.thrust, azimuth=before.azimuth)
    np.testing.assert_allclose(other.step(tau, DT).tau_qp, program.step(tau, DT).tau_achieved, atol=1e-9)
    other.apply(settings(UKWIAL, method="pseudo_inverse", compare_qp=False))
    assert np.isnan(other.step(tau, DT).tau_qp).all()
    result = program.step(tau, DT)
    assert np.isnan(result.tau_qp).all()
    assert np.isnan(result.tau_feasible).all()
    assert np.isnan(result.feasible_load)
    assert result.detail == ""


def test_on_a_ship() -> None:
    """Three axes, tunnel and azimuth thrusters: these turn to their fixed directions, and no problem is there."""
    allocator = Allocator(SHIP, settings(SHIP, method="pseudo_inverse"))
    result = sail(allocator, np.array([3.0, 1.0, 0.5]), 10)[-1]
    np.testing.assert_allclose(result.tau_achieved, [3.0, 1.0, 0.5], atol=ROUNDING)
    np.testing.assert_allclose(result.wrench, [3.0, 1.0, 0.0, 0.0, 0.0, 0.5], atol=ROUNDING)
    assert allocator.problem is None
    assert allocator.solution is None
    assert result.solver == ""


def refusal(vessel, changes) -> str:
    with pytest.raises(InputError) as caught:
        Allocator(vessel, changes)
    return str(caught.value)


def test_methods_that_do_not_fit() -> None:
    assert "garus_azimuth: expected four azimuth thrusters" in refusal(UKWIAL, settings(UKWIAL, method="garus_azimuth"))
    assert "found no sway" in refusal(MMT300, settings(MMT300, method="garus_azimuth"))
    assert (
        "portioned: expected a vessel that controls surge, heave, pitch, yaw, found surge, sway, heave, yaw"
        in refusal(UKWIAL, settings(UKWIAL, method="portioned"))
    )
    priority = settings(MMT300, method="pseudo_inverse", feasible="priority")
    priority = priority.model_copy(update={"priority": priority.priority.model_copy(update={"axis": "sway"})})
    assert refusal(MMT300, priority) == "priority.axis: expected one of surge, heave, pitch, yaw, found 'sway'"
    weights = priority.model_copy(update={"priority": priority.priority.model_copy(update={"weights": (1.0, 1.0)})})
    assert refusal(MMT300, weights) == (
        "priority.weights: expected 4 elements, one for each of surge, heave, pitch, yaw, found 2"
    )
    one_way = settings(SHIP, method="pseudo_inverse", feasible="proportional")
    if any(thruster.thrust.min >= 0.0 for thruster in SHIP.thrusters):
        assert "feasible: expected none where a thruster does not reverse" in refusal(SHIP, one_way)


def test_settings_that_break_a_method() -> None:
    assert refusal(MMT300, with_group(MMT300, "portions", "portioned", surge=0.6)) == (
        "portions.surge + portions.yaw: expected 1, found 1.1"
    )
    assert "angle_min: expected 0 or more and less than pi/4" in refusal(
        AZIMUTH, with_group(AZIMUTH, "garus_azimuth", "garus_azimuth", angle_min=radians(45.0))
    )
    assert "reserved_moment: expected 0 or more and less than 200" in refusal(
        AZIMUTH, with_group(AZIMUTH, "garus_azimuth", "garus_azimuth", reserved_moment=250.0)
    )
    with pytest.raises(InputError, match="speed: expected a finite number"):
        Allocator(MMT300).measure_speed(float("nan"))


@pytest.mark.parametrize(
    ("group", "changes", "named"),
    [
        ("sectors", {"enabled": True}, "sectors.enabled"),
        ("power", {"limit": "total"}, "power.limit"),
        ("singularity", {"method": "three_step"}, "singularity.method"),
        ("antispin", {"enabled": True}, "antispin.enabled"),
    ],
)
def test_what_only_the_program_knows(group: str, changes, named: str) -> None:
    assert refusal(SHIP, with_group(SHIP, group, "pseudo_inverse", **changes)).startswith(
        f"{named}: expected nothing with method = pseudo_inverse"
    )


def test_what_is_for_surge_sway_yaw() -> None:
    for chosen, named in (
        (settings(UKWIAL, azimuth_mode="auto"), "azimuth_mode"),
        (with_group(UKWIAL, "singularity", "qp", method="three_step"), "singularity.method"),
        (with_group(UKWIAL, "power", "qp", limit="total"), "power.priority"),
    ):
        assert refusal(UKWIAL, chosen).startswith(f"{named}: expected another value for a vessel that controls")
    with pytest.raises(InputError, match="sectors: expected a vessel that controls surge, sway, yaw"):
        Allocator(UKWIAL).cheapest_windows(np.zeros(4))


def test_bad_demands() -> None:
    allocator = Allocator(UKWIAL, settings(UKWIAL, method="pseudo_inverse"))
    with pytest.raises(InputError, match=r"tau_desired: expected shape \(4,\), found \(3,\)"):
        allocator.step(np.zeros(3), DT)
    first = allocator.step(np.array([10.0, 0.0, 0.0, 0.0]), DT)
    result = allocator.step(np.array([10.0, np.nan, 0.0, 0.0]), DT)
    assert result.status is Status.DEMAND_NOT_FINITE
    np.testing.assert_allclose(result.tau_desired, first.tau_desired)


def test_sine_of_the_cross() -> None:
    """The geometry of the vessel file is that of (5): 22.5 deg, 1 m, 0.8 m."""
    from thrust_allocator.methods.cross import cross_of

    cross = cross_of(MMT300)
    assert cross.order == (0, 1, 2, 3, 4)
    assert sin(cross.angle) == pytest.approx(sin(radians(22.5)))
    assert (cross.stern_arm, cross.bow_arm, cross.bow_sign) == pytest.approx((1.0, 0.8, 1.0))


def with_drives():
    """The AUV with the drives of its paper."""
    thrusters = tuple(thruster.model_copy(update={"drive": drive_data()}) for thruster in MMT300.thrusters)
    return MMT300.model_copy(update={"thrusters": thrusters})


@pytest.mark.parametrize(
    ("speed", "most"), [(None, 42.0), (-0.3, 42.0), (0.25, 40.25), (1.0, 34.5), (2.0, 24.8), (2.6, 24.8)]
)
def test_portions_of_the_thrust_at_the_speed(speed: float | None, most: float) -> None:
    """T_max of Table 4, linear between its columns; outside of them that of the nearest."""
    vessel = with_drives()
    chosen = with_group(vessel, "portions", "portioned")
    assert chosen.portions.speed_limited
    assert chosen.needs_speed
    allocator = Allocator(vessel, chosen)
    if speed is not None:
        allocator.measure_speed(speed)
    result = sail(allocator, np.array([500.0, 0.0, 0.0, -50.0]), 4)[-1]
    delta = radians(22.5)
    expected = [2.0 * cos(delta) * most, 0.0, 0.0, -sin(delta) * most]
    np.testing.assert_allclose(result.tau_achieved, expected, atol=ROUNDING)
    # What was measured outlives a change of parameters.
    allocator.apply(with_group(vessel, "portions", "portioned", surge=1.0, yaw=0.0, pitch=0.0))
    result = sail(allocator, np.array([500.0, 0.0, 0.0, 0.0]), 4)[-1]
    assert result.tau_achieved[0] == pytest.approx(4.0 * cos(delta) * most)
    allocator.apply(with_group(vessel, "portions", "portioned", surge=1.0, yaw=0.0, pitch=0.0, speed_limited=False))
    result = sail(allocator, np.array([500.0, 0.0, 0.0, 0.0]), 4)[-1]
    assert result.tau_achieved[0] == pytest.approx(4.0 * cos(delta) * 42.0)


def test_speed_without_maps() -> None:
    thrusters = [thruster.model_copy(update={"drive": None}) for thruster in MMT300.thrusters]
    vessel = MMT300.model_copy(update={"thrusters": tuple(thrusters)})
    assert not settings(vessel).portions.speed_limited
    assert refusal(vessel, with_group(vessel, "portions", "portioned", speed_limited=True)).startswith(
        "portions.speed_limited: expected false, because not every marching thruster has a drive"
    )
