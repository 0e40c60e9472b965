"""`dp replay`: send the messages of a bag again."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dp_bringup.interrupts import Interrupts
from dp_bringup.operator_node import Operator, operator
from dp_tools.bags.bag import Bag
from dp_tools.bags.errors import BagError
from dp_tools.commands.bag_options import (
    BagPath,
    Exclude,
    SimTime,
    Start,
    TimeOf,
    TimeOfOption,
    Topics,
    Until,
    warn,
    warn_of_cut,
)
from dp_tools.commands.bag_progress import reading
from dp_tools.commands.root import INTERRUPTED, Namespace, console
from dp_tools.replay.keyboard import Keyboard
from dp_tools.replay.player import Player
from dp_tools.replay.replay_node import CLOCK_KIND, BagClock, Outlets, offer_services
from dp_tools.replay.schedule import Schedule, make_schedule
from dp_tools.replay.screen import Screen
from dp_tools.replay.selection import Selection, parse_remap

if TYPE_CHECKING:
    from dp_tools.reexecution.command import Asked

NODE_NAME = "dp_replay"
# Longest wait in which a key is not looked at, ns.
_LONGEST_WAIT = 50_000_000
# A wait of the executor may be this much too long; the rest of it is spent looking at the time, ns.
_WAKE_EARLY = 200_000
# While messages follow each other closely, services and keys are looked at this often, ns.
_SERVE_PERIOD = 10_000_000
_RATE_STEP = 1.1  # as ros2 bag play


def replay(
    bag: BagPath,
    rate: Annotated[float, typer.Option(metavar="NUMBER", help="Bag seconds a second.")] = 1.0,
    start: Start = None,
    until: Until = None,
    sim_time: SimTime = False,
    time_of: TimeOfOption = TimeOf.PUBLISH,
    loop: Annotated[bool, typer.Option("--loop", metavar="", help="Begin anew at the end, until Ctrl-C.")] = False,
    topics: Topics = None,
    exclude: Exclude = None,
    remap: Annotated[
        list[str] | None, typer.Option(metavar="OLD:=NEW", help="Publish a topic under another name; repeatable.")
    ] = None,
    namespace: Namespace = "",
    paused: Annotated[bool, typer.Option("--paused", metavar="", help="Stand at first.")] = False,
    wait: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Wait so long at most for subscribers: of every one of --topics, or of any topic. 0: for ever.",
            min=0.0,
        ),
    ] = None,
    clock: Annotated[
        float | None, typer.Option(metavar="HZ", help="Publish a clock made from bag time, for a bag without one.")
    ] = None,
    into: Annotated[
        list[str] | None,
        typer.Option(metavar="NODE|all", help="Send nothing; feed the present code of this node; repeatable."),
    ] = None,
    verify: Annotated[
        bool, typer.Option("--verify", metavar="", help="With --into: compare its outputs with the recorded ones.")
    ] = False,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NODE.NAME=VALUE", help="With --into: another value of a parameter; repeatable."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option(metavar="BAG", help="With --into: write the new outputs to a bag.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", metavar="", help="Replace the bag of --output.")] = False,
    tolerance: Annotated[
        float, typer.Option(metavar="NUMBER", help="With --verify: numbers no further apart are the same.", min=0.0)
    ] = 0.0,
    only_first: Annotated[
        bool, typer.Option("--only-first", metavar="", help="With --verify: stop at a topic's first difference.")
    ] = False,
) -> None:
    """Publish the messages of a bag again: as they were serialized, in their order, at their times.

    With --into, nothing is sent: the present code of a node is fed with its recorded inputs and changes of parameters.

    Exit code 0 at the end of the bag or after q, and after Ctrl-C with --loop; 1 if something went wrong, or --verify
    found a difference; 130 if Ctrl-C or SIGTERM cut the replay short.
    """
    if into:
        # Here: it loads the core of every node, and with it the compiler.
        from dp_tools.reexecution.command import Asked

        asked = Asked(into, verify, changes or (), output, overwrite, tolerance, only_first, namespace)
        _into(bag, asked)
        return
    if verify or changes or output is not None or only_first:
        raise typer.BadParameter("--verify, --set, --output and --only-first need --into")
    if not rate > 0.0:
        raise typer.BadParameter("--rate: expected a number above 0")
    if clock is not None and not clock > 0.0:
        raise typer.BadParameter("--clock: expected a number above 0")
    selection = Selection(topics or (), exclude or (), [parse_remap(text) for text in remap or ()], namespace)
    try:
        with Interrupts(), reading(bag) as opened:
            warn_of_cut(opened)
            names = selection.names(topic.name for topic in opened.topics)
            if clock is not None:
                _expect_no_clock(opened, names)
            with operator(namespace, NODE_NAME) as one:
                outlets = Outlets(one.node, opened, names, warn)
                schedule = make_schedule(opened, outlets.played, time_of.value, start, until, sim_time)
                run = _Replay(one, outlets, schedule)
                bag_clock = BagClock(one.node, "clock", clock, schedule.origin) if clock else None
                if wait is not None:
                    run.wait_for_listeners(wait or None, every=bool(topics))
                run.play(rate, loop, paused, bag_clock)
    except KeyboardInterrupt:
        if not loop:  # with it, it is the way to stop
            raise typer.Exit(INTERRUPTED) from None


def _into(bag: Path, asked: Asked) -> None:
    """Re-execute nodes."""
    from dp_tools.reexecution.command import replay_into

    try:
        with Interrupts(), reading(bag) as opened:
            warn_of_cut(opened)
            agrees = replay_into(opened, asked, console)
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None
    if not agrees:
        raise typer.Exit(1)


class _Replay:
    """A bag, a node that publishes it, and who steers it."""

    def __init__(self, one: Operator, outlets: Outlets, schedule: Schedule) -> None:
        self._one = one
        self._outlets = outlets
        self._schedule = schedule

    def wait_for_listeners(self, seconds: float | None, every: bool) -> None:
        """Wait for subscribers, of every topic or of any. Raises NoAnswerError."""
        ask = all if every else any

        def heard() -> bool:
            return ask(count > 0 for count in self._outlets.listeners().values())

        self._one.wait_until(heard, seconds, f"subscribers of {', '.join(self._outlets.names)}")

    def play(self, rate: float, loop: bool, paused: bool, clock: BagClock | None) -> None:
        """Play until the end, or until somebody ends it."""
        player = Player(self._schedule, self._outlets.send, time.monotonic_ns, rate, loop, paused)
        offer_services(self._one.node, player)
        try:
            with Keyboard() as keyboard:
                screen = Screen(console, player, self._schedule.end, keyboard.there)
                with screen.live or nullcontext():
                    self._play(player, keyboard, screen, clock)
            self._outlets.settle()
        finally:
            _tell(player)

    def _play(self, player: Player, keyboard: Keyboard, screen: Screen, clock: BagClock | None) -> None:
        serve_at = 0
        player.begin()
        while not player.ended:
            due = player.advance()
            now = time.monotonic_ns()
            if clock is not None:
                clock.tick(now, player.position)
                due = clock.next if due is None else min(due, clock.next)
            wait = min(_LONGEST_WAIT if due is None else due - now, _LONGEST_WAIT)
            if wait > _WAKE_EARLY or now >= serve_at:
                serve_at = now + _SERVE_PERIOD
                self._one.executor.spin_once(timeout_sec=max(0, wait - _WAKE_EARLY) * 1e-9)
                screen.show(now)
                for key in keyboard.pressed():
                    if not _obey(key, player):
                        return


def _obey(key: str, player: Player) -> bool:
    """Do what a key says; return False if it ends the replay."""
    if key == " ":
        if player.timeline.paused:
            player.resume()
        else:
            player.pause()
    elif key == "right":
        player.step()
    elif key == "s":
        player.step_sample()
    elif key == "up":
        player.set_rate(player.timeline.rate * _RATE_STEP)
    elif key == "down":
        player.set_rate(player.timeline.rate / _RATE_STEP)
    return key != "q"


def _tell(player: Player) -> None:
    late = ""
    if player.timed:
        mean = player.total_lateness / player.timed
        late = f"; late by at most {player.worst * 1e-6:.2f} ms (at {player.worst_at * 1e-9:.3f} s), "
        late += f"{mean * 1e-6:.3f} ms on average"
    rounds = f" in {player.rounds} whole rounds" if player.rounds else ""
    console.print(f"sent    {player.sent} messages{rounds}{late}", highlight=False, soft_wrap=True)


def _expect_no_clock(bag: Bag, names: Mapping[str, str]) -> None:
    clocks = [topic.name for topic in bag.topics if topic.kind == CLOCK_KIND and topic.name in names]
    if clocks:
        raise BagError(f"--clock: the bag holds {clocks[0]}, which is played; leave it out with --exclude {clocks[0]}")
