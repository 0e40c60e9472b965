"""Cost of thrust: quadratic, or true to power by re-weighting with the thrust of the step before, [Ruth] 5.1.

[Ruth] (5.1) minimises sum_j w_j T_j^2 with w_j = W_j^2 / sqrt|T_prev,j|, which is |T_j|^(3/2) where T = T_prev.
Printed so, it divides by zero at T_prev = 0 ((5.9) lacks the absolute value as well), and a thruster that rests would
rest for good. Here, with a floor e_j > 0,

    w_j = c_j W_j^2 / (T_prev,j^2 + e_j^2)^(1/4)        (R)

What it converges to. With psi(q) = (4/3) (q + e^2)^(3/4) and phi(T) = psi(T^2), psi'(q) = (q + e^2)^(-1/4). psi is
concave, so that for every T

    phi(T) <= phi(T_prev) + w(T_prev) (T^2 - T_prev^2),        with equality at T_prev,

also with T^2 = T_x^2 + T_y^2 for a rotating thruster. A step of the iteration thus minimises an upper bound of

    F(T) = || gamma W_v s ||^2 + sum_j c_j W_j^2 phi_j(T_j)

that touches F at T_prev: F never rises from step to step while the demand stands, whatever the number of thrusters and
the convex set they are held to, rate limits included (T_prev is within the windows of its own step). F is strictly
convex, so the iteration converges to the minimum of F. This is a majorise-minimise scheme; [Ruth] App. D proves the
case of two thrusters.

How far that is from |T|^(3/2). From |T|^(3/2) <= (T^2 + e^2)^(3/4) <= |T|^(3/2) + e^(3/2), the minimum of F costs at
most sum_j (4/3) c_j W_j^2 e_j^(3/2) more than that of the same problem with e = 0 (:func:`excess_bound`). With e =
1e-3 of the span that is 4.2e-5 of the cost of all thrusters at full span. For |T| well above e the marginal cost is
wrong by the share e^2 / (4 T^2) alone; sqrt(|T| + e) in place of (R) would leave e / (2 |T|).

How fast. phi'' lies between half of the curvature 2 w of its bound and all of it, so that near the optimum an error at
least halves with each step, for any number of thrusters. With one axis the ratio r of two thrusts goes r_k+1 = a
sqrt(r_k), and log(r / a^2) halves exactly: r_k = a^2 (r_0 / a^2)^(2^-k). A resting thruster counts as one at e, so
that from rest to 1 % takes about log2(100 ln(1 / REGULARISATION)) = 9.4 steps.

The factor 4/3 is the thesis's: at the fixed point w T^2 is |T|^(3/2), while what has been minimised is 4/3 of it. It
shifts the balance between thrust and slack by a third, which a slack weight of a million hides.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from marine_model.compiled import compiled
from marine_model.errors import InputError
from marine_model.guards import FloatArray, positive_number

# Floor e of a thruster as a share of its span T_max - T_min. It bounds the weights of one thruster to a range of
# REGULARISATION^(-1/2) = 32, and the loss to (4/3) REGULARISATION^(3/2) = 4.2e-5 of full power.
REGULARISATION = 1e-3


def thrust_floor(thrust_min: FloatArray, thrust_max: FloatArray) -> FloatArray:
    """Return the floor e of every thruster, shape (n,), N."""
    return REGULARISATION * (thrust_max - thrust_min)


def propeller_weights(power_per_thrust_3_2: ArrayLike) -> FloatArray:
    """Return the diagonal of W_u^2 from propeller data, shape (n,), dimensionless, of mean 1: [Ruth] (5.9)-(5.10).

    Parameters
    ----------
    power_per_thrust_3_2
        2 pi K_Q / (sqrt(rho) D K_T^(3/2)) of every thruster, shape (n,), W / N^(3/2).

    Raises
    ------
    InputError
        If there is no thruster, or a number is not finite or not above 0.
    """
    coefficient = np.array(power_per_thrust_3_2, dtype=np.float64)
    if coefficient.ndim != 1 or coefficient.size == 0:
        raise InputError(f"power_per_thrust_3_2: expected one number a thruster, found shape {coefficient.shape}")
    if not (np.isfinite(coefficient).all() and (coefficient > 0.0).all()):
        raise InputError(f"power_per_thrust_3_2: expected finite numbers above 0, found {coefficient.tolist()}")
    weight: FloatArray = coefficient / coefficient.mean()
    return weight


@compiled
def reweight(
    weight: FloatArray, factor: FloatArray, thrust_before: FloatArray, floor: FloatArray, out: FloatArray
) -> None:
    """Write the weights of this step, equation (R) of this module; sum_j out_j T_j^2 is the cost of thrust.

    Parameters
    ----------
    weight
        Diagonal of W_u^2, shape (n,).
    factor
        Cost factor c of every thruster, shape (n,), above 0: 1, or more for one that is to be spared.
    thrust_before
        Thrust commanded in the step before, shape (n,), N; finite.
    floor
        e, shape (n,), N, above 0.
    out
        Shape (n,), N^(-1/2).
    """
    for j in range(weight.size):
        squared = thrust_before[j] * thrust_before[j] + floor[j] * floor[j]
        out[j] = weight[j] * factor[j] / math.sqrt(math.sqrt(squared))


@compiled
def regularised_cost(weight: FloatArray, factor: FloatArray, thrust: FloatArray, floor: FloatArray) -> float:
    """Return sum_j (4/3) c_j W_j^2 (T_j^2 + e_j^2)^(3/4): the part of thrust in F, which never rises from step to step.

    Arguments as in :func:`reweight`.
    """
    total = 0.0
    for j in range(weight.size):
        total += weight[j] * factor[j] * (thrust[j] * thrust[j] + floor[j] * floor[j]) ** 0.75
    return total * 4.0 / 3.0


@compiled
def excess_bound(weight: FloatArray, factor: FloatArray, floor: FloatArray) -> float:
    """Return the most that the minimum of F costs above that without a floor: sum_j (4/3) c_j W_j^2 e_j^(3/2)."""
    total = 0.0
    for j in range(weight.size):
        total += weight[j] * factor[j] * floor[j] ** 1.5
    return total * 4.0 / 3.0


def quadratic_fit(thrust_low: float, thrust_high: float) -> tuple[float, float]:
    """Return k and p of [Ruth] Example 5.1: k T^2 is within the share p of |T|^(3/2) between two thrusts (N).

    k sqrt|T| - 1 is monotone in |T|, so that the largest error is least where both ends have the same:
    k = 2 / (sqrt(low) + sqrt(high)), p = (sqrt(high) - sqrt(low)) / (sqrt(high) + sqrt(low)).

    Raises
    ------
    InputError
        If a thrust is not finite or not above 0, or they are not in order.
    """
    low, high = positive_number("thrust_low", thrust_low), positive_number("thrust_high", thrust_high)
    if low > high:
        raise InputError(f"thrust_low: expected at most thrust_high, {high}, found {low}")
    low, high = math.sqrt(low), math.sqrt(high)
    return 2.0 / (low + high), (high - low) / (high + low)
