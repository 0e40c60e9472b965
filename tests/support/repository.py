"""Where things are in the checkout."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "src" / "dp_bringup" / "scenarios"
MESSAGES = ROOT / "msgs"
