"""Commands are mapped by name, refused whole, or clipped."""

from __future__ import annotations

import math
import re
from itertools import permutations

import numpy as np
import pytest

from marine_model import load_vessel
from marine_model.errors import InputError
from thruster_drivers import CommandReader

VESSEL = load_vessel("cybership3")
NAMES = list(VESSEL.thruster_names)
THRUST = [0.1, 2.0, -3.0, 4.0]
AZIMUTH = [1.5, 0.2, -0.7, 3.0]


def test_every_order_of_names_gives_the_same_command() -> None:
    reader = CommandReader(VESSEL)
    for order in permutations(range(4)):
        command = reader.read([NAMES[i] for i in order], [THRUST[i] for i in order], [AZIMUTH[i] for i in order])
        np.testing.assert_array_equal(command.thrust, THRUST)
        np.testing.assert_array_equal(command.azimuth, AZIMUTH)
        assert command.clipped == ()


def test_thrust_beyond_a_limit_is_clipped_and_named() -> None:
    command = CommandReader(VESSEL).read(NAMES, [-9.0, 8.7, 13.6, -9.0], AZIMUTH)
    np.testing.assert_array_equal(command.thrust, [-0.47, 8.7, 13.5, -9.0])
    assert command.clipped == ("tunnel_bow", "azimuth_port")


def test_a_limit_passed_by_rounding_is_no_news() -> None:
    command = CommandReader(VESSEL).read(NAMES, [0.58 + 1e-12, 0.0, 0.0, 0.0], AZIMUTH)
    assert command.thrust[0] == 0.58
    assert command.clipped == ()


@pytest.mark.parametrize(
    ("names", "thrust", "azimuth", "message"),
    [
        (NAMES, [0.1, math.nan, 0.0, 0.0], AZIMUTH, "thrust: expected finite numbers, found [0.1, nan, 0.0, 0.0]"),
        (NAMES, THRUST, [0.0, 0.0, math.inf, 0.0], "azimuth: expected finite numbers"),
        (NAMES, THRUST[:3], AZIMUTH, "thrust: expected shape (4,), found (3,)"),
        (NAMES, THRUST, [*AZIMUTH, 0.0], "azimuth: expected shape (4,), found (5,)"),
        (
            NAMES[:3],
            THRUST,
            AZIMUTH,
            "name: expected ['tunnel_bow', 'azimuth_bow', 'azimuth_port', 'azimuth_starboard']",
        ),
        ([*NAMES[:3], "rudder"], THRUST, AZIMUTH, "'azimuth_port', 'rudder']"),
        ([*NAMES[:3], NAMES[0]], THRUST, AZIMUTH, "'azimuth_port', 'tunnel_bow']"),
        ([], THRUST, AZIMUTH, "found []"),
    ],
)
def test_bad_commands_are_refused_with_what_was_found(
    names: list[str], thrust: list[float], azimuth: list[float], message: str
) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        CommandReader(VESSEL).read(names, thrust, azimuth)
