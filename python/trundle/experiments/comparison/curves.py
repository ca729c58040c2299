"""Learning curves of policies, as `trundle train` writes them."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.recording import TrundleError

__all__ = ["Curve", "read_curves"]

CURVE_COLUMNS = ("step", "success", "distance")
"""Columns of an evaluation."""


@dataclass(frozen=True)
class Curve:
    """The evaluations of one training run.

    Attributes
    ----------
    config : str
        Name of the training's file, without `.toml`.
    seed : int
    simulated : float
        Simulated time of all steps, s.
    cpu : float
        CPU time of the run, s; NaN if it is unknown.
    parameters : int
        Number of parameters of the policy.
    flattened : bool
        Whether the last fifth of the evaluations is no better than the fifth before.
    steps : ndarray
        Steps of the environment at each evaluation.
    success : ndarray
        Success rate.
    distance : ndarray
        Mean remaining distance, m.
    """

    config: str
    seed: int
    simulated: float
    cpu: float
    parameters: int
    flattened: bool
    steps: NDArray[np.float64]
    success: NDArray[np.float64]
    distance: NDArray[np.float64]


def read_curves(folder: Path) -> dict[str, list[Curve]]:
    """Return all curves of a folder by their config, in the order of their seeds."""
    found: dict[str, list[Curve]] = {}
    for path in sorted(folder.glob("*.json")):
        curve = read_curve(path)
        found.setdefault(curve.config, []).append(curve)
    return {name: sorted(curves, key=lambda one: one.seed) for name, curves in found.items()}


def read_curve(path: Path) -> Curve:
    """Read one curve, and the cost of its training from `timing/` next to its folder."""
    timing = path.parent.parent / "timing" / path.name
    try:
        told: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        cost = json.loads(timing.read_text(encoding="utf-8"))["cpu_seconds"] if timing.exists() else math.nan
        columns = {
            name: np.array([point[name] for point in told["curve"]], dtype=float) for name in CURVE_COLUMNS
        }
        return Curve(
            config=str(told["config"]),
            seed=int(told["seed"]),
            simulated=float(told["simulated_seconds"]),
            cpu=float(cost),
            parameters=int(told["parameters"]),
            flattened=bool(told["flattened"]),
            steps=columns["step"],
            success=columns["success"],
            distance=columns["distance"],
        )
    except (ValueError, KeyError, TypeError) as error:
        raise TrundleError(f"{path}: not a learning curve of `trundle train` ({error})") from error
