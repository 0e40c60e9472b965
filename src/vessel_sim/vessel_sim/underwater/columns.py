"""Columns of the arrays of the underwater model."""

from __future__ import annotations

# Motion: what a step changes, shape (MOTION,).
NORTH, EAST, DEPTH = 0, 1, 2  # of the origin of the body frame, m
QUATERNION = 3  # w, x, y, z of the attitude, of length 1
VELOCITY = 7  # surge, sway, heave, roll, pitch and yaw rate through the water, m/s and rad/s, body frame
RIGID = 13  # up to here what the equations of motion are about
THRUSTERS = 13  # force of all thrusters in six degrees of freedom, N and N m, body frame
HEADING = 19  # rad, not wrapped
MOTION = 20

# Body: what never changes, shape (BODY,); matrices row by row.
MASS = 0  # M_RB + M_A, (6, 6)
INVERSE = 36  # of it
LINEAR = 72  # damping, (6,)
QUADRATIC = 78  # damping, (6,)
WEIGHT = 84  # N
BUOYANCY = 85  # N, submerged
GRAVITY_CENTRE = 86  # m, body frame, (3,)
BUOYANCY_CENTRE = 89  # m, body frame, (3,)
HEIGHT = 92  # m
FIN_X = 93  # m ahead of the origin
FIN_RADIUS = 94  # m from the axis of the body
FIN_SWAY = 95  # lift of the fins over |u| v, N s^2/m^2
FIN_HEAVE = 96  # over |u| w
BODY = 97
