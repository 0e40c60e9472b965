"""Properties that mass and damping matrices must have."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def require_symmetric(name: str, matrix: ArrayLike) -> None:
    """Raise ValueError if ``matrix``, shape (n, n), is not symmetric to 1e-9 of its largest element."""
    array = np.asarray(matrix, dtype=np.float64)
    if np.abs(array - array.T).max() > 1e-9 * np.abs(array).max():
        raise ValueError(f"{name} must be symmetric, found {array.tolist()}")


def require_positive_definite(name: str, matrix: ArrayLike) -> None:
    """Raise ValueError if the symmetric part of ``matrix``, shape (n, n), is not positive definite.

    Its smallest eigenvalue must be above 1e-9 of its largest, so that the matrix can be inverted safely.
    """
    array = np.asarray(matrix, dtype=np.float64)
    eigenvalues = np.linalg.eigvalsh(0.5 * (array + array.T))
    if eigenvalues[0] <= 1e-9 * eigenvalues[-1]:
        raise ValueError(f"{name} must be positive definite, found {array.tolist()}")
