"""Loss of thrust and torque by ventilation and by leaving the water, [Ruth] 2.3."""

from marine_model.ventilation.data import VentilationData
from marine_model.ventilation.dynamic import LossRates, extrapolated, shifted
from marine_model.ventilation.static import LossFactors, VentilationModel

__all__ = ["LossFactors", "LossRates", "VentilationData", "VentilationModel", "extrapolated", "shifted"]
