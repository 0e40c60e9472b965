"""Propeller torque from motor torque and shaft speed.

The shaft obeys 2 pi J dn/dt = Q_m - Q_f(n) - Q_p. Motor torque is known, shaft speed is measured with white noise, and
Q_p = beta_Q Q_nom(n) with Q_nom = c n|n|. Observed are n and the loss factor beta_Q, not n and Q_p: a changing shaft
speed then changes the torque by itself and leaves no error behind, however quick, and what the observer has to find
out is the loss alone.

One step of dt, with Q_m held over it as motors hold it:

    n-    = n^ + dt (Q_m - Q_f - beta^ Q_nom(n^)) / (2 pi J + dt beta^ c |n^|)      (implicit midpoint, linearised)
    n^    = n- + alpha (n - n-)
    beta^ = beta^ - gamma 2 pi J / (dt Q_nom(n-)) (n - n-)

alpha and gamma are the steady Kalman gains of a shaft whose loss is a random walk. With the tracking index Lambda, the
step of the walk in Hz over the noise of the measurement, and w = (2 - alpha) / alpha, the Riccati equation of two
states has the solution

    gamma = alpha^2 / (2 - alpha) = 2 / (w (1 + w)),       Lambda = gamma / sqrt(1 - alpha),

so that one number is free. It follows from how much noise beta^ may have, not from a guess about the walk: noise sigma
of the shaft speed gives beta^ a standard deviation s for

    w^3 - w / 2 = 1 / x^2,        x = s |Q_nom| dt / (2 pi J sigma),

from the variance of the slope that such a filter gives,

    (sigma / dt)^2 2 gamma^2 / (alpha (4 - 2 alpha - gamma)) = (sigma / dt)^2 2 / (w (2 w^2 - 1)).

The cubic has one real root. So the observer is at every shaft speed the fastest that keeps the noise in beta^ at s;
where even the last difference of two measurements is quiet enough (x^2 >= 2) alpha = gamma = 1.
"""

from __future__ import annotations

import math

from marine_model.compiled import compiled
from marine_model.guards import FloatArray
from thruster_drivers.ventilation.tables import BETA, INERTIA, NOISE, SPEED, STATIC, VISCOUS

# beta_Q is kept between these: a torque that drives the shaft counts as none, twice the nominal one is no measurement.
BETA_MIN = 0.0
BETA_MAX = 2.0


@compiled
def filter_index(signal: float) -> float:
    """Return w = (2 - alpha) / alpha >= 1 for ``signal`` x = s |Q_nom| dt / (2 pi J sigma) >= 0; infinite at 0.

    Cardano's root of w^3 - w/2 = 1/x^2; both cube roots have the product 1/6.
    """
    square = signal * signal
    if square >= 2.0:
        return 1.0
    half = 0.5 / square  # infinite at 0, as numpy divides
    root: float = (half + math.sqrt(half * half - 1.0 / 216.0)) ** (1.0 / 3.0)
    return root + 1.0 / (6.0 * root)


@compiled
def friction(parameters: FloatArray, speed: float, torque: float) -> float:
    """Return Q_f (N m) at ``speed`` (Hz); at rest what holds it against ``torque``, up to Coulomb friction."""
    static = parameters[STATIC]
    if speed > 0.0:
        return float(static + parameters[VISCOUS] * speed)
    if speed < 0.0:
        return float(-static + parameters[VISCOUS] * speed)
    return float(max(-static, min(static, torque)))


@compiled
def observe(
    parameters: FloatArray, state: FloatArray, load: float, speed: float, torque: float, dt: float, patience: float
) -> None:
    """Advance observed shaft speed and loss factor of one thruster by one feedback.

    Where the observer would need longer than ``patience`` (s), near n = 0, there is nothing to observe: beta^ goes back
    to 1 with that time constant, and n^ is the measurement. A shaft that turns over begins anew, without loss: what the
    advance speed takes from the torque one way it adds the other way, and an innovation left over from before would
    count with the wrong sign.

    Parameters
    ----------
    parameters, state
        Rows of the tables; ``state`` is changed.
    load
        c = K_Q0(P/D) rho D^5, N m/Hz^2.
    speed, torque
        Shaft speed now (Hz) and motor torque of the step that ended now (N m).
    dt
        s, length of that step.
    patience
        s.
    """
    inertia = parameters[INERTIA]
    observed, beta = state[SPEED], state[BETA]
    net = torque - friction(parameters, observed, torque) - beta * load * observed * abs(observed)
    predicted = observed + dt * net / (inertia + dt * beta * load * abs(observed))
    if predicted * observed < 0.0:
        state[SPEED] = speed
        state[BETA] = 1.0
        return
    nominal = load * predicted * abs(predicted)
    w = filter_index(abs(nominal) * dt / (inertia * parameters[NOISE]))
    if w * (1.0 + w) * dt * dt > 2.0 * patience * patience:  # sqrt(gamma) / dt, its natural frequency
        state[SPEED] = speed
        state[BETA] = 1.0 + (beta - 1.0) * math.exp(-dt / patience)
        return
    innovation = speed - predicted
    state[SPEED] = predicted + 2.0 / (1.0 + w) * innovation
    correction = 2.0 / (w * (1.0 + w)) * inertia / (dt * nominal) * innovation
    state[BETA] = max(BETA_MIN, min(BETA_MAX, beta - correction))
