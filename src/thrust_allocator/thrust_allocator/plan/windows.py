"""What one step may reach, from magnitude and rate limits: [Ruth] (4.14)-(4.17)."""

from __future__ import annotations

import math

from marine_model.compiled import compiled

# A rotating thruster's window must stay a cone of less than 180 deg to be convex, and the lines (4.41)-(4.42) reach
# only cos(half window) of the thrust limit at its ends: no more than 60 deg either way in one step.
LARGEST_TURN = math.pi / 3.0


@compiled
def step_window(value: float, minimum: float, maximum: float, step: float, approach: float) -> tuple[float, float]:
    """Return the smallest and the largest value allowed in this step, [Ruth] (4.14)-(4.17).

    Where ``value`` lies outside its limits by more than the rate allows to correct, the window leads back at
    ``approach`` of the full rate or more, so that it is never empty.

    Parameters
    ----------
    value
        Command of the step before: thrust (N) or angle (rad).
    minimum, maximum
        Magnitude limits now.
    step
        Rate limit times time step, above 0; the same both ways.
    approach
        c_1, in [0, 1).
    """
    lower = min(max(minimum, value - step), value + approach * step)
    upper = max(min(maximum, value + step), value - approach * step)
    return lower, upper
