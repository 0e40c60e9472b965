"""Loss of thrust and torque by ventilation and by leaving the water, [Ruth] 2.3.

``static`` and ``dynamic`` are machine code: who only reads vessel files does without them.
"""

from marine_model.ventilation.data import VentilationData

__all__ = ["VentilationData"]
