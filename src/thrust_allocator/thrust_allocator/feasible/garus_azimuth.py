"""Four azimuth propellers that turn together: reserved yaw moment, asteroid, thrust angle: [Garus-A] (7)-(18).

The propellers sit at (sx d cos phi, sy d sin phi), sx and sy being +1 or -1, and point to (sx cos a, -sy sin a): one
angle a for all four, 0 < a < pi/2, folded into each quadrant. Then (8)-(10), and the pseudo-inverse (6) is

    f = sx X / (4 cos a) - sy Y / (4 sin a) - sx sy N / (4 d sin(a + phi))

so that the largest of the four thrusts is the sum of the sizes of the three terms. N needs no more than f_tau3 at any
angle if |N| is no more than the reserved moment, (14); what is left, 4 (f_max - f_tau3) = R, is for

    |X| / cos a + |Y| / sin a <= R                                                                (F)

whose left side is least at tan a = (|Y| / |X|)^(1/3), where it is (|X|^(2/3) + |Y|^(2/3))^(3/2). So the asteroid (16)
holds all demands that are feasible at their own best angle, (18); it is not what is feasible at the present angle.
Step 2 of the algorithm keeps the present angle for all of them: (100, 400) N passes (17) against 750 N and needs 937 N
at 29.1 deg. :func:`next_angle` has both rules.

With angle_min above 0 the corners of the asteroid shrink by cos(angle_min), (15), and so does all of it, (16): a point
X = R cos(angle_min) cos^3 t, Y = R cos(angle_min) sin^3 t then satisfies (F) at the angle t brought within the range,
which (18) leaves out.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cbrt, cos, hypot, inf, pi, sin

import numpy as np

from marine_model.errors import InputError
from marine_model.guards import FloatArray

# Share of a distance or a thrust by which four propellers may differ and still count as alike.
_ALIKE = 1e-6


@dataclass(frozen=True, slots=True)
class AzimuthSquare:
    """Four azimuth propellers as (7) asks for.

    Attributes
    ----------
    thrusters
        Which thrusters of the vessel they are.
    sign_x, sign_y
        sx and sy of each, shape (4,).
    distance, bearing
        d, m, and phi, rad in (0, pi/2).
    thrust_max
        f_max of each, N, the same both ways.
    """

    thrusters: tuple[int, ...]
    sign_x: FloatArray
    sign_y: FloatArray
    distance: float
    bearing: float
    thrust_max: float

    @classmethod
    def of(cls, thrusters: tuple[int, ...], x: FloatArray, y: FloatArray, thrust_max: FloatArray) -> AzimuthSquare:
        """Return the square of the propellers at ``x``, ``y`` (m) with ``thrust_max`` (N), each of shape (4,).

        Raises
        ------
        InputError
            If they are not four, one in every quadrant, mirrored in both axes and of the same thrust.
        """
        asked = "garus_azimuth: expected four azimuth thrusters of the same thrust at (+-x, +-y)"
        if len(thrusters) != 4:
            raise InputError(f"{asked}, found {len(thrusters)} azimuth thrusters")
        where = [f"({a:g}, {b:g}) m" for a, b in zip(x.tolist(), y.tolist(), strict=True)]
        signs = {(bool(a > 0.0), bool(b > 0.0)) for a, b in zip(x.tolist(), y.tolist(), strict=True)}
        arm_x, arm_y = float(np.abs(x).mean()), float(np.abs(y).mean())
        near = _ALIKE * hypot(arm_x, arm_y)
        alike = np.abs(np.abs(x) - arm_x).max() <= near and np.abs(np.abs(y) - arm_y).max() <= near
        if len(signs) != 4 or not alike or min(arm_x, arm_y) <= near:
            raise InputError(f"{asked}, found them at {', '.join(where)}")
        strength = float(thrust_max.mean())
        if np.abs(thrust_max - strength).max() > _ALIKE * strength:
            raise InputError(f"{asked}, found {thrust_max.tolist()} N")
        return cls(thrusters, np.sign(x), np.sign(y), hypot(arm_x, arm_y), atan2(arm_y, arm_x), strength)

    def directions(self, angle: float) -> FloatArray:
        """Return the azimuth of every propeller at thrust angle ``angle`` (rad), shape (4,), rad: (7)."""
        found: FloatArray = np.arctan2(-self.sign_y * sin(angle), self.sign_x * cos(angle))
        return found


def check_range(angle_min: float) -> None:
    """Check the smallest thrust angle (rad); the largest is pi/2 - angle_min, (7).

    Raises
    ------
    InputError
        If it is not within 0 and pi/4.
    """
    if not 0.0 <= angle_min < pi / 4.0:
        raise InputError(f"garus_azimuth.angle_min: expected 0 or more and less than pi/4 rad, found {angle_min}")


def fold(azimuth: float) -> float:
    """Return the thrust angle, rad in [0, pi/2], of a propeller that points to ``azimuth`` (rad): (7)."""
    return atan2(abs(sin(azimuth)), abs(cos(azimuth)))


def largest_moment(square: AzimuthSquare, angle_min: float) -> float:
    """Return the moment that all four give at any angle of the range, N m: right side of (12).

    sin(a + phi) is least at one end of the range: at angle_min with phi < pi/4, at pi/2 - angle_min with phi > pi/4.
    """
    least = min(sin(angle_min + square.bearing), sin(pi / 2.0 - angle_min + square.bearing))
    return 4.0 * square.distance * least * square.thrust_max


def check_moment(square: AzimuthSquare, moment: float, angle_min: float) -> None:
    """Check the reserved yaw ``moment`` (N m).

    Raises
    ------
    InputError
        If it is not 0 or more and less than that of (12).
    """
    largest = largest_moment(square, angle_min)
    if not 0.0 <= moment < largest:
        raise InputError(
            f"garus_azimuth.reserved_moment: expected 0 or more and less than {largest:.6g} N m, which all four give "
            f"at any angle, found {moment}"
        )


def reserved_thrust(square: AzimuthSquare, moment: float, angle_min: float) -> float:
    """Return f_tau3, N: what every propeller keeps for the yaw ``moment`` (N m), (14); no more than it has."""
    largest = largest_moment(square, angle_min)
    return square.thrust_max * min(moment / largest, 1.0) if largest > 0.0 else 0.0


def force_limit(square: AzimuthSquare, reserved: float, angle_min: float) -> float:
    """Return tau_1max = tau_2max, N, with ``reserved`` (N) kept of every propeller: (15)."""
    return 4.0 * cos(angle_min) * (square.thrust_max - reserved)


def asteroid_excess(surge: float, sway: float, limit: float) -> float:
    """Return the left side of (17), N^(2/3): at most 0 within the asteroid of ``limit`` (N)."""
    return cbrt(surge) ** 2 + cbrt(sway) ** 2 - cbrt(limit) ** 2


def asteroid_load(surge: float, sway: float, limit: float) -> float:
    """Return how many times the asteroid must grow to reach the demand: 1 where :func:`asteroid_excess` is 0.

    The demand over it, if it is above 1, is tau' of (18): the point of the asteroid in the same direction.
    """
    size = (cbrt(surge) ** 2 + cbrt(sway) ** 2) ** 1.5
    return (size / limit if limit > 0.0 else inf) if size > 0.0 else 0.0


def load_at(surge: float, sway: float, angle: float, room: float) -> float:
    """Return the left side of (F) over ``room`` = 4 (f_max - f_tau3), N: at most 1 if feasible at ``angle``."""
    total = 0.0
    for size, part in ((abs(surge), cos(angle)), (abs(sway), sin(angle))):
        if size > 0.0:
            total += size / part if part > 0.0 else inf
    return (total / room if room > 0.0 else inf) if total > 0.0 else 0.0


def best_angle(surge: float, sway: float, angle_min: float) -> float:
    """Return alpha' of (18) brought within the range, rad; for a demand other than zero.

    (18) takes the arctangent of a quotient of the demands; this one knows no quotient. Of the range it says nothing:
    outside, (F) is least at the nearer end.
    """
    angle = atan2(cbrt(abs(sway)), cbrt(abs(surge)))
    return min(max(angle, angle_min), pi / 2.0 - angle_min)


@dataclass(frozen=True, slots=True)
class AngleChoice:
    """What the algorithm of [Garus-A] makes of a demand.

    Attributes
    ----------
    surge, sway
        tau'_d1, tau'_d2, N: permissible at the best angle.
    angle
        alpha', rad: where the propellers are to turn.
    load
        :func:`asteroid_load`.
    """

    surge: float
    sway: float
    angle: float
    load: float


def next_angle(
    surge: float, sway: float, present: float, limit: float, room: float, angle_min: float, *, as_printed: bool = False
) -> AngleChoice:
    """Return permissible forces and thrust angle: steps 1 to 3.

    Outside the asteroid, forces and angle are those of (18). Inside, the demand is permissible, and the angle stays
    as it is if it gives the demand, by (F), and is the best one otherwise. As printed, it stays in any case, which
    leaves many demands unserved. Without a demand it stays.

    Parameters
    ----------
    surge, sway
        Demand, N; finite.
    present
        Thrust angle now, rad in [0, pi/2]; brought within the range if it is not.
    limit
        tau_1max of (15), N.
    room
        4 (f_max - f_tau3), N.
    angle_min
        End of the range, rad.
    as_printed
        Take step 2 as it is printed.
    """
    stays = min(max(present, angle_min), pi / 2.0 - angle_min)
    load = asteroid_load(surge, sway, limit)
    if load > 1.0:
        return AngleChoice(surge / load, sway / load, best_angle(surge, sway, angle_min), load)
    if load == 0.0 or as_printed or load_at(surge, sway, stays, room) <= 1.0:
        return AngleChoice(surge, sway, stays, load)
    return AngleChoice(surge, sway, best_angle(surge, sway, angle_min), load)


def asteroid_area(limit: float) -> float:
    """Return the area of the asteroid of ``limit`` (N), N^2: 3 pi / 8 of its square."""
    return 3.0 * pi / 8.0 * limit**2
