"""Whether azimuth thrusters are held or rotate, by the filtered size of the demand: [Ruth] (6.3)-(6.5)."""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple

from marine_model.errors import InputError
from marine_model.gains import FixedRotatingGains
from marine_model.guards import positive_number

# s; fifty steps of 0.1 s add up to less than 5 s, by rounding.
_TIME_TOLERANCE = 1e-9


class AzimuthMode(Enum):
    """What the operator asks for, in the words of commercial systems."""

    FIXED = "fixed"
    VARIABLE = "variable"
    AUTO = "auto"

    @classmethod
    def parse(cls, word: str) -> AzimuthMode:
        """Return the mode of that name; "rotating" is another name of "variable". Raises InputError."""
        try:
            return cls("variable" if word == "rotating" else word)
        except ValueError:
            raise InputError(f"azimuth_mode: expected fixed, variable (or rotating) or auto, found {word!r}") from None


class ModeState(NamedTuple):
    """All that the supervisor remembers.

    Attributes
    ----------
    rotating
        I_tau: whether azimuth thrusters rotate now.
    mean_force
        Low-pass filtered surge-sway demand, N.
    since_switch
        Time since the last change of ``rotating``, s.
    """

    rotating: bool = False
    mean_force: float = 0.0
    since_switch: float = math.inf


def next_mode(
    state: ModeState, mode: AzimuthMode, gains: FixedRotatingGains | None, surge: float, sway: float, dt: float
) -> ModeState:
    """Return the state at a new demand.

    The filter (6.3) is solved exactly for a demand that is constant since the last one, so that it does not depend on
    the step and is stable for any. It goes on in every mode, so that auto begins from what the demand has been. A
    change by the operator begins the dwell time too.

    Parameters
    ----------
    state
        At the last demand.
    mode
        What the operator asks for.
    gains
        Limits of (6.5). Without them there is no filter, and auto cannot be asked for.
    surge, sway
        Demanded force, N.
    dt
        Time since the last demand, s.

    Raises
    ------
    InputError
        If a number is not finite, ``dt`` is not above 0, or ``mode`` is auto without gains. Nothing has changed then.
    """
    since = state.since_switch + positive_number("dt", dt)
    size = math.hypot(surge, sway)  # (6.4)
    if not math.isfinite(size):
        raise InputError(f"demand: expected finite forces, found {surge} and {sway}")
    mean, rotating = state.mean_force, state.rotating
    if gains is not None:
        mean -= math.expm1(-gains.filter_frequency * dt) * (size - mean)
    if mode is not AzimuthMode.AUTO:
        rotating = mode is AzimuthMode.VARIABLE
    elif gains is None:
        raise InputError("azimuth_mode: auto needs allocator.fixed_rotating in the vessel file")
    elif since >= gains.dwell_time - _TIME_TOLERANCE:
        if mean > gains.force_limit + gains.hysteresis:
            rotating = True
        elif mean < gains.force_limit - gains.hysteresis:
            rotating = False
    return ModeState(rotating, mean, since if rotating == state.rotating else 0.0)
