"""The closed loop in process, with a disturber between the measured pose and the observer.

What the observer's node does with messages is done here with the same parts: stamps are judged, a pose that comes late
is not answered, estimates are made ahead while none comes. Of the controller, allocator and drivers only the cores are
here: what their nodes do with stamps that jump is for the graph to show.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from dp_node import SourceRestartError, StampSequence, from_nanoseconds
from dp_observer import ObserverEstimate, ObserverInputs, ObserverStatus
from dp_observer.alarm_codes import codes_of
from dp_observer.frozen_fix import FrozenFix
from dp_observer.lookahead import Lookahead
from dp_observer.observer import Observer
from dp_tools.disturber.disturber import Disturber, PoseSample
from dp_tools.disturber.settings import DisturberSettings
from dp_tools.in_process import ClosedLoop
from dp_tools.scenario import Scenario
from marine_model import Vessel
from marine_model.errors import InputError
from marine_model.frames import heading_to_quaternion, quaternion_to_heading
from marine_model.guards import FloatArray
from marine_model.settings import with_parameters

REFUSED = "NODE-INPUT-REFUSED"
RESTARTED = "NODE-SOURCE-RESTARTED"
_REPORT = 1_000_000_000  # ns between two reports of health, as on /diagnostics in real time


@dataclass(slots=True)
class _Second:
    """What happened since the last report."""

    status: ObserverStatus
    poses: int = 0
    missing: int = 0  # without a fix, refused as outliers, late, or made up for
    refused: int = 0
    reinitialised: bool = False
    frozen: bool = False
    began_anew: bool = False

    def codes(self) -> list[str]:
        """Return the alarms of the report."""
        found = codes_of(self.status, self.reinitialised, self.poses, self.missing, self.frozen)
        if self.refused:
            found.append(REFUSED)
        if self.began_anew:
            found.append(RESTARTED)
        return found


@dataclass(slots=True)
class Witness:
    """What was seen of a run, at every control sample.

    Attributes
    ----------
    time
        s.
    position
        True position without the wave motion: north (m), east (m), heading (rad).
    alarms
        Codes that were active in a report, and when for the first time (s).
    refused
        Messages refused.
    """

    time: list[float] = field(default_factory=list)
    position: list[FloatArray] = field(default_factory=list)
    alarms: dict[str, float] = field(default_factory=dict)
    refused: int = 0


class DisturbedLoop(ClosedLoop):
    """Sails a scenario with faults that come and go.

    Parameters
    ----------
    vessel, scenario
        As of :class:`ClosedLoop`.
    faults
        Changes of the disturber's settings, each from a time (s) on.

    Raises
    ------
    InputError
        If the scenario's or the faults' parameters are refused.
    """

    def __init__(self, vessel: Vessel, scenario: Scenario, faults: list[tuple[float, dict[str, object]]]) -> None:
        super().__init__(vessel, scenario)
        self.witness = Witness()
        self._sample_ns = round(vessel.measurement.sample_time * 1e9)
        self._disturber = Disturber(DisturberSettings(seed=scenario.seed))
        self._changes = [
            (round(at * 1e9), with_parameters(DisturberSettings(seed=scenario.seed), values))
            for at, values in sorted(faults, key=lambda change: change[0])
        ]
        self._answer_stamp: int | None = None
        self._second = _Second(ObserverStatus.UNINITIALISED)
        self._begin()

    def _begin(self) -> None:
        self._ahead = Lookahead(Observer(self._vessel, self._observer.settings), self._sample_ns)
        self._stamps = StampSequence("pose", self._sample_ns * 1e-9)
        self._frozen = FrozenFix(self._vessel)

    def _control(self, k: int) -> None:
        truth = self._simulator.truth()
        self.witness.time.append(k * self._step_ns * 1e-9)
        self.witness.position.append(truth.position.copy())
        super()._control(k)
        if (k * self._step_ns) % _REPORT == 0 and k:
            self._report(k * self._step_ns * 1e-9)

    def _report(self, now: float) -> None:
        codes = self._second.codes()
        self._second = _Second(self._second.status)
        for code in codes:
            self.witness.alarms.setdefault(code, now)

    def _estimate(
        self, now: int, pose: FloatArray | None, elapsed: float
    ) -> tuple[ObserverEstimate, float, int] | None:
        while self._changes and self._changes[0][0] <= now:
            self._disturber.apply(self._changes.pop(0)[1])
        answer: tuple[ObserverEstimate, int] | None = None
        observed = False
        if pose is not None:
            north, east, heading = pose.tolist()
            for sent in self._disturber.step(PoseSample(now, (north, east, heading))):
                heard, found = self._hear(sent)
                observed = observed or heard
                answer = found or answer
        if not observed:
            made = self._ahead.run_ahead(ObserverInputs(None, self._tau_achieved))
            if made is not None:
                self._second.missing += 1
                answer = made
        if answer is None:
            return None
        estimate, stamp = answer
        self._second.status = estimate.status
        self._second.reinitialised |= estimate.status is ObserverStatus.REINITIALISED
        before, self._answer_stamp = self._answer_stamp, stamp
        dt = elapsed if before is None or stamp <= before else (stamp - before) * 1e-9
        return estimate, dt, stamp

    def _hear(self, sent: PoseSample) -> tuple[bool, tuple[ObserverEstimate, int] | None]:
        """Return whether a message was taken, and its answer."""
        stamp = from_nanoseconds(sent.stamp)
        try:
            self._stamps.step(stamp, 0.0)
        except SourceRestartError:
            self._begin()
            self._second.began_anew = True
            self._stamps.step(stamp, 0.0)
        except InputError:
            self._refuse()
            return False, None
        self._second.poses += 1
        position: FloatArray | None = None
        if np.isfinite(sent.position).all():
            north, east, heading = sent.position
            sign = -1.0 if sent.other_cover else 1.0
            x, y, z, w = heading_to_quaternion(heading)
            position = np.array([north, east, quaternion_to_heading(sign * x, sign * y, sign * z, sign * w)])
            self._frozen.note(position)
            self._second.frozen = self._frozen.is_frozen(self._observer.settings)
        else:
            self._refuse()
            self._second.missing += 1
        newest = self._ahead.stamp
        estimate = self._ahead.measure(ObserverInputs(position, self._tau_achieved), sent.stamp)
        if estimate.status is ObserverStatus.OUTLIER_REFUSED:
            self._second.missing += 1
        if newest is not None and sent.stamp <= newest:
            self._second.missing += 1
            return True, None
        return True, (estimate, sent.stamp)

    def _refuse(self) -> None:
        self.witness.refused += 1
        self._second.refused += 1
