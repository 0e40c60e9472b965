"""Numbers as text for people: pages and tables."""

from __future__ import annotations

import math
from decimal import Decimal

from dp_tools.figures import FigureSpec


def number(value: float, digits: int = 3) -> str:
    """Return ``value`` with ``digits`` significant digits, a true minus sign, and no exponent for usual sizes."""
    if value == 0.0:
        return "0"
    if not math.isfinite(value):
        return str(value)
    magnitude = math.floor(math.log10(abs(value)))
    if not -5 < magnitude < 6:
        text = f"{value:.{digits - 1}e}"
    else:
        text = f"{value:.{max(0, digits - 1 - magnitude)}f}"
    return text.replace("-", "−")


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """Return ``value`` and its unit; small lengths in mm."""
    if unit == "1":
        return number(value, digits)
    if unit == "m" and 0.0 < abs(value) < 0.1:
        value, unit = 1000.0 * value, "mm"
    return f"{number(value, digits)} {unit}"


def quantity(spec: FigureSpec, value: float) -> str:
    """Return a value of a figure, as its kind is shown."""
    if spec.shown == "change":
        return f"{100.0 * value:+.1f} %".replace("-", "−")
    if spec.shown == "share":
        return f"{100.0 * value:.1f} %".replace("-", "−")
    return with_unit(value, spec.unit)


def interval(spec: FigureSpec, low: float, high: float) -> str:
    """Return a range of a figure; the unit once."""
    first, last = quantity(spec, low), quantity(spec, high)
    size, _, unit = first.partition(" ")
    return f"{size if last.endswith(unit) else first} … {last}"


def bound(spec: FigureSpec) -> str:
    """Return the bounds that a figure must keep; empty if there are none."""
    parts = []
    if spec.at_least is not None:
        parts.append(f"at least {_limit(spec, spec.at_least)}")
    if spec.at_most is not None:
        parts.append(f"at most {_limit(spec, spec.at_most)}")
    return ", ".join(parts)


def remark(spec: FigureSpec) -> str:
    """Return reason and source of a figure."""
    return " ".join(part for part in (spec.reason, f"({spec.source})" if spec.source else "") if part)


def _limit(spec: FigureSpec, value: float) -> str:
    """Return a limit as it was given: 0.05 N, not 0.05000 N."""
    size, space, unit = with_unit(value, spec.unit, 4).partition(" ")
    return (size.rstrip("0").rstrip(".") if "." in size and "e" not in size else size) + space + unit


def printed(spec: FigureSpec, value: float) -> str:
    """Return a number of the thesis with the digits that it was written with."""
    exact = Decimal(repr(value))
    sign = ""
    if spec.shown != "quantity":
        exact, sign = 100 * exact, "+" if spec.shown == "change" and value > 0.0 else ""
    text = f"{exact.normalize():f}"
    unit = {"quantity": "" if spec.unit == "1" else f" {spec.unit}"}.get(spec.shown, " %")
    return f"{sign}{text}{unit}".replace("-", "−")
