"""Which transition a node needs next; without ROS."""

from __future__ import annotations

from enum import StrEnum


class Aim(StrEnum):
    """The state in which a node is to end up: the last one that it was seen in."""

    UNCONFIGURED = "unconfigured"
    INACTIVE = "inactive"
    ACTIVE = "active"


class Step(StrEnum):
    """A transition."""

    CONFIGURE = "configure"
    ACTIVATE = "activate"


def next_step(state: str, aim: Aim, turn: bool) -> Step | None:
    """Return the transition that leads from ``state`` towards ``aim``; None to wait, or if it is reached.

    Parameters
    ----------
    state
        Label of the present state.
    aim
        Where to go.
    turn
        Whether everybody who has to be active before this node is.
    """
    if state == Aim.UNCONFIGURED and aim is not Aim.UNCONFIGURED:
        return Step.CONFIGURE
    if state == Aim.INACTIVE and aim is Aim.ACTIVE and turn:
        return Step.ACTIVATE
    return None
