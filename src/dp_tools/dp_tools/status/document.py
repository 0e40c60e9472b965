"""What `dp status --json` says: the same as the screen, for programs."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from dp_bringup.graph_nodes import NODES
from dp_tools.status.alarm_log import ShownAlarm
from dp_tools.status.state import SILENT, StatusState

_MARGINS = (
    "status",
    "azimuth_mode",
    "method",
    "feasible_load",
    "solver",
    "margin",
    "margin_turned",
    "minimum_gain",
    "gain_limit",
    "demanded_power",
    "commanded_power",
    "power_stage",
)


def to_document(state: StatusState, now: float) -> dict[str, Any]:
    """Return plain values at ``now`` (s), SI units and radians; None where something is unknown or not finite."""
    document = {
        "namespace": state.namespace,
        "vessel_name": None if state.vessel is None else state.vessel.name,
        "simulated_time": state.simulated_time,
        "pace": state.pace,
        "vessel": _vessel(state),
        "margins": _margins(state),
        "thrusters": [asdict(row) for row in state.thrusters()],
        "nodes": [_node(state, name, now) for name in (*NODES, *sorted(set(state.nodes) - set(NODES)))],
        "alarms": [_alarm(alarm, now) for alarm in state.shown_alarms(now)],
    }
    plain: dict[str, Any] = _plain(document)
    return plain


def _vessel(state: StatusState) -> dict[str, Any]:
    controller, observer, odometry = (
        state.newest(topic) for topic in ("controller_status", "observer_state", "odometry")
    )
    wind, pose = state.newest("wind"), state.pose()
    found: dict[str, Any] = {"position": None if pose is None else list(pose)}
    if odometry is not None:
        twist = odometry.twist.twist
        found["velocity"] = [twist.linear.x, twist.linear.y, twist.angular.z]
    if controller is not None:
        found |= {"mode": controller.mode, "status": controller.status, "answer": controller.message}
        found |= {"reference": list(controller.reference_position), "error": list(controller.error)}
    below = state.below()
    if below is not None:
        found |= {"depth": below[0], "roll": below[1], "pitch": below[2]}
        if controller is not None:
            found |= {"vertical_reference": list(controller.vertical_reference)}
            found |= {"vertical_error": list(controller.vertical_error)}
    if observer is not None:
        found |= {"observer": observer.status, "time_since_measurement": observer.time_since_measurement}
    if wind is not None:
        found["wind"] = [wind.vector.x, wind.vector.y]
    return found


def _margins(state: StatusState) -> dict[str, Any] | None:
    status = state.newest("allocation_status")
    if status is None:
        return None
    return {name: getattr(status, name) for name in _MARGINS} | {"slack": list(status.slack)}


def _node(state: StatusState, name: str, now: float) -> dict[str, Any]:
    report, rate = state.nodes.get(name), state.rate(name)
    if report is None:
        return {"name": name, "level": None, "message": "no report", "rate": rate, "silent": None}
    age = now - report.seen
    return {
        "name": name,
        "level": report.level.name,
        "message": report.message if age <= SILENT else f"no data for {age:.1f} s",
        "state": report.values.get("state"),
        "rate": rate,
        "silent": age,
        "values": report.values,
    }


def _alarm(alarm: ShownAlarm, now: float) -> dict[str, Any]:
    return {
        "node": alarm.node,
        "code": alarm.code,
        "level": alarm.level.name,
        "text": alarm.text,
        "advice": alarm.advice,
        "active": alarm.until is None,
        "seconds": (now if alarm.until is None else alarm.until) - alarm.since,
    }


def _plain(value: Any) -> Any:
    """Return ``value`` as JSON has it: no NaN, no infinity, no numpy."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, bool | str | int) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None
