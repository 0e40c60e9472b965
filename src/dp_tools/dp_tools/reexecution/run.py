"""Feeds a node from the first item to the last, and tries other orders where the bag leaves the order open."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from dp_tools.reexecution.feed import Changed, Item
from dp_tools.reexecution.feeder import Feeder
from dp_tools.reexecution.order import Order
from dp_tools.reexecution.trial import Matcher, Saved, State, last_saved, other_orders

Progress = Callable[[int, int], None]

# Progress is told this often, in acts.
_PROGRESS_ACTS = 200


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
        self._saved: deque[Saved] = last_saved()
        self.moved = 0
        self.gave_up: int | None = None

    def all(self, progress: Progress) -> None:
        """Feed everything; ``progress`` is told how many acts are done, and of how many."""
        count = len(self._order.acts)
        for act in range(count + 1):
            if act % _PROGRESS_ACTS == 0:
                progress(act, count)
            self._step(act, self._saved)
            if self._state is not None and not self._matcher.matches() and not self._resolve(act):
                self.gave_up = act
                self._state = None
        progress(count, count)

    def _step(self, number: int, saved: deque[Saved]) -> None:
        """Feed the loose messages before act ``number``, and the act; the last number has no act."""
        order, feeder = self._order, self._feeder
        if self._state is not None and order.unsure(number):
            saved.append(Saved(number, self._state.save(), self._matcher.caught))
        for i in list(order.between(number)):
            loose = order.loose[i]
            feeder.feed(loose.item, loose.published)
        if number < len(order.acts):
            act = order.acts[number]
            feeder.feed(act.item, order.begun[number])
            if isinstance(act.item, Changed):
                saved.clear()  # parameters are beyond what is kept

    def _resolve(self, act: int) -> bool:
        """Look for an order that gives the recorded output up to ``act``; leave all as it was if there is none."""
        places = list(self._order.place)
        saved = list(self._saved)
        for k in range(len(saved) - 1, -1, -1):
            for other in other_orders(self._order, saved[k].act, self._topic):
                if self._again(saved[k], other, act, deque(saved[:k], self._saved.maxlen)):
                    self.moved += 1
                    return True
                for i, number in enumerate(places):
                    if self._order.place[i] != number:
                        self._order.move(i, number)
        if saved:
            self._again(saved[0], {}, act, deque(maxlen=self._saved.maxlen))
        return False

    def _again(self, start: Saved, places: dict[int, int], until: int, saved: deque[Saved]) -> bool:
        """Go back to ``start``, put messages elsewhere and feed again; return whether all is as recorded."""
        if self._state is None:
            return False
        for i, number in places.items():
            if self._order.place[i] != number:
                self._order.move(i, number)
        self._matcher.back_to(start.caught)
        self._state.restore(start.state)
        for number in range(start.act, until + 1):
            self._step(number, saved)
        same = self._matcher.matches()
        if same:
            self._saved = saved
        return same

    def _topic(self, loose: int) -> str:
        item: Any = self._order.loose[loose].item
        return str(item.topic)
