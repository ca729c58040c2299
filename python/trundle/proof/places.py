"""Places on the floor: where an object stood, and how much of two regions is the same there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle.proof.scene import Scene
from trundle.proof.shapes import inside

__all__ = ["overlap", "standing_points", "visited"]

Floats = NDArray[np.float64]

CELL = 0.05
"""Of the grid on which regions are compared, m."""


def standing_points(scene: Scene, path: Floats) -> Floats:
    """Return where the points that drag lie in the world (n, m, 2) along a path (n, 3)."""
    c, s = np.cos(path[:, 2])[:, None], np.sin(path[:, 2])[:, None]
    x, y = scene.standing.T
    return np.stack([path[:, :1] + c * x - s * y, path[:, 1:2] + s * x + c * y], axis=2)


def visited(scene: Scene, paths: Sequence[Floats]) -> list[list[int]]:
    """Return the cells of the floor over which a point went."""
    points = np.concatenate([standing_points(scene, path[::20]).reshape(-1, 2) for path in paths])
    cells = np.unique(np.floor(points / CELL).astype(int), axis=0)
    return [[int(x), int(y)] for x, y in cells]


def overlap(found: ArrayLike, true: ArrayLike, cells: Sequence[Sequence[int]]) -> float:
    """Return the area common to two polygons over that of either, within the cells that were visited."""
    middles = (np.array(cells, dtype=float).reshape(-1, 2) + 0.5) * CELL
    a, b = (inside(middles, np.asarray(polygon, dtype=float)) for polygon in (found, true))
    either = int(np.sum(a | b))
    return float(np.sum(a & b)) / either if either else 0.0
