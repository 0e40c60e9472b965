"""Submergence and speed of advance at the thrusters: hand cases in calm water, long and short waves, current."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from marine_model import Vessel, load_vessel
from support.box_hull import box_of
from vessel_sim import WaveSettings
from vessel_sim.inflow import Inflow
from vessel_sim.waves import Waves
from vessel_sim.waves.components import PHASE
from vessel_sim.waves.hull_motion import hull_motion

DEPTHS = [0.08, 0.19, 0.115, 0.115]


def ship(folder: Path, trim: float = 0.0) -> Vessel:
    """CyberShip III with depths of its shafts fixed here."""
    base = load_vessel("cybership3").model_dump(mode="json")["thrusters"]
    for thruster, depth in zip(base, DEPTHS, strict=True):
        thruster["position"][2] = depth
    content = {"extends": "cybership3", "name": "ship", "hull": {"trim": trim}, "thrusters": base}
    path = folder / "ship.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return load_vessel(path)


@pytest.fixture(scope="module")
def vessel(tmp_path_factory: pytest.TempPathFactory) -> Vessel:
    return ship(tmp_path_factory.mktemp("vessels"))


def frozen(waves: Waves, phase: float) -> Waves:
    """Give the component of ``waves`` a phase of one's choice."""
    waves.components[:, PHASE] = phase
    return waves


def sea(vessel: Vessel, amplitude: float, period: float = 1.0, direction: float = 0.0) -> Waves:
    settings = WaveSettings(amplitude=amplitude, period=period, direction=direction, ramp=0.0)
    return Waves(box_of(vessel), settings)


AHEAD = np.zeros(4)
REST = (0.0, 0.0, 0.0)


def test_calm_water_at_rest(vessel: Vessel) -> None:
    submergence, advance = Inflow(vessel).at((5.0, 2.0, 1.0), REST, AHEAD, sea(vessel, 0.0), 3.0)
    assert submergence.tolist() == DEPTHS
    assert advance.tolist() == [0.0] * 4


def test_trim_by_the_bow_lifts_the_stern(vessel: Vessel, tmp_path: Path) -> None:
    trimmed = ship(tmp_path, trim=0.05)
    submergence, _ = Inflow(trimmed).at(REST, REST, AHEAD, sea(vessel, 0.0), 0.0)
    assert submergence == pytest.approx([0.08 + 0.042, 0.19 + 0.038, 0.115 - 0.0405, 0.115 - 0.0405])


def test_advance_in_calm_water_by_hand(vessel: Vessel) -> None:
    # u = 0.4, v = -0.1, r = 0.2. Aft port thruster at (-0.81, -0.11): ahead 0.4 + 0.2 * 0.11 = 0.422, to starboard
    # -0.1 - 0.2 * 0.81 = -0.262. Bow tunnel at (0.84, 0): ahead 0.4, to starboard -0.1 + 0.168 = 0.068.
    calm, inflow = sea(vessel, 0.0), Inflow(vessel)
    place, velocity = (1.0, 2.0, 2.5), (0.4, -0.1, 0.2)
    _, ahead = inflow.at(place, velocity, AHEAD, calm, 0.0)
    _, right = inflow.at(place, velocity, np.full(4, math.pi / 2.0), calm, 0.0)
    assert ahead == pytest.approx([0.4, 0.4, 0.422, 0.378], abs=1e-15)
    assert right == pytest.approx([0.068, 0.052, -0.262, -0.262], abs=1e-15)
    _, mixed = inflow.at(place, velocity, np.array([math.pi, -math.pi / 2.0, 0.3, -0.4]), calm, 0.0)
    assert mixed == pytest.approx(
        [
            -0.4,
            -0.052,
            0.422 * math.cos(0.3) - 0.262 * math.sin(0.3),
            0.378 * math.cos(0.4) + 0.262 * math.sin(0.4),
        ],
        abs=1e-15,
    )


def test_in_long_waves_the_shafts_follow_the_surface(vessel: Vessel) -> None:
    # k L = 0.002: the hull lies on the surface and goes round with the water.
    waves = sea(vessel, 1.0, 60.0, 0.6)
    for time in (0.0, 7.0, 23.0):
        submergence, advance = Inflow(vessel).at((0.0, 0.0, 0.3), REST, np.full(4, 0.5), waves, time)
        # Heave lacks k T / 2 = 9e-5 of the amplitude. The water is strained, which a rigid hull is not: k |x| = 9e-4 of
        # the speed a omega = 0.105 m/s.
        assert submergence == pytest.approx(DEPTHS, abs=3e-4)
        assert advance == pytest.approx(np.zeros(4), abs=1.2e-4)


def test_a_crest_at_the_thruster_deepens_it(vessel: Vessel) -> None:
    # Waves of 4 mm length do not move the hull; the crest is at the origin plus whole lengths from the bow tunnel.
    waves = sea(vessel, 1e-4, 0.05)
    k = WaveSettings(period=0.05).wave_number
    for phase, sign in ((0.0, 1.0), (math.pi, -1.0)):
        submergence, _ = Inflow(vessel).at(REST, REST, AHEAD, frozen(waves, phase - k * 0.84), 0.0)
        # e = 1 / (k T) = 4e-3 and j0 = 1 / (k L / 2) = 6e-4 of the amplitude are left of heave, some of pitch.
        assert submergence[0] == pytest.approx(0.08 + sign * 1e-4, abs=1e-6)


def test_the_bow_thruster_is_deepened_by_bow_down_pitch(vessel: Vessel) -> None:
    # Waves from astern: on the back slope, theta = pi / 2, the surface falls ahead and the bow is down.
    # Short enough that the hull does not follow the surface fully (k L / 2 = 1.98 at 1.4 s).
    waves = frozen(sea(vessel, 0.03, 1.4), math.pi / 2.0)
    moved, _ = hull_motion(waves.components, waves.response, REST, (0.0, 0.0), 0.0)
    assert moved[4] < -0.01
    assert moved[2] == pytest.approx(0.0, abs=1e-12)
    submergence, _ = Inflow(vessel).at(REST, REST, AHEAD, waves, 0.0)
    surface = waves.elevation(vessel.lever_x, vessel.lever_y, 0.0)
    shaft_below_rest = submergence - DEPTHS - surface
    assert shaft_below_rest == pytest.approx(-vessel.lever_x * moved[4], abs=1e-12)
    assert shaft_below_rest[0] > 0.0 > shaft_below_rest[2]


def test_the_starboard_thruster_is_deepened_by_roll_to_starboard(vessel: Vessel) -> None:
    # Waves to starboard on their back slope: the surface falls to starboard, and so does the ship.
    waves = frozen(sea(vessel, 0.03, 1.4, math.pi / 2.0), math.pi / 2.0)
    moved, _ = hull_motion(waves.components, waves.response, REST, (0.0, 0.0), 0.0)
    assert moved[3] > 0.01
    submergence, _ = Inflow(vessel).at(REST, REST, AHEAD, waves, 0.0)
    surface = waves.elevation(vessel.lever_x, vessel.lever_y, 0.0)
    shaft_below_rest = submergence - DEPTHS - surface
    assert shaft_below_rest == pytest.approx(vessel.lever_y * moved[3], abs=1e-12)
    assert shaft_below_rest[3] > 0.0 > shaft_below_rest[2]


@given(
    heading=st.floats(-3.0, 3.0),
    direction=st.floats(-3.0, 3.0),
    azimuth=st.floats(-3.0, 3.0),
    time=st.floats(0.5, 30.0),
    u=st.floats(-0.5, 0.5),
    v=st.floats(-0.3, 0.3),
)
def test_advance_is_the_motion_of_the_thruster_less_that_of_the_water(
    vessel: Vessel, heading: float, direction: float, azimuth: float, time: float, u: float, v: float
) -> None:
    waves = sea(vessel, 0.02, 1.3, direction)
    inflow = Inflow(vessel)
    current = np.array([0.05, -0.1])
    c, s = math.cos(heading), math.sin(heading)
    turn = np.array([[c, -s], [s, c]])
    over_ground = turn @ [u, v] + current

    def shaft(t: float) -> np.ndarray:
        """Offset of every thruster from the steady voyage, in the axes of the ship; small angles."""
        place = (*(over_ground * t), heading)
        moved, _ = hull_motion(waves.components, waves.response, place, tuple(over_ground), t)
        x, y, z = vessel.lever_x, vessel.lever_y, np.array(DEPTHS)
        return np.array([moved[0] + z * moved[4] - y * moved[5], moved[1] - z * moved[3] + x * moved[5]])

    e = 1e-5
    wave_velocity = (shaft(time + e) - shaft(time - e)) / (2.0 * e)
    place = (*(over_ground * time), heading)
    arms = turn @ np.array([vessel.lever_x, vessel.lever_y])
    water = waves.particle_velocity(place[0] + arms[0], place[1] + arms[1], DEPTHS, time)[:, :2] @ turn
    expected = (np.array([[u], [v]]) + wave_velocity - water.T).T @ [math.cos(azimuth), math.sin(azimuth)]
    _, advance = inflow.at(place, (u, v, 0.0), np.full(4, azimuth), waves, time, tuple(current))
    # Central differences: as in test_sim_first_order.
    assert advance == pytest.approx(expected, abs=1e-7)


def test_a_current_alone_is_in_the_velocity_through_the_water(vessel: Vessel) -> None:
    # At rest over ground in a current of 0.2 m/s to the south, heading north: 0.2 m/s ahead through the water.
    _, advance = Inflow(vessel).at(REST, (0.2, 0.0, 0.0), AHEAD, sea(vessel, 0.0), 0.0, (-0.2, 0.0))
    assert advance.tolist() == [0.2] * 4
