"""Random numbers and array types that the generators of recordings share."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = ["Floats", "log_uniform"]

Floats: TypeAlias = NDArray[np.float64]


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a draw between two positive limits that is uniform in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
