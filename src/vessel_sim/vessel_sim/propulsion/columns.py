"""Columns of the tables of the propulsion plant: one row for each thruster."""

from __future__ import annotations

# What does not change: parameters, shape (n, PARAMETERS).
INERTIA = 0  # J, kg m^2
VISCOUS = 1  # Q_v, N m s
STATIC = 2  # Q_s, N m
TORQUE_MAX = 3  # motor torque either way, N m
TURNS = 4  # 1 where there is an azimuth motor, else 0
AZIMUTH_RATE_MAX = 5  # rad/s
AZIMUTH_TIME_CONSTANT = 6  # s
CONTROLLABLE = 7  # 1 where there is a pitch actuator, else 0
PITCH_MIN = 8
PITCH_MAX = 9
PITCH_RATE_MAX = 10  # 1/s
PITCH_TIME_CONSTANT = 11  # s
DIAMETER = 12  # D, m
DENSITY = 13  # rho, kg/m^3
PROPELLER = 14  # row in the table of propellers
VENTILATION = 15  # row in the table of ventilation parameters; -1 where there is no loss to air
PARAMETERS = 16

# What a step changes: state, shape (n, STATE).
SHAFT_SPEED = 0  # n, Hz
AZIMUTH = 1  # rad, not wrapped
AZIMUTH_RATE = 2  # rad/s
PITCH_RATIO = 3  # P/D
THRUST_WETTED = 4  # beta_Tw
TORQUE_WETTED = 5  # beta_Qw
MOTOR_TORQUE = 6  # N m, what the motor delivered during the last step
THRUST = 7  # N, after losses
PROPELLER_TORQUE = 8  # N m, after losses
THRUST_LOSS = 9  # beta_T = beta_area beta_Tw
TORQUE_LOSS = 10  # beta_Q = beta_area beta_Qw
ADVANCE_SPEED = 11  # V_A, m/s
SUBMERGENCE = 12  # h, m, of the shaft below the surface
STEP = 13  # s, of the last step
AZIMUTH_SETTLED = 14  # 1 - exp(-step / T) of the azimuth motor
STATE = 15

# What a step is given: inputs, shape (INPUTS, n).
TORQUE_INPUT = 0  # N m
AZIMUTH_RATE_INPUT = 1  # rad/s
PITCH_INPUT = 2
ADVANCE_SPEED_INPUT = 3  # m/s, at the end of the step
SUBMERGENCE_INPUT = 4  # m, at the end of the step
INPUTS = 5
INPUT_NAMES = ("torque", "azimuth_rate", "pitch_ratio", "advance_speed", "submergence")
