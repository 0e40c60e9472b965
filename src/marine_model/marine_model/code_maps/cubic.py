"""A cubic in the size of a thrust that has to rise."""

from __future__ import annotations

from marine_model.errors import InputError

Cubic = tuple[float, float, float, float]


def value(cubic: Cubic, x: float) -> float:
    """Return the polynomial, lowest power first, at ``x``."""
    return cubic[0] + x * (cubic[1] + x * (cubic[2] + x * cubic[3]))


def require_rising(name: str, cubic: Cubic, low: float, high: float) -> None:
    """Raise InputError if the cubic is negative at ``low`` or does not rise all the way from ``low`` to ``high``."""
    if value(cubic, low) < 0.0:
        raise InputError(f"{name}: expected a code not below 0 at {low:g} N, found {value(cubic, low):g}")
    at = [low, high]
    if cubic[3] != 0.0:
        flattest = -cubic[2] / (3.0 * cubic[3])
        if low < flattest < high:
            at.append(flattest)
    for x in at:
        slope = cubic[1] + x * (2.0 * cubic[2] + x * 3.0 * cubic[3])
        if slope <= 0.0:
            raise InputError(
                f"{name}: expected a code that rises from {low:g} to {high:g} N, found a slope of {slope:.4g} 1/N at "
                f"{x:.4g} N"
            )
