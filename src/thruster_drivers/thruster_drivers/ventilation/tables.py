"""Columns of the tables that the compiled functions of this package share; a row for each thruster."""

from __future__ import annotations

# What a thruster is.
INERTIA = 0  # 2 pi J, N m/(Hz/s)
STATIC = 1  # N m, Coulomb friction
VISCOUS = 2  # N m/Hz
NOISE = 3  # Hz: noise of the measured shaft speed over the noise allowed in beta_Q, at the rate of the feedback
NOISE_SAMPLED = 4  # Hz: the same for the control system's slower samples
SPEED_MIN = 5  # Hz, n_min
TORQUE_RATE_LIMIT = 6  # N m/s
TORQUE_RATE_TIME = 7  # s, window of the rate of torque
DECELERATION_LIMIT = 8  # Hz/s, above 0
EXCLUDED = 9  # 1: never flagged
PARAMETERS = 10

# What is remembered of it.
KNOWN = 0  # 0 before the first feedback, and while a sensor is lost
SPEED = 1  # Hz, observed
BETA = 2  # loss factor of the torque observer
BETA_SAMPLED = 3  # loss factor from the torque balance of control samples
TORQUE_SLOW = 4  # N m, motor torque behind the filter of its rate
FLAG = 5  # 1: ventilating
LAST_SPEED = 6  # Hz, measured at the last feedback
ELAPSED = 7  # s of the control sample under way
IMPULSE = 8  # N m s, motor torque less friction over it
NOMINAL = 9  # N m s, nominal propeller torque over it
START = 10  # Hz, shaft speed at its start
RATE = 11  # Hz/s, mean rate of shaft speed over the last whole sample
REMEMBERED = 12  # beta_Q2
RING = 13  # (impulse, nominal, shaft speed at the start) of the last whole samples, newest first

WINDOW = 4  # samples of the control system: what takes longer to tell is not told
RING_WIDTH = 3
STATE = RING + WINDOW * RING_WIDTH

# What is told of it after a feedback: rows, a column for each thruster.
TOLD_FLAG = 0
TOLD_BETA = 1
TOLD_REMEMBERED = 2
TOLD_TORQUE = 3  # N m, observed propeller torque; 0 where a sensor is lost
TOLD_SPEED = 4  # Hz, observed; NaN where a sensor is lost
TOLD_LOST = 5
TOLD = 6
