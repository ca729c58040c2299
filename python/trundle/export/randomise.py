"""Domain randomisation: parameters drawn from the posterior of a model."""

from __future__ import annotations

from typing import Any

import numpy as np

from trundle import _native
from trundle._native import Model

__all__ = ["draw", "ranges"]


def draw(model: Model, rng: np.random.Generator) -> dict[str, float]:
    """Draw a value for every parameter of a model from its posterior.

    Parameters
    ----------
    model : Model
        A model with a posterior. Draws have its covariance and respect the bounds of parameters. Parameters
        that are not in the posterior keep their values.
    rng : numpy.random.Generator
        Advanced by one integer.

    Returns
    -------
    dict
        Values by name, as `Laws` and the exported callback expect them.

    Examples
    --------
    >>> import numpy as np
    >>> import trundle
    >>> table = trundle.objects.read("configs/objects/office_table.toml").models["locked"]
    >>> values = trundle.export.draw(table, np.random.default_rng(0))
    >>> values["viscous_wheel.mu_y"]  # a given value; those of a fitted model vary
    320.0
    """
    return _native._draw(model, int(rng.integers(2**63)))


def ranges(model: Model) -> dict[str, dict[str, Any]]:
    """Return `mean`, `low`, `high` (95 % interval) and `unit` of each parameter of a model's posterior.

    Examples
    --------
    >>> import trundle
    >>> fit = trundle.fit("recordings/run_3")  # doctest: +SKIP
    >>> trundle.export.ranges(fit.model)["body.mass"]  # doctest: +SKIP
    {'mean': 21.98, 'low': 21.86, 'high': 22.1, 'unit': 'kg'}
    """
    rows = _native._ranges(model)
    return {
        name: {"mean": mean, "low": low, "high": high, "unit": unit} for name, unit, mean, (low, high) in rows
    }
