"""The integer codes of a drive: from -code_max to code_max."""

from __future__ import annotations

import math
import operator
from typing import SupportsIndex

from marine_model.errors import InputError


def require_code(code: SupportsIndex, code_max: int) -> int:
    """Return ``code`` as an int.

    Raises
    ------
    InputError
        If it is not a whole number (2.0 is not one) or beyond ``code_max`` either way.
    """
    try:
        if isinstance(code, bool):
            raise TypeError
        number = operator.index(code)
    except TypeError as error:
        raise InputError(f"code: expected a whole number, found {code!r}") from error
    if abs(number) > code_max:
        raise InputError(f"code: expected a whole number from {-code_max} to {code_max}, found {number}")
    return number


def nearest_code(value: float, code_max: int) -> int:
    """Return the code nearest to a finite ``value``: halves away from zero, saturated at ``code_max``."""
    return int(math.copysign(min(math.floor(abs(value) + 0.5), code_max), value))
