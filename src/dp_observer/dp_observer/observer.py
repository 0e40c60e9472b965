"""The observer: predicts with the vessel's model, corrects with position fixes, and knows when it is lost."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np

from dp_observer.estimate import ObserverEstimate, ObserverInputs, ObserverStatus, VerticalEstimate
from dp_observer.input_checks import checked_place, checked_position, checked_step, checked_tau, checked_vertical_tau
from dp_observer.measurement_gate import MeasurementGate, Verdict
from dp_observer.model import (
    BIAS,
    HEADING,
    ORDER,
    POSITION,
    VELOCITY,
    WAVE,
    YAW_RATE,
    ObserverModel,
)
from dp_observer.settings import ObserverSettings
from dp_observer.timing import LATE, is_too_old, longest_prediction
from dp_observer.vertical import VerticalObserver
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.vessel import Vessel

# Of two groups of axes, the one that comes first here has more to tell.
_GRAVITY = (
    ObserverStatus.UNINITIALISED,
    ObserverStatus.INVALID,
    ObserverStatus.REINITIALISED,
    ObserverStatus.OUTLIER_REFUSED,
    ObserverStatus.INITIALISED,
    ObserverStatus.DEAD_RECKONING,
    ObserverStatus.NOMINAL,
)


class Observer:
    """Passive nonlinear observer, [Ruth] B.3.1 after Fossen (2002).

    The heading in R(psi) is held over a sample, at the middle of the sample, as measured (as predicted, without a fix).
    The equations are then linear and are solved exactly, with the fix going straight from its last value to the present
    one and ``tau`` constant; so the observer is stable at any rate at which its continuous form is.

    Parameters
    ----------
    vessel
        Gains are ``vessel.observer``, the sample is ``vessel.measurement.sample_time``.
    settings
        Operator's limits.

    Raises
    ------
    InputError
        If the vessel's gains do not give a stable observer.
    """

    def __init__(self, vessel: Vessel, settings: ObserverSettings) -> None:
        self._settings = settings
        self._sample_time = vessel.measurement.sample_time
        self._model = ObserverModel(vessel.observer)
        self._gate = MeasurementGate(vessel.hull.length)
        self._state = np.zeros(ORDER)
        self._initialised = False
        self._last_fix: FloatArray | None = None  # of the last step, if it was used
        self._age = 0.0  # s since the last fix used
        self._vertical: VerticalObserver | None = None
        if vessel.vertical is not None:
            self._vertical = VerticalObserver(vessel.vertical.observer, vessel.hull.length, self._sample_time)

    @property
    def settings(self) -> ObserverSettings:
        """Settings in force."""
        return self._settings

    def apply(self, settings: ObserverSettings) -> None:
        """Replace the settings, from the next step on."""
        self._settings = settings

    def fork(self) -> Observer:
        """Return an observer in the same state that goes its own way, e.g. to look ahead."""
        twin = copy.copy(self)
        twin._gate = copy.copy(self._gate)
        if self._vertical is not None:
            twin._vertical = self._vertical.fork()
        return twin

    def step(self, inputs: ObserverInputs, dt: float) -> ObserverEstimate:
        """Return the estimate ``dt`` (s) after the last step.

        Raises
        ------
        InputError
            If ``dt`` is not positive or an input has the wrong shape, is not finite or is absurdly large; the observer
            is then as before.
        """
        dt = checked_step(dt)
        tau = checked_tau(inputs.tau)
        position = None if inputs.position is None else checked_position(inputs.position)
        if self._vertical is None:
            return self._step(position, tau, dt)
        place = None if inputs.vertical is None else checked_place(inputs.vertical)
        force = None if inputs.vertical_tau is None else checked_vertical_tau(inputs.vertical_tau)
        plane = self._step(position, tau, dt)
        return _joined(plane, self._vertical.step(place, force, dt, self._settings))

    def _step(self, fix: FloatArray | None, tau: FloatArray, dt: float) -> ObserverEstimate:
        """Advance the horizontal plane."""
        return self._dead_reckon(tau, dt) if fix is None else self._measure(fix, tau, dt)

    def _dead_reckon(self, tau: FloatArray, dt: float) -> ObserverEstimate:
        self._age += dt
        self._last_fix = None
        if not self._initialised:
            return self._estimate(ObserverStatus.UNINITIALISED)
        self._state = self._predicted(self._state, tau, min(dt, self._longest_prediction()))
        return self._estimate(ObserverStatus.DEAD_RECKONING)

    def _measure(self, fix: FloatArray, tau: FloatArray, dt: float) -> ObserverEstimate:
        if not self._initialised:
            self._initialised = True
            return self._restart(fix, np.zeros(3), ObserverStatus.INITIALISED)
        self._age += dt
        start, last_fix = self._state, self._last_fix
        if dt > LATE * self._sample_time:
            gap = dt - self._sample_time
            start = self._predicted(start, tau, min(gap, self._longest_prediction()))
            last_fix, dt = None, self._sample_time
        end = self._predicted(start, tau, dt)
        innovation = fix - end[POSITION] - end[WAVE]
        innovation[2] = wrap_angle(innovation[2])
        # The prediction was too old a sample ago: any fix may be as far away as it likes.
        lost = self._too_long(self._age - dt)
        verdict = self._gate.judge(fix, innovation, lost, self._settings)
        if verdict is Verdict.USE:
            self._state = self._corrected(start, end, fix, last_fix, innovation, tau, dt)
            self._last_fix = fix.copy()
            self._age = 0.0
            return self._estimate(ObserverStatus.NOMINAL, innovation)
        self._state = end
        if verdict is Verdict.RESTART:
            return self._restart(fix, innovation, ObserverStatus.REINITIALISED)
        self._last_fix = None
        return self._estimate(ObserverStatus.OUTLIER_REFUSED, innovation)

    def _restart(self, fix: FloatArray, innovation: FloatArray, status: ObserverStatus) -> ObserverEstimate:
        """Set the position to ``fix``; velocity and bias stay, as a jump says nothing about them."""
        state = self._state.copy()
        state[: POSITION.start] = 0.0
        state[POSITION] = fix
        state[HEADING] = wrap_angle(float(fix[2]))
        self._state = state
        self._last_fix = fix.copy()
        self._age = 0.0
        return self._estimate(status, innovation)

    def _predicted(self, state: FloatArray, tau: FloatArray, duration: float) -> FloatArray:
        """Return the state after ``duration`` (s) without measurements."""
        count = max(1, round(duration / self._sample_time))
        force = np.dot(self._model.force_input, tau)
        length = duration / count
        for _ in range(count):
            self._model.set_heading(float(state[HEADING] + 0.5 * length * state[YAW_RATE]))
            state = self._model.prediction_flow.advance(self._model.prediction, state, force, None, length)
        return state

    def _corrected(
        self,
        start: FloatArray,
        end: FloatArray,
        fix: FloatArray,
        last_fix: FloatArray | None,
        innovation: FloatArray,
        tau: FloatArray,
        dt: float,
    ) -> FloatArray:
        """Return the state at ``fix``, from ``start``; ``end`` is the prediction that gave ``innovation``."""
        predicted = start[POSITION] + start[WAVE]
        if last_fix is None:
            # Nothing was measured at the start: what is missing at the end was missing there too. It built up over the
            # whole time without fixes, and velocity and bias are to blame for it in proportion only: with the full
            # K_3 and K_4 the observer would swing ever higher on fixes that come rarely.
            first = predicted + innovation
            self._model.set_share(min(1.0, dt / self._age))
        else:
            self._model.set_share(1.0)
            first = last_fix.copy()
            first[2] = predicted[2] + wrap_angle(float(first[2] - predicted[2]))
        last = fix.copy()
        last[2] = first[2] + wrap_angle(float(last[2] - first[2]))
        self._model.set_heading(0.5 * float(first[2] + last[2]))
        injection = self._model.injection
        force = np.dot(self._model.force_input, tau) + np.dot(injection, first)
        ramp = np.dot(injection, (last - first) / dt)
        return self._model.correction_flow.advance(self._model.correction, start, force, ramp, dt)

    def _too_long(self, age: float) -> bool:
        return is_too_old(age, self._settings)

    def _longest_prediction(self) -> float:
        return longest_prediction(self._settings, self._sample_time)

    def _estimate(self, status: ObserverStatus, innovation: FloatArray | None = None) -> ObserverEstimate:
        state = self._state
        state[HEADING] = wrap_angle(float(state[HEADING]))
        valid = self._initialised and not self._too_long(self._age)
        if self._initialised and not valid:
            status = ObserverStatus.INVALID
        return ObserverEstimate(
            position=state[POSITION].copy(),
            velocity=state[VELOCITY].copy(),
            wave_frequency_position=state[WAVE].copy(),
            bias=state[BIAS] * self._model.bias_scale,
            innovation=np.zeros(3) if innovation is None else innovation,
            valid=valid,
            status=status,
            time_since_measurement=self._age,
        )


def _joined(plane: ObserverEstimate, below: VerticalEstimate) -> ObserverEstimate:
    """Return one estimate of all axes: valid if both are, and as old as the older."""
    return replace(
        plane,
        valid=plane.valid and below.valid,
        status=min(plane.status, below.status, key=_GRAVITY.index),
        time_since_measurement=max(plane.time_since_measurement, below.time_since_measurement),
        vertical=below,
    )
