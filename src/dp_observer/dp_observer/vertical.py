"""Observer of depth, roll and pitch of a submerged vehicle: every axis for itself, without a wave filter.

With the mass m (with added mass), damping d and stiffness k of an axis,

    x_dot = v + l_1 y~
    v_dot = (tau - d v - k x) / m + b + l_2 y~
    b_dot = l_3 y~                               y~ = y - x

b, force over mass, takes up what the model does not know: weight less buoyancy, trim, a tether. The error has all three
poles at -w, the bandwidth, with

    l_1 = 3 w - d / m,    l_2 = 3 w^2 - k / m - l_1 d / m,    l_3 = w^3

whatever their signs: an axis that swings by itself faster than w is predicted more than it is corrected.

Waves are left out: at depth z they move the water by exp(-omega^2 z / g) of what they do at the surface.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from dp_observer.exponential import LinearFlow, growth_rate
from dp_observer.measurement_gate import MeasurementGate, Verdict
from dp_observer.settings import ObserverSettings
from marine_model.frames import wrap_angle
from marine_model.guards import FloatArray
from marine_model.vertical import VerticalObserverGains

if TYPE_CHECKING:
    from dp_observer.estimate import ObserverInputs

# State vector, shape (9,).
PLACE = slice(0, 3)  # depth (m), roll, pitch (rad)
RATE = slice(3, 6)  # m/s, rad/s
BIAS = slice(6, 9)  # force over mass, m/s^2, rad/s^2
ORDER = 9

# A step longer than this many samples has missed one.
LATE = 1.5


@dataclass(frozen=True, slots=True)
class VerticalEstimate:
    """Estimate of depth, roll and pitch; every array has shape (3,).

    Attributes
    ----------
    position
        Depth (m), roll, pitch (rad).
    velocity
        Their rates, m/s, rad/s.
    bias
        Force along heave, moments about roll and pitch that the model does not know (N, N m, N m).
    innovation
        Fix minus the position predicted for it (m, rad, rad); zero without a fix.
    refused
        Whether there was a fix, and it was too far from the prediction to be used.
    """

    position: FloatArray
    velocity: FloatArray
    bias: FloatArray
    innovation: FloatArray
    refused: bool = False


class VerticalObserver:
    """Three axes, each observed for itself.

    The equations are linear and solved exactly, with the fix going straight from its last value to the present one and
    the force constant, as in the horizontal plane.

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
        mass, damping, stiffness = (np.array(v) for v in (gains.mass, gains.damping, gains.stiffness))
        pole = np.array(gains.bandwidth)
        self._mass: FloatArray = mass
        self._gate = MeasurementGate(length)
        self._sample_time = sample_time
        rate_gain = 3.0 * pole - damping / mass
        force_gain = 3.0 * pole**2 - stiffness / mass - rate_gain * damping / mass
        self._injection = np.vstack([np.diag(rate_gain), np.diag(force_gain), np.diag(pole**3)])
        self._prediction = np.zeros((ORDER, ORDER))
        self._prediction[PLACE, RATE] = self._prediction[RATE, BIAS] = np.eye(3)
        self._prediction[RATE, PLACE] = np.diag(-stiffness / mass)
        self._prediction[RATE, RATE] = np.diag(-damping / mass)
        self._correction = self._prediction.copy()
        self._correction[:, PLACE] -= self._injection
        growth = growth_rate(np.stack([self._prediction, self._correction]))
        self._flow = LinearFlow(ORDER, growth)
        self._state = np.zeros(ORDER)
        self._last_fix: FloatArray | None = None

    def fork(self) -> VerticalObserver:
        """Return an observer in the same state that goes its own way."""
        twin = copy.copy(self)
        twin._gate = copy.copy(self._gate)
        return twin

    def restart(self, inputs: ObserverInputs) -> VerticalEstimate:
        """Take over a fix as it is; velocity and bias stay."""
        if inputs.vertical is None:
            return self._estimate()
        state = self._state.copy()
        state[PLACE] = inputs.vertical
        self._state, self._last_fix = state, inputs.vertical.copy()
        return self._estimate()

    def predict(self, inputs: ObserverInputs, dt: float) -> VerticalEstimate:
        """Return the estimate ``dt`` (s) on, without a fix."""
        self._state = self._flow.advance(self._prediction, self._state, self._force(inputs), None, dt)
        self._last_fix = None
        return self._estimate()

    def correct(self, inputs: ObserverInputs, dt: float, settings: ObserverSettings) -> VerticalEstimate:
        """Return the estimate ``dt`` (s) on, with the fix of ``inputs``, if that is near enough to the prediction."""
        fix = inputs.vertical
        if fix is None:
            return self.predict(inputs, dt)
        if dt > LATE * self._sample_time:
            # Of the time before the last sample nothing was measured.
            self.predict(inputs, dt - self._sample_time)
            dt = self._sample_time
        force = self._force(inputs)
        end = self._flow.advance(self._prediction, self._state, force, None, dt)
        innovation = fix - end[PLACE]
        innovation[1:] = [wrap_angle(angle) for angle in innovation[1:].tolist()]
        verdict = self._judge(fix, innovation, settings)
        if verdict is not Verdict.USE:
            self._state, self._last_fix = end, None
            return self.restart(inputs) if verdict is Verdict.RESTART else self._estimate(innovation, refused=True)
        # Nothing was measured at the start: what is missing at the end was missing there too.
        first = self._state[PLACE] + innovation if self._last_fix is None else self._last_fix
        last = first + np.array([fix[0] - first[0], *(wrap_angle(angle) for angle in (fix - first)[1:].tolist())])
        held = force + self._injection @ first
        ramp = self._injection @ ((last - first) / dt)
        self._state = self._flow.advance(self._correction, self._state, held, ramp, dt)
        self._last_fix = last
        return self._estimate(innovation)

    def _judge(self, fix: FloatArray, innovation: FloatArray, settings: ObserverSettings) -> Verdict:
        """Judge depth as a position and the angle that is farther off as a heading."""
        angle = 1 if abs(innovation[1]) > abs(innovation[2]) else 2
        place = np.array([fix[0], 0.0, fix[angle]])
        return self._gate.judge(place, np.array([innovation[0], 0.0, innovation[angle]]), False, settings)

    def _force(self, inputs: ObserverInputs) -> FloatArray:
        force = np.zeros(ORDER)
        if inputs.vertical_tau is not None:
            force[RATE] = inputs.vertical_tau / self._mass
        return force

    def _estimate(self, innovation: FloatArray | None = None, refused: bool = False) -> VerticalEstimate:
        state = self._state
        for i in (1, 2):
            state[i] = wrap_angle(float(state[i]))
        return VerticalEstimate(
            position=state[PLACE].copy(),
            velocity=state[RATE].copy(),
            bias=state[BIAS] * self._mass,
            innovation=np.zeros(3) if innovation is None else innovation,
            refused=refused,
        )
