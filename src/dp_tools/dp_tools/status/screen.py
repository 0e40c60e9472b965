"""The screen of `dp status`: a pure function of what is known, the time and the size of the terminal."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.layout import Layout
from rich.padding import Padding
from rich.rule import Rule
from rich.table import Table
from rich.text import Text

from dp_bringup.graph_nodes import NODES
from dp_node import Level
from dp_tools.status.alarm_log import ShownAlarm
from dp_tools.status.bars import share_bar, thrust_bar
from dp_tools.status.state import RECORDER, SILENT, NodeReport, StatusState, ThrusterRow
from dp_tools.status.watch_circle import watch_circle

# The smallest terminal that holds all of it; a smaller one shows the upper left part.
WIDTH, HEIGHT = 80, 24
_TOP = 8  # rows of vessel and margins, with the title
_MARK = {Level.OK: ("●", "green"), Level.WARN: ("▲", "yellow"), Level.ERROR: ("■", "bold red")}


def render(state: StatusState, now: float, width: int, height: int) -> Layout:
    """Return the screen for a terminal of ``width`` by ``height`` characters at ``now`` (s)."""
    width, height = max(width, WIDTH), max(height, HEIGHT)
    rows = state.thrusters()
    layout = Layout()
    layout.split_column(
        Layout(_header(state, now), name="header", size=1),
        Layout(name="top", size=_TOP),
        Layout(_thrusters(rows, width), name="thrusters", size=2 + max(len(rows), 1)),
        Layout(name="bottom"),
    )
    right, nodes = max(27, width // 3), _nodes_width(width)
    layout["top"].split_row(
        Layout(_apart(_vessel(state, now)), name="vessel"),
        Layout(_margins(state, now, right), name="margins", size=right),
    )
    space = height - 1 - _TOP - 2 - max(len(rows), 1) - 1
    layout["bottom"].split_row(
        Layout(_apart(_nodes(state, now, nodes)), name="nodes", size=nodes),
        Layout(_alarms(state, now, width - nodes, space), name="alarms"),
    )
    return layout


def fitting_height(state: StatusState, now: float, width: int) -> int:
    """Return the height at which nothing has to be left out."""
    width = max(width, WIDTH)
    nodes = len(set(NODES) | set(state.nodes))
    alarms = sum(len(_alarm(alarm, now, width - _nodes_width(width))) for alarm in state.shown_alarms(now))
    return max(1 + _TOP + 2 + max(len(state.thrusters()), 1) + 1 + max(nodes, alarms), HEIGHT)


def _nodes_width(width: int) -> int:
    return 36 if width < 120 else width // 2


def _apart(body: RenderableType) -> Padding:
    """Leave a column free to the right."""
    return Padding(body, (0, 1, 0, 0))


def _titled(title: str, body: RenderableType, age: float = 0.0) -> Group:
    """Put a title over ``body``; it tells the age (s) of what is below, once there is nothing new."""
    head = Text().append(title, "bold")
    if SILENT < age < math.inf:
        head.append(f", no data for {age:.1f} s", "bold red")
    return Group(Rule(head, align="left", style="blue"), body)


def _header(state: StatusState, now: float) -> Table:
    line = Table.grid(expand=True)
    line.add_column(no_wrap=True)
    line.add_column(justify="right", no_wrap=True)
    left = Text().append(" DP ", "bold white on blue")
    left.append(f" {state.namespace}", "bold")
    if state.vessel is not None:
        left.append(f"  {state.vessel.name}")
    time = state.simulated_time
    if time is not None:
        left.append(f"  {_clock(time)}")
        if state.pace is not None:
            left.append(f" ×{state.pace:.3g}", "dim")
    line.add_row(left, _recording(state, now).append("  ").append_text(_tally(state, now)))
    return line


def _tally(state: StatusState, now: float) -> Text:
    active = state.alarms.active
    silent = sum(now - report.seen > SILENT for report in state.nodes.values())
    if silent:
        return Text(f" {silent} node{'s' if silent > 1 else ''} silent ", "bold white on red")
    if not active:
        return Text(" no alarms ", "black on green")
    worst = max(alarm.level for alarm in active)
    style = "bold white on red" if worst is Level.ERROR else "black on yellow"
    return Text(f" {len(active)} alarm{'s' if len(active) > 1 else ''} ", style)


def _recording(state: StatusState, now: float) -> Text:
    report = state.recorder
    if report is None or now - report.seen > SILENT:
        return Text("not recording", "dim")
    size = float(report.values.get("bytes", "0")) / 1e6
    if report.level is Level.ERROR:
        return Text("recording stopped", "bold red")
    lost = report.values.get("lost", "0")
    text = Text().append("● ", "bold red").append(f"recording {size:.1f} MB")
    return text.append(f", {lost} lost", "yellow") if lost != "0" else text


def _vessel(state: StatusState, now: float) -> Group:
    controller, observer = state.newest("controller_status"), state.newest("observer_state")
    odometry, wind, pose = state.newest("odometry"), state.newest("wind"), state.pose()
    facts = Table.grid(padding=(0, 1))
    facts.add_column(style="dim", no_wrap=True, min_width=9)
    facts.add_column(no_wrap=True)
    mode = "–" if controller is None else controller.mode
    facts.add_row("mode", Text(mode, "bold"))
    here = Text("–") if pose is None else Text(_place(*pose))
    if odometry is not None and pose is None:
        here = Text("invalid", "bold red")
    facts.add_row("position", here)
    if controller is None:
        facts.add_row("reference", "–")
        facts.add_row("error", "–")
    else:
        r, e = controller.reference_position, controller.error
        facts.add_row("reference", _place(r[0], r[1], r[2]))
        facts.add_row("error", f"{math.hypot(e[0], e[1]):.3f} m  {_degrees(e[2])}")
    if odometry is None:
        facts.add_row("velocity", "–")
    else:
        v = odometry.twist.twist
        facts.add_row("velocity", f"{_fixed(v.linear.x)}  {_fixed(v.linear.y)} m/s  {_degrees(v.angular.z)}/s")
    if state.vessel is not None and state.vessel.is_submerged:
        facts.add_row("depth", _below(state))
    else:
        facts.add_row("wind", "–" if wind is None else _wind(wind))
    facts.add_row("last fix", "–" if observer is None else f"{observer.time_since_measurement:.1f} s ago")
    age = state.age("odometry", now)
    if pose is None or controller is None:
        return _titled("Vessel", facts, age)
    reference = controller.reference_position
    away = (pose[0] - reference[0], pose[1] - reference[1], pose[2])
    if not all(map(math.isfinite, away)):
        return _titled("Vessel", facts, age)
    picture, radius = watch_circle(*away)
    both = Table.grid(expand=True)
    both.add_column()
    both.add_column(width=15, no_wrap=True)
    both.add_row(facts, picture)
    return _titled(f"Vessel, circle of {radius:g} m", both, age)


def _below(state: StatusState) -> str:
    """Return depth, and trim and heel, of a submerged vehicle."""
    below = state.below()
    if below is None:
        return "–"
    depth, roll, pitch = below
    return f"{depth:.3f} m  roll {_degrees(roll)}  pitch {_degrees(pitch)}"


def _wind(message: object) -> str:
    """Return the wind relative to the vessel: speed, and where it comes from as seen from the bridge."""
    x, y = message.vector.x, message.vector.y  # type: ignore[attr-defined]
    speed = math.hypot(x, y)
    if speed < 0.005:
        return "0.00 m/s"
    side = math.degrees(math.atan2(-y, -x))
    board = "starboard" if side > 0.0 else "port"
    return f"{speed:.2f} m/s from {abs(side):.0f}° {board}"


def _margins(state: StatusState, now: float, width: int) -> Group:
    status = state.newest("allocation_status")
    table = Table.grid(padding=(0, 1))
    table.add_column(style="dim", no_wrap=True, min_width=9)
    table.add_column(no_wrap=True)
    if status is None:
        table.add_row("status", Text("–", "dim"))
        return _titled("Margins", table)
    # The quadratic program is what everybody expects.
    how = status.azimuth_mode if status.method in ("", "qp") else status.method
    table.add_row("status", f"{status.status}, {how}")
    bar = max(width - 19, 4)
    for name, value in (("margin", status.margin), ("turned", status.margin_turned)):
        table.add_row(name, _margin(value, bar))
    gain = status.minimum_gain
    poor = math.isfinite(status.gain_limit) and gain < status.gain_limit
    gains = Text().append_text(_text(gain, "{:.2f}", "yellow" if poor else ""))
    table.add_row("gain", gains.append(f" ({_short(status.minimum_gain_both_ways)})"))
    table.add_row("slack", " ".join(map(_short, status.slack)))
    limited = status.power_stage not in ("", "within")
    power = f"{_short(status.commanded_power)} of {_short(status.demanded_power)} W"
    table.add_row("power", Text(power, "yellow" if limited else ""))
    demand = state.newest("tau_desired")
    if demand is not None:
        w = demand.wrench
        table.add_row("demand", " ".join(map(_short, (w.force.x, w.force.y, w.torque.z))))
    return _titled("Margins", table, state.age("allocation_status", now) if width >= 32 else 0.0)


def _margin(value: float, width: int) -> Text:
    """Return a margin: the bar is full where none of it is left."""
    if math.isinf(value):
        return share_bar(0.0, width, "green").append("     ∞")
    used = 1.0 / value if value > 0.0 else 1.0
    style = "green" if used < 0.8 else "yellow" if used <= 1.0 else "red"
    return share_bar(used, width, style).append(f" {min(value, 999.0):5.3g}", "bold red" if value < 1.0 else "")


def _thrusters(rows: Sequence[ThrusterRow], width: int) -> Table:
    table = Table(box=None, expand=True, padding=(0, 1, 0, 0), header_style="dim", title_justify="left")
    table.title = None
    table.add_column(Text("Thruster", "bold not dim"), no_wrap=True, min_width=10)
    bar = 15 if width < 100 else 31
    table.add_column("astern │ ahead", width=bar, no_wrap=True)
    for name in ("N", "to °", "is °", "Hz", "W"):
        table.add_column(name, justify="right", no_wrap=True, min_width=5)
    table.add_column("", no_wrap=True, width=12)
    if not rows:
        table.add_row(Text("no thruster_command", "dim"))
    for row in rows:
        low = row.thrust_min if row.thrust_min is not None else -abs(row.thrust or 1.0)
        high = row.thrust_max if row.thrust_max is not None else abs(row.thrust or 1.0)
        style = "dim" if row.disabled else "yellow" if row.saturated else "green"
        table.add_row(
            Text(row.name, "dim strike" if row.disabled else ""),
            Text("–") if row.thrust is None else thrust_bar(row.thrust, low, high, bar, style),
            _text(row.thrust, "{:.2f}"),
            _text(None if row.azimuth is None else math.degrees(row.azimuth), "{:.0f}"),
            _text(None if row.measured_azimuth is None else math.degrees(row.measured_azimuth), "{:.0f}"),
            _text(row.shaft_speed, "{:.1f}"),
            _text(row.power, "{:.2f}" if abs(row.power or 0.0) < 1e3 else "{:.0f}"),
            _flags(row),
        )
    return table


def _flags(row: ThrusterRow) -> Text:
    if row.disabled:
        return Text("disabled", "bold red")
    text = Text()
    if row.ventilating:
        text.append("air ", "bold magenta")
    if row.saturated:
        text.append("at limit", "yellow")
    return text


def _nodes(state: StatusState, now: float, width: int) -> Group:
    table = Table.grid(padding=(0, 1), expand=True)
    table.add_column(width=1)
    table.add_column(no_wrap=True, width=16)
    table.add_column(no_wrap=True, justify="right", width=6)
    table.add_column(no_wrap=True, ratio=1, overflow="ellipsis")
    others = sorted(set(state.nodes) - set(NODES))
    for name in (*NODES, *others):
        report, rate = state.nodes.get(name), state.rate(name)
        hertz = Text("" if rate is None else f"{rate:.3g}/s")
        table.add_row(*_node(name, report, hertz, now, width >= 50))
    return _titled("Nodes", table)


def _node(name: str, report: NodeReport | None, hertz: Text, now: float, wide: bool) -> tuple[Text, Text, Text, Text]:
    if report is None:
        return Text("○", "dim"), Text(name, "dim"), hertz, Text("none", "dim")
    silent = now - report.seen
    if silent > SILENT:
        said = f"no data for {silent:.1f} s" if wide else f"{silent:.1f} s"
        return Text("✕", "bold red"), Text(name, "red"), Text("" if wide else "silent", "red"), Text(said, "bold red")
    mark, style = _MARK[report.level]
    own = report.values.get("state", "")
    said = report.message if wide or report.level is Level.OK else "alarm" if own in ("", "active") else own
    if name == RECORDER and report.level is Level.OK:
        hertz, said = Text(report.values.get("messages", "")), "messages"
    return Text(mark, style), Text(name), hertz, Text(said, "dim" if report.level is Level.OK else "")


def _alarms(state: StatusState, now: float, width: int, rows: int) -> Group:
    """Return as many alarms as there is room for, the last row telling how many more there are."""
    table = Table.grid(expand=True)
    table.add_column(no_wrap=True, overflow="ellipsis")
    lines: list[Text] = []
    shown = state.shown_alarms(now)
    if not shown:
        lines.append(Text("none", "dim"))
    for alarm in shown:
        lines += _alarm(alarm, now, width)
    if len(lines) > rows:
        left = sum(1 for line in lines[max(rows - 1, 0) :] if not line.plain.startswith(" "))
        lines = [*lines[: max(rows - 1, 0)], Text(f"… and {left} more", "dim")]
    for line in lines:
        table.add_row(line)
    return _titled("Alarms", table)


def _alarm(alarm: ShownAlarm, now: float, width: int) -> list[Text]:
    if alarm.until is not None:
        return [Text(f"✓ {alarm.code}  over for {_span(now - alarm.until)}", "dim")]
    mark, style = _MARK[alarm.level]
    head = Text().append(f"{mark} ", style).append(alarm.code, "dim" if alarm.acknowledged else style)
    head.append(f"  {_span(now - alarm.since)}", "dim")
    if not alarm.code.startswith(_PREFIX.get(alarm.node, "?")):
        head.append(f"  {alarm.node}")
    if alarm.acknowledged:
        return [head.append("  seen", "dim")]
    text = textwrap.wrap(alarm.text, width, initial_indent="  ", subsequent_indent="  ")
    advice = textwrap.wrap(alarm.advice, width, initial_indent="  → ", subsequent_indent="    ")
    return [head, *[Text(line) for line in text], *[Text(line, "cyan") for line in advice]]


# Whose alarms begin with what: the node need not be named beside them.
_PREFIX = {
    "dp_observer": "OBSERVER",
    "dp_controller": "CONTROLLER",
    "thrust_allocator": "ALLOCATOR",
    "thruster_drivers": "DRIVERS",
    "vessel_sim": "SIMULATOR",
    "recorder": "RECORDER",
    "supervisor": "SUPERVISOR",
}


def _text(value: float | None, form: str, style: str = "") -> Text:
    return Text("–", "dim") if value is None or math.isnan(value) else Text(form.format(value), style)


def _place(north: float, east: float, heading: float) -> str:
    bearing = round(math.degrees(heading) % 360.0, 1) % 360.0
    return f"N {_fixed(north)}  E {_fixed(east)} m  {bearing:.1f}°"


def _fixed(value: float, digits: int = 3) -> str:
    """Return a number with so many digits after the point, and no minus before a zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _degrees(angle: float) -> str:
    return f"{_fixed(math.degrees(angle), 1)}°"


def _short(value: float) -> str:
    """Return a number in three digits, thousands and millions with a letter."""
    if not math.isfinite(value):
        return "–"
    size = abs(value)
    if size < 0.005:
        return "0"
    if size < 999.5:
        return f"{value:.2f}" if size < 1.0 else f"{value:.3g}"
    return f"{value / 1e3:.3g}k" if size < 999.5e3 else f"{value / 1e6:.3g}M"


def _span(seconds: float) -> str:
    seconds = max(seconds, 0.0)
    if seconds < 60.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 3600.0 else f"{seconds / 3600.0:.1f} h"


def _clock(seconds: float) -> str:
    """Return a stamp: simulated time as seconds, that of the wall as a time of day (UTC)."""
    if seconds < 1e7:
        return f"{seconds:.1f} s"
    minutes, second = divmod(seconds % 86400.0, 60.0)
    return f"{int(minutes // 60):02d}:{int(minutes % 60):02d}:{int(second):02d} UTC"
