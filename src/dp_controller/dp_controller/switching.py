"""Bumpless switches of three axes: what makes the demand in each, and the force that fades after a change of it."""

from __future__ import annotations

from dp_controller.settings import AxisMode
from dp_controller.transfer import Transfer
from dp_controller.vectors import Mask, Triple

BY_HAND = ("off", "joystick")


def law(mode: AxisMode, valid: bool, follows: bool) -> str:
    """Return the name of what makes the demand in one axis: at a change of it the demand could jump.

    Parameters
    ----------
    mode
        Of the axis.
    valid
        Whether the estimate is.
    follows
        Whether the derivative term damps the difference from the reference.
    """
    if mode != "automatic":
        return mode
    if not valid:
        return "hold"
    return "error_feedback" if follows else "vessel_feedback"


class Switching:
    """Remembers the laws of the last sample, and fades what would be a step of the demand at a change.

    Attributes
    ----------
    laws
        Of the last sample, see :func:`law`; None before the first.
    retuned
        Whether gains have changed since then.
    """

    __slots__ = ("_parts", "_stick_was_stale", "laws", "retuned")

    def __init__(self) -> None:
        self.laws: list[str] | None = None
        self.retuned = False
        self._stick_was_stale = False
        self._parts = (Transfer(), Transfer(), Transfer())

    def staying(self, automatic: Mask) -> Mask:
        """Return which axes are automatic and were so in the sample before."""
        before = self.laws
        if before is None:
            return False, False, False
        a, b, c = (automatic[i] and before[i] not in BY_HAND for i in range(3))
        return a, b, c

    def step(
        self, laws: list[str], demand: Triple, raw: Triple, stick: tuple[bool, bool], fade: float, dt: float
    ) -> Triple:
        """Return the fading part of the demand, begun anew in every axis whose law changes in this sample.

        Parameters
        ----------
        laws
            Of this sample.
        demand, raw
            The demand of the sample before, and that of this one without a fading part (N, N m).
        stick
            Whether a joystick was given at all, and whether its last force is fresh.
        fade
            Time in which a step fades, s.
        dt
            Since the sample before, s.
        """
        before, (given, fresh) = self.laws, stick
        back = fresh and self._stick_was_stale
        for i, part in enumerate(self._parts):
            changed = before is not None and (
                laws[i] != before[i] or (self.retuned and laws[i] not in BY_HAND) or (back and laws[i] == "joystick")
            )
            if changed:
                part.begin(demand[i] - raw[i], fade)
            else:
                part.advance(dt)
        self.retuned = False
        self.laws = laws
        self._stick_was_stale = given and not fresh
        a, b, c = self._parts
        return a.force, b.force, c.force
