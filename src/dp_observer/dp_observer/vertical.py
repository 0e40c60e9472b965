"""Observer of depth, roll and pitch of a submerged vehicle: every axis for itself, without a wave filter.

A Kalman filter of each axis, with the noises of :mod:`dp_observer.axis_models`. While fixes come steadily it has one
constant gain, and an error with the poles that the vessel file asks for. After a gap it knows by how much less its
prediction is worth: a constant gain would swing ever higher on fixes that come rarely.

The bias takes up what the model does not know: weight less buoyancy, trim, a tether, and in heave the depth that a
pitched vehicle gains by its speed ahead.

Waves are left out: at depth z they move the water by exp(-omega^2 z / g) of what they do at the surface.
"""

from __future__ import annotations

import copy

import numpy as np

from dp_observer.axis_models import BIAS, POSITION, RATE, AxisModels, corrected, steady_covariance
from dp_observer.estimate import ObserverStatus, VerticalEstimate
from dp_observer.measurement_gate import MeasurementGate, Verdict
from dp_observer.settings import ObserverSettings
from dp_observer.timing import LATE, is_too_old, longest_prediction
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.vertical import VerticalObserverGains

_ANGLES = (1, 2)  # roll and pitch among the axes


class VerticalObserver:
    """Three axes, each observed for itself.

    Gaps, outliers and losses are treated as in the horizontal plane and by the same settings, but depth, roll and pitch
    are judged by themselves.

    Parameters
    ----------
    gains
        Model and bandwidth of every axis.
    length
        Of the hull (m), in which ``innovation_limit`` counts.
    sample_time
        Between fixes, s.
    """

    def __init__(self, gains: VerticalObserverGains, length: float, sample_time: float) -> None:
        self._mass: FloatArray = np.array(gains.mass)
        self._models = AxisModels(gains)
        self._gate = MeasurementGate(length)
        self._sample_time = sample_time
        # White noise of density 1 seen through samples.
        self._variance = 1.0 / sample_time
        self._state = np.zeros((3, 3))  # axis; position, rate, force over mass
        self._covariance = steady_covariance(self._models.over(sample_time), self._variance)
        self._initialised = False
        self._age = 0.0  # s since the last fix used

    def fork(self) -> VerticalObserver:
        """Return an observer in the same state that goes its own way."""
        twin = copy.copy(self)
        twin._gate = copy.copy(self._gate)
        return twin

    def step(
        self, fix: FloatArray | None, tau: FloatArray | None, dt: float, settings: ObserverSettings
    ) -> VerticalEstimate:
        """Return the estimate ``dt`` (s) after the last step.

        Parameters
        ----------
        fix
            Measured depth (m), roll, pitch (rad), shape (3,); None if there is no fix.
        tau
            Force along heave (N), moments about roll and pitch (N m), shape (3,), since the last step; None for none.
        dt
            Above 0, s.
        settings
            Those in force.
        """
        force = np.zeros(3) if tau is None else tau / self._mass
        if fix is None:
            return self._dead_reckon(force, dt, settings)
        return self._measure(fix, force, dt, settings)

    def _dead_reckon(self, force: FloatArray, dt: float, settings: ObserverSettings) -> VerticalEstimate:
        self._age += dt
        if not self._initialised:
            return self._estimate(ObserverStatus.UNINITIALISED, settings)
        self._predict(force, min(dt, longest_prediction(settings, self._sample_time)))
        return self._estimate(ObserverStatus.DEAD_RECKONING, settings)

    def _measure(self, fix: FloatArray, force: FloatArray, dt: float, settings: ObserverSettings) -> VerticalEstimate:
        if not self._initialised:
            self._initialised = True
            return self._restart(fix, ObserverStatus.INITIALISED, settings)
        self._age += dt
        gap = dt - self._sample_time if dt > LATE * self._sample_time else 0.0
        if gap > 0.0:
            self._predict(force, min(gap, longest_prediction(settings, self._sample_time)))
        self._predict(force, dt - gap)
        innovation = fix - self._state[:, POSITION]
        for i in _ANGLES:
            innovation[i] = wrap_angle(float(innovation[i]))
        # The prediction was too old a sample ago: any fix may be as far away as it likes.
        lost = is_too_old(self._age - (dt - gap), settings)
        verdict = self._judge(fix, innovation, lost, settings)
        if verdict is Verdict.REFUSE:
            return self._estimate(ObserverStatus.OUTLIER_REFUSED, settings, innovation)
        gain, self._covariance = corrected(self._covariance, self._variance)
        if verdict is Verdict.RESTART:
            return self._restart(fix, ObserverStatus.REINITIALISED, settings, innovation)
        self._state = self._state + gain * innovation[:, None]
        self._age = 0.0
        return self._estimate(ObserverStatus.NOMINAL, settings, innovation)

    def _judge(self, fix: FloatArray, innovation: FloatArray, lost: bool, settings: ObserverSettings) -> Verdict:
        """Judge depth as a position and the angle that is farther off as a heading."""
        angle = 1 if abs(innovation[1]) > abs(innovation[2]) else 2
        place = np.array([fix[0], 0.0, fix[angle]])
        return self._gate.judge(place, np.array([innovation[0], 0.0, innovation[angle]]), lost, settings)

    def _predict(self, force: FloatArray, duration: float) -> None:
        """Go on for ``duration`` (s) without a fix, under a constant force over mass."""
        count = max(1, round(duration / self._sample_time))
        step = self._models.over(duration / count)
        moved = step.force * force[:, None]
        for _ in range(count):
            self._state = np.einsum("aij,aj->ai", step.transition, self._state) + moved
            self._covariance = step.transition @ self._covariance @ step.transition.transpose(0, 2, 1) + step.noise

    def _restart(
        self,
        fix: FloatArray,
        status: ObserverStatus,
        settings: ObserverSettings,
        innovation: FloatArray | None = None,
    ) -> VerticalEstimate:
        """Take over a fix as it is; velocity and bias stay, as a jump says nothing about them."""
        state = self._state.copy()
        state[:, POSITION] = fix
        self._state, self._age = state, 0.0
        return self._estimate(status, settings, innovation)

    def _estimate(
        self, status: ObserverStatus, settings: ObserverSettings, innovation: FloatArray | None = None
    ) -> VerticalEstimate:
        state = self._state
        for i in _ANGLES:
            state[i, POSITION] = wrap_angle(float(state[i, POSITION]))
        valid = self._initialised and not is_too_old(self._age, settings)
        return VerticalEstimate(
            position=state[:, POSITION].copy(),
            velocity=state[:, RATE].copy(),
            bias=state[:, BIAS] * self._mass,
            innovation=np.zeros(3) if innovation is None else innovation,
            valid=valid,
            status=ObserverStatus.INVALID if self._initialised and not valid else status,
            time_since_measurement=self._age,
        )
