"""Columns of the packed parameters of ventilation."""

from __future__ import annotations

# Loss factors to which the lines of [Ruth] (2.40)-(2.43) belong.
HIGH_LOSS_FACTOR = 0.8
LOW_LOSS_FACTOR = 0.2

A_08_PLUS = 0
B_08_PLUS = 1
A_08_MINUS = 2
B_08_MINUS = 3
A_02_PLUS = 4
B_02_PLUS = 5
A_02_MINUS = 6
B_02_MINUS = 7
BETA_TW_MAX = 8
BETA_TW_MIN = 9
A_Q = 10
B_Q = 11
THRUST_RISE_RATE = 12  # 1/s
TORQUE_RISE_RATE = 13  # 1/s
TIME_SHIFT = 14  # s
WIDTH = 15

# Fields of VentilationData in the order of the columns.
NAMES = (
    "a_08_plus",
    "b_08_plus",
    "a_08_minus",
    "b_08_minus",
    "a_02_plus",
    "b_02_plus",
    "a_02_minus",
    "b_02_minus",
    "beta_tw_max",
    "beta_tw_min",
    "a_q",
    "b_q",
    "thrust_rise_rate",
    "torque_rise_rate",
    "time_shift",
)
