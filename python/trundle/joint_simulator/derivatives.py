"""Derivatives of the effort that a black-box simulator needs, by positions and parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.joint_simulator.calls import JointSimulator, Samples
from trundle.joint_simulator.inverse import InverseDynamics, accelerations

__all__ = ["by_parameter", "by_position"]

Floats = NDArray[np.float64]

POSITION_STEP = 1e-3
"""Step of central differences by position, rad or m."""
PARAMETER_STEP = 1e-3
"""Step of differences by a parameter, as a share of its size or of the distance of its bounds."""


def by_position(
    simulator: JointSimulator,
    samples: Samples,
    q: Floats,
    v: Floats,
    values: Mapping[str, float],
    found: InverseDynamics,
) -> Floats:
    """Return derivatives, (T, n, n): entry [t, i, k] is that of effort i by position k."""
    columns = []
    for k in range(simulator.n):
        shift = np.zeros(simulator.n)
        shift[k] = POSITION_STEP
        up, down = (
            accelerations(simulator, samples, q + sign * shift, v, found.effort, values) for sign in (1, -1)
        )
        columns.append(_effort(found, up - down) / (2 * POSITION_STEP))
    return np.stack(columns, axis=2)


def by_parameter(
    simulator: JointSimulator,
    samples: Samples,
    q: Floats,
    v: Floats,
    values: Mapping[str, float],
    found: InverseDynamics,
    parameters: Sequence[Mapping[str, Any]],
) -> Floats:
    """Return derivatives, (T, n, p), by each parameter."""
    columns = []
    for parameter in parameters:
        name = parameter["name"]
        low, high = _neighbours(parameter, values[name])
        ends = [
            accelerations(simulator, samples, q, v, found.effort, {**values, name: value})
            for value in (high, low)
        ]
        columns.append(_effort(found, ends[0] - ends[1]) / (high - low))
    return np.stack(columns, axis=2) if columns else np.empty((*q.shape, 0))


def _effort(found: InverseDynamics, change: Floats) -> Floats:
    """Return the change of effort that compensates for a change of acceleration at constant effort."""
    return np.asarray(-np.einsum("tij,tj->ti", found.mass_matrix, change))


def _neighbours(parameter: Mapping[str, Any], value: float) -> tuple[float, float]:
    """Return values around a value and within the bounds."""
    spread = parameter["sd"] or parameter["upper"] - parameter["lower"]
    size = max(abs(value), abs(parameter["start"])) or (spread if np.isfinite(spread) else 1.0)
    step = PARAMETER_STEP * size
    return max(value - step, parameter["lower"]), min(value + step, parameter["upper"])
