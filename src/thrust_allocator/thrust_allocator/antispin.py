"""Anti-spin: thrust of a ventilating propeller costs more, [Ruth] 5.2, so that others give it where there are others.

How much more. Give P_n(T) ~ |T|^p for the power of a propeller that gives T without loss: p = 3/2 by (3.11), 2 where
the cost of thrust is its square. A propeller with losses gives T where it would give T / beta_T without them, and takes
beta_Q of that power:

    P_vent(T) = beta_Q P_n(T / beta_T) = beta_Q beta_T^(-p) P_n(T) = beta_Q^(1 - p/m) P_n(T),    beta_Q = beta_T^m

p = 3/2 gives (5.11)-(5.12), sp_t = beta_Q / beta_T^(3/2) and S = 1 - 3/(2m). The print has beta_T = beta_Q^m beside it,
which would give 1 - 3m/2 = 0.025 > 0: a cost that falls with the losses. For p = 2 [Ruth] says after (5.13) that
another factor is needed; it is the one of 1 - 2/m. (5.18) writes beta_Q2^(S/2) onto W_u, which is squared in the cost:
here the factor c = beta_Q2^S stands on the diagonal of W_u^2. S is below 0 for m < p, so that the cost is raised, where
the text after (5.18) says reduced.

c is 1 or more. Weights of T_j^2 raised by d_j >= 0 over the same set of thrusts lower sum_j d_j T_j^2 or leave it: with
one ventilating thruster, its thrust never grows. (T, T' the optima before and after: J(T') >= J(T) and
J(T) + d T_j^2 >= J(T') + d T'_j^2.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from marine_model.errors import InputError
from marine_model.guards import FloatArray, finite_number, finite_vector
from marine_model.loss_memory import LossMemory
from thrust_allocator.settings import AntiSpinSettings

# p in P_n(T) ~ |T|^p.
POWER_TRUE, QUADRATIC = 1.5, 2.0


def cost_exponent(power_of_thrust: float, exponent_m: float) -> float:
    """Return S in c = beta_Q^S: 1 - p/m, [Ruth] (5.12) for p = 3/2.

    Parameters
    ----------
    power_of_thrust
        p: cost is taken as proportional to |T|^p.
    exponent_m
        m in beta_Q = beta_T^m.
    """
    return 1.0 - power_of_thrust / exponent_m


class AntiSpin:
    """Cost factors of a row of thrusters from what is told of their ventilation.

    There is one rule for every change: the cost rises at once, and falls no faster than ``relax_rate`` lets beta_Q2
    rise. That holds when the message says so, when a thruster is excluded, when messages stop and when anti-spin is
    switched off.

    Parameters
    ----------
    count
        Number of thrusters, n.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._without_loss: FloatArray = np.ones(count)
        self._without_loss.flags.writeable = False
        self._always = np.ones(count, dtype=bool)
        self._settings = AntiSpinSettings()
        self._memory = LossMemory(count, self._settings.relax_rate)
        self.reset()

    def reset(self) -> None:
        """Forget all losses, and what was told of them."""
        self._memory.reset()
        self._told: FloatArray | None = None
        self._age, self._fresh = 0.0, False
        self._known = False
        self._set(self._without_loss)

    def apply(self, settings: AntiSpinSettings) -> None:
        """Take the settings; they hold from the next step on."""
        self._settings = settings
        self._memory.rate = settings.relax_rate
        self._excluded = np.array(settings.excluded or (False,) * self._count, dtype=bool)

    def measure(self, torque_loss: ArrayLike, age: float) -> None:
        """Take beta_Q2 of every thruster, shape (n,), ``age`` (s) old at the next step.

        Raises
        ------
        InputError
            If the shape is wrong, a number is not within 0 and 1, or ``age`` is not 0 or more; nothing is changed.
        """
        told = finite_vector("torque_loss", torque_loss, self._count)
        if not ((told >= 0.0) & (told <= 1.0)).all():
            raise InputError(f"torque_loss: expected factors from 0 to 1, found {told.tolist()}")
        if finite_number("age", age) < 0.0:
            raise InputError(f"age: expected 0 or more, found {age}")
        self._told, self._age, self._fresh = told.copy(), age, True

    def step(self, dt: float) -> None:
        """Go on by ``dt`` (s) to the factors of this step."""
        if self._told is not None:
            self._age += 0.0 if self._fresh else dt
            self._fresh = False
        settings = self._settings
        told = self._told
        self._known = settings.enabled and told is not None and self._age <= settings.timeout
        if self._known and told is not None:
            target = np.where(self._excluded, 1.0, np.maximum(told, settings.loss_min))
        elif self.acts:
            target = self._without_loss
        else:
            return
        # The flags have had their say in beta_Q2 already, (5.16): it may still be low with the flag down.
        self._set(self._memory.step(self._always, target, dt))

    @property
    def torque_loss(self) -> FloatArray:
        """beta_Q2 in use, shape (n,), 1 without loss."""
        return self._loss

    @property
    def acts(self) -> bool:
        """Whether any factor is above 1."""
        return self._acts

    @property
    def on(self) -> bool:
        """Whether ventilation has a say in the cost: switched on, or what it said is not forgotten yet."""
        return self._settings.enabled or self._acts

    @property
    def known(self) -> bool:
        """Whether it is on and was told of ventilation within ``antispin.timeout``."""
        return self._known

    def factor(self, power_of_thrust: float) -> FloatArray:
        """Return c of every thruster for a cost that goes with |T|^p, shape (n,), 1 or more."""
        found: FloatArray = self._loss ** cost_exponent(power_of_thrust, self._settings.exponent_m)
        return found

    def _set(self, loss: FloatArray) -> None:
        self._loss = loss
        self._acts = bool((loss < 1.0).any())
