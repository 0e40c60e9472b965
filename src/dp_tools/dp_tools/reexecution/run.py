"""Feeds a node from the first item to the last, and tries other orders where the bag leaves the order open."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dp_tools.reexecution.feed import Changed, Item
from dp_tools.reexecution.feeder import Feeder
from dp_tools.reexecution.order import Order
from dp_tools.reexecution.trial import Matcher, Saved, State, other_orders

Progress = Callable[[int, int], None]

# Progress is told this often, in acts.
_PROGRESS_ACTS = 200
# The state is kept this often, in acts: to go back takes no more steps than that.
_KEEP_EVERY = 50
# So many acts back a wrong decision is looked for: the simulator shows what it was told with the next step.
_BACK = 3


class Run:
    """One run through all items.

    Parameters
    ----------
    order
        What is fed; messages are moved in it as they are found to have come otherwise.
    feeder
        Feeds the node.
    matcher
        Knows what was recorded.
    state
        Of the node, to go back to; None where the order makes no difference.

    Attributes
    ----------
    moved
        Number of times that another order gave the recorded output.
    gave_up
        Act about which no order gave it; None if there was none.
    """

    def __init__(self, order: Order[Item], feeder: Feeder, matcher: Matcher, state: State | None) -> None:
        self._order = order
        self._feeder = feeder
        self._matcher = matcher
        self._state = state
        self._kept: list[Saved] = []
        self.moved = 0
        self.gave_up: int | None = None

    def all(self, progress: Progress) -> None:
        """Feed everything; ``progress`` is told how many acts are done, and of how many."""
        acts = self._order.acts
        for number in range(len(acts) + 1):
            if number % _PROGRESS_ACTS == 0:
                progress(number, len(acts))
            if self._state is not None:
                self._keep(number, self._state)
            self._step(number)
            if self._state is not None and not self._matcher.matches() and not self._resolve(number, self._state):
                self.gave_up = number
                self._state = None
        progress(len(acts), len(acts))

    def _keep(self, number: int, state: State) -> None:
        """Keep the state before act ``number`` now and then."""
        acts = self._order.acts
        if number and isinstance(acts[number - 1].item, Changed):
            self._kept.clear()  # parameters are not part of the state: there is no way back beyond a change of them
        if not self._kept or number - self._kept[-1].act >= _KEEP_EVERY:
            # The last but one as well: the place to go back to may lie shortly before the last.
            self._kept = [*self._kept[-1:], Saved(number, state.save(), self._matcher.caught)]

    def _step(self, number: int) -> None:
        """Feed the loose messages before act ``number``, and the act; the last number has no act."""
        order, feeder = self._order, self._feeder
        for i in order.between(number):
            loose = order.loose[i]
            feeder.feed(loose.item, loose.published)
        if number < len(order.acts):
            feeder.feed(order.acts[number].item, order.begun[number])

    def _resolve(self, act: int, state: State) -> bool:
        """Look for an order that gives the recorded output up to ``act``; leave all as it was if there is none."""
        starts = self._near(act, state)
        for start in reversed(starts):
            for places in other_orders(self._order, start.act, self._topic):
                before = {i: self._order.place[i] for i in places}
                self._move(places)
                if self._again(start, act):
                    self.moved += 1
                    self._kept = [one for one in self._kept if one.act <= start.act]
                    return True
                self._move(before)
        self._again(starts[0], act)
        return False

    def _near(self, act: int, state: State) -> list[Saved]:
        """Go back and return the states before the last few acts up to ``act``."""
        first = max(act - _BACK, self._kept[0].act)
        start = max((one for one in self._kept if one.act <= first), key=lambda one: one.act)
        self._matcher.back_to(start.caught)
        start.state.restore()
        found = []
        for number in range(start.act, act + 1):
            if number >= first:
                found.append(Saved(number, state.save(), self._matcher.caught))
            self._step(number)
            self._matcher.matches()
        return found

    def _move(self, places: dict[int, int]) -> None:
        for i, number in places.items():
            if self._order.place[i] != number:
                self._order.move(i, number)

    def _again(self, start: Saved, until: int) -> bool:
        """Go back to ``start`` and feed again; return whether all is as recorded."""
        self._matcher.back_to(start.caught)
        start.state.restore()
        for number in range(start.act, until + 1):
            self._step(number)
        return self._matcher.matches()

    def _topic(self, loose: int) -> str:
        item: Any = self._order.loose[loose].item
        return str(item.topic)
