"""Constants of nature that more than one package needs."""

from __future__ import annotations

GRAVITY = 9.81  # m/s^2
