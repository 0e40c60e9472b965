"""The thruster configuration matrix: from thrusts to the generalized force (surge N, sway N, yaw N m).

Two forms of the same map: polar, in which the columns depend on the azimuth angles, [Ruth] (4.3) reduced to
surge, sway and yaw; and Cartesian, linear in the thrust components, [Ruth] (4.24).
"""

from __future__ import annotations

import numpy as np

from marine_model.guards import FloatArray


def polar_configuration(lever_x: FloatArray, lever_y: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Return B(azimuth), shape (3, n): generalized force per newton along each azimuth direction.

    Parameters
    ----------
    lever_x, lever_y
        Thruster positions in the body frame, shape (n,), m.
    azimuth
        Force directions, shape (n,), rad, 0 ahead and positive to starboard.
    """
    c, s = np.cos(azimuth), np.sin(azimuth)
    matrix = np.empty((3, len(lever_x)))
    matrix[0] = c
    matrix[1] = s
    matrix[2] = lever_x * s - lever_y * c
    return matrix


def cartesian_configuration(lever_x: FloatArray, lever_y: FloatArray) -> FloatArray:
    """Return B_C, shape (3, 2 n), of [Ruth] (4.24); its argument is [T_x (n), T_y (n)] in N."""
    n = len(lever_x)
    matrix = np.zeros((3, 2 * n))
    matrix[0, :n] = 1.0
    matrix[1, n:] = 1.0
    matrix[2, :n] = -lever_y
    matrix[2, n:] = lever_x
    return matrix


def thruster_columns(position: FloatArray, plane: FloatArray) -> FloatArray:
    """Return the generalized force of a newton along n_1 and n_2 of every thruster, shape (n, 6, 2): [Ruth] (4.3).

    Column j of the thruster configuration matrix in six degrees of freedom is ``columns[j] @ (cos a_j, sin a_j)``.

    Parameters
    ----------
    position
        r_j, where the thrusters sit, shape (n, 3), m, body frame.
    plane
        n_1 and n_2, shape (n, 2, 3): force directions at azimuths 0 and pi/2.
    """
    columns = np.empty((len(position), 6, 2))
    columns[:, :3] = plane.transpose(0, 2, 1)
    columns[:, 3:] = np.cross(position[:, None, :], plane).transpose(0, 2, 1)
    return columns


def generalized_force(lever_x: FloatArray, lever_y: FloatArray, thrust: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Return B(azimuth) thrust, shape (3,): N, N, N m in the body frame."""
    force_x = thrust * np.cos(azimuth)
    force_y = thrust * np.sin(azimuth)
    return np.array([force_x.sum(), force_y.sum(), (lever_x * force_y - lever_y * force_x).sum()])
