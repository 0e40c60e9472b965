"""`dp replay BAG --into NODE`: what the operator asks for, and what is shown."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from dp_bringup.workspace import RING_PACKAGES, SIMULATOR_PACKAGE
from dp_tools.bags.bag import Bag
from dp_tools.reexecution.comparison import Judge, TopicComparison
from dp_tools.reexecution.errors import ReexecutionError
from dp_tools.reexecution.known_fields import logged_in_process, told_in_process, whole
from dp_tools.reexecution.new_bag import write_outputs
from dp_tools.reexecution.recording import Recording, recording_of
from dp_tools.reexecution.reexecute import Reexecution, Subject, reexecute
from dp_tools.reexecution.table import show
from marine_model.yaml_document import parse_value

_NODES = (*RING_PACKAGES, SIMULATOR_PACKAGE)
_ALL = "all"


@dataclass(frozen=True)
class Asked:
    """What is asked for.

    Parameters
    ----------
    into
        Nodes, or ``all``.
    verify
        True to compare with what was recorded.
    given
        ``node.parameter=value``, each.
    output
        Bag for the new outputs; None for none.
    overwrite
        True to replace a bag that is there.
    tolerance
        Numbers that are no further apart are taken for the same.
    only_first
        True to show the first difference of every topic only.
    namespace
        Of the graph in the bag; empty for the only one.
    """

    into: Sequence[str]
    verify: bool
    given: Sequence[str] = ()
    output: Path | None = None
    overwrite: bool = False
    tolerance: float = 0.0
    only_first: bool = False
    namespace: str = ""


def replay_into(bag: Bag, asked: Asked, console: Console) -> bool:
    """Re-execute nodes from a bag; return whether all that was compared is the same.

    Raises
    ------
    DpError
        If a node or parameter is unknown, the bag lacks something, or the new bag cannot be written.
    """
    if not asked.verify and asked.output is None:
        raise ReexecutionError("--into: expected --verify, --output, or both, found neither")
    recording = recording_of(bag)
    namespace = _namespace(recording, asked.namespace)
    names = _names(recording, namespace, asked.into)
    given = _given(asked.given, names)
    found = []
    agrees = True
    for name in names:
        with _bar(console, name) as progress:
            began = time.perf_counter()
            one = reexecute(Subject(recording, namespace, name, given.get(name, {})), progress)
            wall = time.perf_counter() - began
        _tell(console, one, wall)
        if asked.verify:
            agrees &= _verify(console, one, asked)
        found.append(one)
    if asked.output is not None:
        count = write_outputs(asked.output, found, asked.overwrite)
        console.print(f"bag     {asked.output}, {count} messages", soft_wrap=True)
    return agrees


def compare(one: Reexecution, tolerance: float = 0.0, only_first: bool = False) -> list[TopicComparison]:
    """Compare the outputs of a node with the recorded ones, topic by topic."""
    recording = one.subject.recording
    judge = Judge(recording.start, tolerance, recording.in_process, only_first)
    comparisons = []
    for topic, caught in one.outputs.items():
        recorded = one.subject.messages(topic)
        if not recorded:
            continue
        if recording.in_process:
            caught = [message for message in caught if logged_in_process(message)]
        pick = told_in_process(topic) if recording.in_process else whole
        comparisons.append(judge.compare(topic, one.kinds[topic], pick, recorded, caught))
    return comparisons


def _verify(console: Console, one: Reexecution, asked: Asked) -> bool:
    comparisons = compare(one, asked.tolerance, asked.only_first)
    compared = {comparison.topic for comparison in comparisons}
    show(console, "", comparisons, [topic for topic in one.outputs if topic not in compared])
    agrees = all(comparison.agrees for comparison in comparisons)
    same = sum(comparison.same for comparison in comparisons)
    after = sum(comparison.after_end for comparison in comparisons)
    if after:
        console.print(f"        {after} messages came after the last recorded ones, and are not judged", soft_wrap=True)
    if agrees:
        verdict = f"[green]identical[/]: {same} messages"
        if asked.tolerance > 0.0:
            verdict = f"[green]the same within {asked.tolerance:g}[/]: {same} messages"
        if one.broken is not None:
            verdict += f"; {_broken(one)}"
        console.print(f"{one.subject.name}: {verdict}", soft_wrap=True)
    else:
        firsts = [(spot.simulated, comparison.topic, spot) for comparison in comparisons if (spot := comparison.first)]
        _, topic, spot = min(firsts, key=lambda first: first[:2])
        console.print(
            f"{one.subject.name}: [red]differs[/], first at {spot.simulated:.3f} s in {topic}, {spot.path}",
            soft_wrap=True,
        )
        if one.begins:
            console.print(
                f"        as is to be expected where a node had been running before: {one.begins}", soft_wrap=True
            )
        if one.broken is not None:
            console.print(f"        {_broken(one)}", soft_wrap=True)
    return agrees


def _broken(one: Reexecution) -> str:
    broken = one.broken
    if broken is None:
        return ""
    at = (broken.time - one.subject.recording.start) * 1e-9
    return f"[yellow]{broken.reason} at {at:.3f} s of the bag: what came after is not judged[/]"


def _tell(console: Console, one: Reexecution, wall: float) -> None:
    speed = f", {one.simulated / wall:.3g} x real time" if one.simulated > 0.0 else ""
    console.print(
        f"{one.subject.name}: its own class {one.class_name} without middleware, fed {one.steps} messages and changes "
        f"in {wall:.2f} s{speed}",
        highlight=False,
        soft_wrap=True,
    )
    notes = list(one.notes)
    if one.subject.recording.in_process:
        notes.append("a run in process: compared are the fields that it logs")
    for note in notes:
        console.print(f"        note: {note}", markup=False, highlight=False, soft_wrap=True)


def _namespace(recording: Recording, asked: str) -> str:
    found = recording.namespaces()
    if asked:
        wanted = f"/{asked.strip('/')}/"
        if wanted not in found:
            raise ReexecutionError(f"--namespace: expected one of {', '.join(found) or 'none'}, found {wanted}")
        return wanted
    if len(found) != 1:
        what = f"graphs in {', '.join(found)}; choose with --namespace" if found else "no thruster_feedback"
        raise ReexecutionError(f"{recording.path}: expected one graph, found {what}")
    return found[0]


def _names(recording: Recording, namespace: str, asked: Sequence[str]) -> list[str]:
    """Return the nodes in the order of the ring, each once."""
    unknown = [name for name in asked if name not in (*_NODES, _ALL)]
    if unknown:
        raise ReexecutionError(f"--into: expected {_ALL} or one of {', '.join(_NODES)}, found {unknown[0]}")
    return [name for name in _NODES if name in asked or _ALL in asked]


def _given(texts: Sequence[str], names: Sequence[str]) -> Mapping[str, Mapping[str, Any]]:
    given: dict[str, dict[str, Any]] = {}
    for text in texts:
        place, equals, value = text.partition("=")
        node, dot, parameter = place.partition(".")
        if not equals or not dot or not parameter:
            raise ReexecutionError(f"--set: expected node.parameter=value, found {text}")
        if node not in names:
            raise ReexecutionError(f"--set: expected a node out of --into ({', '.join(names)}), found {node}")
        given.setdefault(node, {})[parameter] = parse_value(value)
    return given


@contextmanager
def _bar(console: Console, name: str) -> Iterator[Callable[[int, int], None]]:
    columns = (
        TextColumn("{task.description:<17}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(name, total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)
