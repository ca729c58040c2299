"""Domain randomisation: objects that the data allow."""

from __future__ import annotations

from typing import Any

import numpy as np

from trundle import _native
from trundle._native import Model

__all__ = ["draw", "ranges"]


def draw(model: Model, rng: np.random.Generator) -> dict[str, float]:
    """Draw a value for every parameter of a model from the posterior that it carries.

    Parameters
    ----------
    model : Model
        Its parameters vary together, as their covariance says; what is positive stays positive, what is
        bounded within its bounds. What the posterior leaves out keeps its value.
    rng : numpy.random.Generator
        Advanced by one integer.

    Returns
    -------
    dict
        Value by name, as `Laws` and the exported callback take them.
    """
    return _native._draw(model, int(rng.integers(2**63)))


def ranges(model: Model) -> dict[str, dict[str, Any]]:
    """Return `mean`, `low`, `high` (95 % interval) and `unit` of each parameter of a model's posterior."""
    rows = _native._ranges(model)
    return {
        name: {"mean": mean, "low": low, "high": high, "unit": unit} for name, unit, mean, (low, high) in rows
    }
