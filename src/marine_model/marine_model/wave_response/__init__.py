"""What regular waves do to a hull: motion and mean drift over frequency and heading, from potential flow.

The data files in this folder are written by ``scripts/hydrodynamics``; docs/hydrodynamics.md says how.
"""

from marine_model.wave_response.load import load_wave_response, wave_response_names, wave_response_path
from marine_model.wave_response.response import WaveResponse

__all__ = ["WaveResponse", "load_wave_response", "wave_response_names", "wave_response_path"]
