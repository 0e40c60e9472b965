"""What may go wrong while recording."""

from __future__ import annotations

from marine_model.errors import DpError


class RecordingRefusedError(DpError):
    """A recording cannot begin: the message says what is in the way."""


class RecordingStoppedError(DpError):
    """A recording ended before its time, e.g. on a full disk; what was written before is a whole, readable bag."""
