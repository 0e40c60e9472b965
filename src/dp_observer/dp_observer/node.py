"""The observer as a ROS 2 node: pose and achieved force in, odometry out."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from dp_msgs.msg import ObserverState
from geometry_msgs.msg import PoseWithCovarianceStamped, WrenchStamped
from nav_msgs.msg import Odometry

from dp_node import AnswerGate, Health, RingNode, StampSequence, run_node, seconds_between, to_nanoseconds
from dp_observer.estimate import ObserverEstimate, ObserverInputs, ObserverStatus
from dp_observer.frozen_fix import FrozenFix
from dp_observer.lookahead import Lookahead
from dp_observer.node_health import Tally, health_of, status_alarm, status_text
from dp_observer.node_messages import (
    is_fix,
    require_frame,
    to_odometry,
    to_position,
    to_state,
    to_tau,
    to_vertical,
    to_vertical_tau,
)
from dp_observer.observer import Observer
from dp_observer.settings import ObserverSettings
from marine_model.errors import InputError
from marine_model.frames import BODY_FRAME, MAP_FRAME
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel

# The watchdog reckons on this many samples after the last pose, and once a sample from then on.
_PATIENCE = 1.5
_LOOKS_PER_SAMPLE = 8


class ObserverNode(RingNode[ObserverSettings]):
    """Answers every pose with odometry and observer_state; goes on without poses, if they do not come."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__("dp_observer", **kwargs)

    def default_settings(self, vessel: Vessel) -> ObserverSettings:
        """Return the core's defaults."""
        return ObserverSettings()

    def build(self) -> None:
        """Make core, publishers, subscriptions and watchdog."""
        self._sample = round(self.vessel.measurement.sample_time * 1e9)  # ns
        self._odometry = self.publish_on(Odometry, "odometry")
        self._state = self.publish_on(ObserverState, "observer_state")
        self._begin()
        self.listen(PoseWithCovarianceStamped, "pose", self._on_pose, exclusive=True)
        self.listen(WrenchStamped, "tau_achieved", self._on_tau)
        if not self.synchronous:
            self.create_timer(self._sample * 1e-9 / _LOOKS_PER_SAMPLE, self._watch)

    def apply(self, settings: ObserverSettings) -> None:
        """Hand changed settings to the core."""
        for observer in self._lookahead.observers():
            observer.apply(settings)

    def started(self) -> None:
        """Begin as after the first start."""
        self._begin()

    def health(self) -> Health:
        """Return status of the last estimate and counts."""
        self._tally.held = self._gate.held
        health = health_of(self._tally, self.vessel.drivers.command_timeout)
        self._tally.reported()
        return health

    def _begin(self) -> None:
        self._lookahead = Lookahead(Observer(self.vessel, self.settings), self._sample)
        self._gate = AnswerGate(self.synchronous)
        self._pose_stamps = StampSequence("pose", self._sample * 1e-9)
        self._tau_stamps = StampSequence("tau_achieved", self._sample * 1e-9)
        self._tau: FloatArray = np.zeros(3)
        self._vertical_tau: FloatArray | None = None  # of a submerged vehicle
        self._due = 0  # ns of the node's clock: when the watchdog acts
        self._tally = Tally()
        self._frozen = FrozenFix(self.vessel)
        self._first_pose: int | None = None  # ns

    def _on_tau(self, message: Any) -> None:
        require_frame("tau_achieved", BODY_FRAME, message.header.frame_id)
        tau = to_tau(message)
        below = to_vertical_tau(message) if self.vessel.is_submerged else None
        self._tau_stamps.follow(message.header.stamp)  # whether time began anew is for the poses to say
        self._tau, self._vertical_tau = tau, below
        self._gate.answer(to_nanoseconds(message.header.stamp))

    def _on_pose(self, message: Any) -> None:
        require_frame("pose", MAP_FRAME, message.header.frame_id)
        self._pose_stamps.step(message.header.stamp, 0.0)
        self._gate.submit(to_nanoseconds(message.header.stamp), partial(self._observe, message))

    def _observe(self, message: Any) -> None:
        stamp = to_nanoseconds(message.header.stamp)
        self._tally.poses += 1
        if self._first_pose is None:
            self._first_pose = stamp
        last = self._tau_stamps.last
        self._tally.force_age = seconds_between(self._first_pose if last is None else last, stamp)
        position: FloatArray | None = None
        below: FloatArray | None = None
        if is_fix(message):
            try:
                position = to_position(message)
                if self.vessel.is_submerged:
                    below = to_vertical(message)
            except InputError as error:
                # The sample counts all the same: who waits for its odometry gets one.
                position = None
                self.refuse(f"pose: {error}")
        if position is None:
            self._tally.without_fix += 1
        else:
            self._frozen.note(position)
            self._tally.equal_fixes = self._frozen.count
            self._tally.frozen = self._frozen.is_frozen(self.settings)
        newest = self._lookahead.stamp
        estimate = self._lookahead.measure(self._inputs(position, below, stamp), stamp)
        self._due = self._now() + round(_PATIENCE * self._sample)
        if estimate.status is ObserverStatus.OUTLIER_REFUSED:
            self._tally.outliers += 1
        if newest is not None and stamp <= newest:
            # The watchdog has answered for this sample already; time does not run backwards downstream.
            self._tally.late += 1
            return
        self._publish(estimate, stamp)

    def _watch(self) -> None:
        """Go on without a pose, one sample at a time, in the time base of the poses."""
        now = self._now()
        if not self.active or self._due == 0:
            return
        if self._due - now > 2 * round(_PATIENCE * self._sample):
            self._due = now + round(_PATIENCE * self._sample)  # the node's clock was set back
        while now >= self._due:
            self._due += self._sample
            newest = self._lookahead.stamp
            ahead = self._lookahead.run_ahead(self._inputs(None, None, newest or 0))
            if ahead is None:
                return
            self._tally.ahead += 1
            self._publish(*ahead)
            if now - self._due > self._sample * _LOOKS_PER_SAMPLE:
                self._due = now + self._sample  # the process was asleep: do not catch up on it sample by sample

    def _inputs(self, position: FloatArray | None, below: FloatArray | None, stamp: int) -> ObserverInputs:
        """Return a fix with the force achieved last: none once the drivers have stopped the thrusters, it is so old."""
        last = self._tau_stamps.last
        if last is None or stamp - last > self.vessel.drivers.command_timeout * 1e9:
            return ObserverInputs(position, np.zeros(3), below)
        return ObserverInputs(position, self._tau, below, self._vertical_tau)

    def _publish(self, estimate: ObserverEstimate, stamp: int) -> None:
        self._odometry.publish(to_odometry(estimate, stamp))
        self._state.publish(to_state(estimate, stamp))
        before = self._tally.status
        self._tally.estimated(estimate.status, estimate.time_since_measurement)
        if estimate.status is not before:
            self._report(estimate.status)

    def _report(self, status: ObserverStatus) -> None:
        if status_alarm(status) is None:
            self.get_logger().info(status_text(status))
        else:
            self.get_logger().warning(status_text(status))

    def _now(self) -> int:
        return int(self.get_clock().now().nanoseconds)


def main() -> None:
    """Run the node until SIGINT or SIGTERM."""
    run_node(ObserverNode)
