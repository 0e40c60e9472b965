"""Low-level anti-spin: propeller torque observed, loss factor, ventilation flag, thrust and speed limits."""

from thruster_drivers.ventilation.antispin import AntiSpin
from thruster_drivers.ventilation.monitor import VentilationMonitor, VentilationState
from thruster_drivers.ventilation.settings import AntiSpinSettings, VentilationSettings

__all__ = ["AntiSpin", "AntiSpinSettings", "VentilationMonitor", "VentilationSettings", "VentilationState"]
