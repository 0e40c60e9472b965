"""What `dp propeller` prints."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from rich.table import Table

from dp_tools.propeller.study import Study, Summary


def summary_table(studies: Sequence[Study]) -> Table:
    """Return the figures of every propeller, a column each."""
    table = Table(title="Propellers in open water", title_justify="left")
    table.add_column("", no_wrap=True)
    for one in studies:
        table.add_column(one.subject.name.replace("_", " "), justify="right")
    for label, cell in _ROWS:
        table.add_row(label, *(cell(one.summary) for one in studies))
    return table


def comparison_table(study: Study) -> Table:
    """Return the largest loss of efficiency of every controller, in the manner of [Ruth] Table 3.3."""
    printed = study.subject.printed
    title = f"Largest loss of efficiency, tau 0 to {study.last_loading:g} (Table 3.3)"
    table = Table(title=title, title_justify="left")
    table.add_column("controller", no_wrap=True)
    table.add_column("absolute", justify="right", no_wrap=True)
    table.add_column("relative", justify="right", no_wrap=True)
    if printed is not None:
        table.add_column(printed.source, justify="right", no_wrap=True)
        table.add_column("", justify="right", no_wrap=True)
    for row in study.comparisons:
        cells = [_percent(row.absolute), _percent(row.relative)]
        if printed is not None:
            cells += ["", ""] if row.printed is None else [_percent(value) for value in row.printed]
        table.add_row(row.name, *cells)
    return table


def printed_table(study: Study) -> Table | None:
    """Return single figures of a source beside ours; None if there are none."""
    printed, best = study.subject.printed, study.summary.best
    if printed is None:
        return None
    table = Table(title=f"Beside {printed.source}, which has {printed.polynomials}", title_justify="left")
    table.add_column("")
    table.add_column("here", justify="right")
    table.add_column(printed.source, justify="right")
    K_Qc = study.torque_coefficients
    rows = (
        ("K_T at J = 0, design pitch", study.summary.thrust_coefficient, printed.thrust_coefficient, ".4f"),
        ("K_Q at J = 0, design pitch", study.summary.torque_coefficient, printed.torque_coefficient, ".4f"),
        ("best P/D at J = 0", study.summary.bollard_pitch_ratio, printed.bollard_pitch_ratio, ".2f"),
        ("tau of the best efficiency", best.loading if best else None, printed.best_loading, ".2f"),
        ("P/D of the best efficiency", best.pitch_ratio if best else None, printed.best_pitch_ratio, ".2f"),
        ("tau from which the largest P/D is best", study.full_pitch_loading, printed.full_pitch_loading, ".2f"),
        (
            "K_Q there",
            K_Qc.get("full pitch"),
            printed.full_pitch_torque_coefficient,
            ".4f",
        ),
        ("K_Qc of the least relative loss", K_Qc.get("least error"), printed.least_error_torque_coefficient, ".4f"),
    )
    for label, ours, theirs, form in rows:
        table.add_row(label, "–" if ours is None else format(ours, form), format(theirs, form))
    return table


def remarks(study: Study) -> tuple[str, ...]:
    """Return what is not shown, and why; and data that contradict each other."""
    name = study.subject.name
    lines = [f"{name}: no {what}: {why}" for what, why in study.missing.items()]
    best = study.summary.best
    if best is not None and best.efficiency > 1.0:
        lines.append(
            f"{name}: the data contradict each other: efficiency {best.efficiency:.2f} at J = {best.advance_number:.2f}"
        )
    return tuple(lines)


def _percent(value: float) -> str:
    return f"{100.0 * value:.1f} %"


def _range(low: float, high: float) -> str:
    return f"{low:.3g} to {high:.3g}"


def _best(summary: Summary, name: str, form: str) -> str:
    return "–" if summary.best is None else format(getattr(summary.best, name), form)


_ROWS: tuple[tuple[str, Callable[[Summary], str]], ...] = (
    ("diameter (m)", lambda s: f"{s.diameter:.4g}"),
    ("design P/D", lambda s: f"{s.pitch_ratio:.4g}"),
    ("K_T at J = 0", lambda s: f"{s.thrust_coefficient:.4f}"),
    ("K_Q at J = 0", lambda s: f"{s.torque_coefficient:.4f}"),
    ("P/T^1.5 at J = 0 (W/N^1.5)", lambda s: f"{s.power_per_thrust_3_2:.4g}"),
    ("best P/D at J = 0", lambda s: "–" if s.bollard_pitch_ratio is None else f"{s.bollard_pitch_ratio:.3f}"),
    ("range of P/D", lambda s: "fixed" if s.pitch_range is None else _range(*s.pitch_range)),
    (
        "range of J",
        lambda s: "0 alone" if s.advance_number_end == 0.0 else _range(0.0, s.advance_number_end),
    ),
    ("range of tau", lambda s: "any" if math.isinf(s.largest_loading) else _range(0.0, s.largest_loading)),
    ("best efficiency", lambda s: _best(s, "efficiency", ".3f")),
    ("tau there", lambda s: _best(s, "loading", ".2f")),
    ("P/D there", lambda s: _best(s, "pitch_ratio", ".2f")),
)
