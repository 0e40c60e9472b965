"""What the supervisor says of itself on /diagnostics, as a function of the state of its processes."""

from __future__ import annotations

from collections.abc import Mapping

from dp_bringup.supervisor.policy import Phase, Policy
from dp_node.alarms import Alarm, raised
from dp_node.health import Health, health_with


def supervision_health(policies: Mapping[str, Policy], now: float) -> Health:
    """Return the health of the supervisor at ``now`` (s, its steady clock); ``policies`` by name of the process."""
    alarms: list[Alarm] = []
    values: dict[str, object] = {}
    for name, policy in policies.items():
        values[f"{name}.phase"] = str(policy.phase)
        values[f"{name}.restarts"] = policy.restarts
        if policy.reason:
            values[f"{name}.last_end"] = policy.reason
        if policy.phase is Phase.GIVEN_UP:
            alarms.append(raised("SUPERVISOR-NODE-GIVEN-UP", f"{name}, {policy.reason}"))
        elif policy.shaken(now):
            where = "runs again" if policy.phase is Phase.UP else "is on its way"
            alarms.append(raised("SUPERVISOR-NODE-RESTARTED", f"{name}, {policy.reason}; it {where}"))
        if policy.silent(now):
            alarms.append(raised("SUPERVISOR-NODE-SILENT", name))
    return health_with(alarms, values)
