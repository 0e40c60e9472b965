"""What can go wrong before anything is compared."""

from __future__ import annotations

from marine_model.errors import DpError


class ReexecutionError(DpError):
    """A node cannot be re-executed from a bag; the message says what is missing."""
