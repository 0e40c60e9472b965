"""Dynamics of ventilation on top of the static map: rise rates and time shift, [Ruth] 2.3.2.

Rise rates (2.52)-(2.53): beta_Tw and beta_Qw fall at once and rise at a limited rate; beta_area follows at once.

Time shift: while the shaft speeds up, the water drawn in is still slower than in the steady state, so the thrust is
above its quasi-static value, and above while that value rises means ahead of it in time. 2.3.2 calls this a forward
shift from quasi-static to dynamic values: dynamic(t) = quasi-static(t + shift); the losses *lead*. A simulation has
no future shaft speed, so ``extrapolated`` goes on along the present rate of change for the time of the shift; the
error is shift^2 / 2 times the second derivative of what is extrapolated: at 0.064 s, 0.2 % of the amplitude for a
period of 7 s ([Ruth] (2.57)), and 13 % for 0.8 s. Where the later value is known, as that of a recorded or simulated
sea, use it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from marine_model.compiled import compiled, inlined
from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_vector, positive_number
from marine_model.ventilation.data import VentilationData


@inlined
def limited_rise(wanted: float, held: float, rate: float, dt: float) -> float:
    """Return the loss factor after ``dt`` (s): ``wanted``, but at most ``rate`` dt above ``held``."""
    return min(wanted, held + rate * dt)


@compiled
def extrapolate(now: float, before: float, dt: float, shift: float) -> float:
    """Return what will be after ``shift`` (s) if the change since ``dt`` (s) ago goes on."""
    return now + (now - before) * (shift / dt)


def extrapolated(now: ArrayLike, before: ArrayLike, dt: float, shift: float) -> FloatArray:
    """Return shaft speeds or submergence ratios ``shift`` s ahead, along the line through the last two samples.

    Parameters
    ----------
    now, before
        Samples, broadcast; ``before`` is ``dt`` older.
    dt
        s, above 0.
    shift
        s, at least 0.

    Raises
    ------
    InputError
        If ``dt`` is not above 0 or ``shift`` is negative.
    """
    step = positive_number("dt", dt)
    if not shift >= 0.0:
        raise InputError(f"shift: expected at least 0, found {shift}")
    new, old = np.asarray(now, dtype=np.float64), np.asarray(before, dtype=np.float64)
    return np.asarray(new + (new - old) * (shift / step))


def shifted(time: ArrayLike, quasi_static: ArrayLike, shift: float) -> FloatArray:
    """Return dynamic(t) = quasi-static(t + shift) of a whole record, linear between samples.

    For off-line comparison. The last ``shift`` s are beyond the record and are NaN.

    Parameters
    ----------
    time
        s, rising, shape (m,).
    quasi_static
        Values at ``time``, shape (m,).
    shift
        s, at least 0.

    Raises
    ------
    InputError
        If the shapes differ, a value is not finite, ``time`` does not rise or ``shift`` is negative.
    """
    instants = np.asarray(time, dtype=np.float64)
    if instants.ndim != 1 or instants.size < 2 or not (np.diff(instants) > 0.0).all():
        raise InputError("time: expected two or more rising instants")
    values = finite_vector("quasi_static", quasi_static, instants.size)
    if not shift >= 0.0:
        raise InputError(f"shift: expected at least 0, found {shift}")
    return np.interp(instants + shift, instants, values, right=np.nan)


class LossRates:
    """beta_Tw and beta_Qw of a row of propellers after the rise rates of [Ruth] (2.52)-(2.53).

    Parameters
    ----------
    data
        Rise rates of the propeller.
    count
        Number of propellers, n. They begin without memory: the first step takes its values as they are.
    """

    def __init__(self, data: VentilationData, count: int) -> None:
        self._rates = np.array([[data.thrust_rise_rate], [data.torque_rise_rate]])
        self._held = np.full((2, count), np.inf)
        self._count = count

    def step(self, thrust_wetted: ArrayLike, torque_wetted: ArrayLike, dt: float) -> tuple[FloatArray, FloatArray]:
        """Return beta_Tw and beta_Qw now, shape (n,) each.

        Parameters
        ----------
        thrust_wetted, torque_wetted
            Quasi-static beta_Tw and beta_Qw, shape (n,).
        dt
            s since the last step, above 0.

        Raises
        ------
        InputError
            If a shape is wrong, a value is not finite or ``dt`` is not above 0; nothing has changed then.
        """
        elapsed = positive_number("dt", dt)
        wanted = np.array(
            [
                finite_vector("thrust_wetted", thrust_wetted, self._count),
                finite_vector("torque_wetted", torque_wetted, self._count),
            ]
        )
        self._held = np.minimum(wanted, self._held + self._rates * elapsed)
        return self._held[0].copy(), self._held[1].copy()

    def reset(self) -> None:
        """Forget what was."""
        self._held = np.full((2, self._count), np.inf)
