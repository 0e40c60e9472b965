"""What may be wrong with a bag."""

from __future__ import annotations

from marine_model.errors import DpError


class BagError(DpError):
    """A bag cannot be read, or lacks what is asked of it; the message says what."""


class DamageError(BagError):
    """Bytes of an MCAP file are not what they should be.

    Parameters
    ----------
    at
        Byte of the file where the trouble begins.
    reason
        What is wrong.
    """

    def __init__(self, at: int, reason: str) -> None:
        super().__init__(f"byte {at}: {reason}")
        self.at = at
        self.reason = reason


class CutOffError(DamageError):
    """An MCAP file ends before its end: whoever wrote it was killed, or the file was cut."""
