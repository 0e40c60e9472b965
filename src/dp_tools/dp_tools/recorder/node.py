"""`ros2 run dp_tools recorder`: a bag of a whole run."""

from __future__ import annotations

import sys

from dp_tools.recorder.session import run


def main() -> None:
    """Run the recorder and exit the process."""
    sys.exit(run())
