"""`python -m benchmarks`: measure, print, and write results.json and machine.json."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, TaskID

from benchmarks.accuracy import measure_accuracy
from benchmarks.allocation import measure_allocation
from benchmarks.driver_load import measure_driver_load
from benchmarks.gain_map import measure_gain_map
from benchmarks.graph import measure_composed, measure_separate
from benchmarks.hop import measure_hop
from benchmarks.in_process import measure_in_process
from benchmarks.machine import describe_machine, write_machine
from benchmarks.parts import measure_parts
from benchmarks.plan import Plan, quick, whole
from benchmarks.printout import print_machine, print_results
from benchmarks.propulsion import measure_propulsion
from benchmarks.recording import measure_recording
from benchmarks.result import Result, write_results
from benchmarks.scaling import measure_scaling
from benchmarks.sea import measure_sea
from benchmarks.sectors import measure_sectors
from benchmarks.start_up import measure_start_up

_MEASUREMENTS: dict[str, tuple[str, Callable[[Plan], list[Result]]]] = {
    "hop": ("One hop of the ring", measure_hop),
    "recording": ("Recorder", measure_recording),
    "in_process": ("In-process loop", measure_in_process),
    "sea": ("In-process loop in an irregular sea", measure_sea),
    "parts": ("Processor time of the in-process loop by part", measure_parts),
    "separate": ("Lockstep graph, one process a node", measure_separate),
    "composed": ("Lockstep graph, one process", measure_composed),
    "start_up": ("Start-up", measure_start_up),
    "driver_load": ("Drivers in real time", measure_driver_load),
    "allocation": ("Allocation step", measure_allocation),
    "sectors": ("Allocation with forbidden sectors", measure_sectors),
    "accuracy": ("Accuracy of the allocation", measure_accuracy),
    "scaling": ("Allocation by number of thrusters and sectors", measure_scaling),
    "gain_map": ("Map of the minimum gain", measure_gain_map),
    "propulsion": ("Step of the propulsion plant", measure_propulsion),
}
# Tests take ROS domains up to 101. From 215 on the ports of a domain lie above Linux's ephemeral range.
_DOMAIN = "220"
_WIDTH = 160  # columns, where the output goes to no terminal


def main(arguments: Sequence[str]) -> int:
    """Run the measurements; 0 unless one of them failed. A missed aim is a result, not a failure."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="little of everything: shows that it works, not how fast")
    parser.add_argument("--only", action="append", choices=_MEASUREMENTS, help="one measurement; may be repeated")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent, help="folder of the two files")
    chosen = parser.parse_args(arguments)
    os.environ.setdefault("ROS_DOMAIN_ID", _DOMAIN)
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")

    console = Console() if sys.stdout.isatty() else Console(width=_WIDTH)
    machine = describe_machine()
    print_machine(console, machine)
    results: list[Result] = []
    failed: list[str] = []
    with tempfile.TemporaryDirectory(prefix="dp_benchmarks_") as scratch:
        plan = quick(Path(scratch)) if chosen.quick else whole(Path(scratch))
        for name in chosen.only or _MEASUREMENTS:
            title, measure = _MEASUREMENTS[name]
            try:
                with Progress(console=console, transient=True) as bar:
                    line = bar.add_task(f"measuring: {title}", total=None)
                    found = measure(replace(plan, progress=_shown(bar, line)))
            except Exception as error:  # whatever it was, the others can still be measured
                failed.append(name)
                console.print(f"{name}: failed: {type(error).__name__}: {error}", markup=False, style="red")
                traceback.print_exc()
                continue
            print_results(console, title, found)
            results += found
    machine["load_average_1_min_after"] = os.getloadavg()[0]
    chosen.output.mkdir(parents=True, exist_ok=True)
    write_results(chosen.output / "results.json", results)
    write_machine(chosen.output / "machine.json", machine)
    missed = [result.name for result in results if result.met is False]
    console.print(f"load after the last: {machine['load_average_1_min_after']:.1f}", highlight=False)
    console.print(f"aims missed: {', '.join(missed) or 'none'}; figures in {chosen.output / 'results.json'}")
    if failed:
        console.print(f"failed: {', '.join(failed)}", style="red")
    return 1 if failed else 0


def _shown(bar: Progress, line: TaskID) -> Callable[[int, int], None]:
    """Return what a measurement tells how far it is."""
    return lambda done, total: bar.update(line, completed=done, total=total)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
