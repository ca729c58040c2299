"""Geometry on the floor: transformed points, visited cells, and overlap of regions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from trundle.experiments.blind.scene import Scene
from trundle.experiments.blind.shapes import inside
from trundle.experiments.sampling import Floats

__all__ = [
    "distance_to_outline",
    "region_overlap",
    "to_object",
    "to_world",
    "visited_cells",
    "world_friction_points",
]


CELL_SIZE_M = 0.05
"""Cell of the grid on which regions are compared."""


def world_friction_points(scene: Scene, path: Floats) -> Floats:
    """Return the world positions (n, m, 2) of the points with floor friction along a path (n, 3)."""
    c, s = np.cos(path[:, 2])[:, None], np.sin(path[:, 2])[:, None]
    x, y = scene.friction_points.T
    return np.stack([path[:, :1] + c * x - s * y, path[:, 1:2] + s * x + c * y], axis=2)


def visited_cells(scene: Scene, paths: Sequence[Floats]) -> list[list[int]]:
    """Return the grid cells of the floor that a friction point visited."""
    points = np.concatenate([world_friction_points(scene, path[::20]).reshape(-1, 2) for path in paths])
    cells = np.unique(np.floor(points / CELL_SIZE_M).astype(int), axis=0)
    return [[int(x), int(y)] for x, y in cells]


def region_overlap(found: ArrayLike, true: ArrayLike, cells: Sequence[Sequence[int]]) -> float:
    """Return intersection over union of two polygons within the visited cells."""
    middles = (np.array(cells, dtype=float).reshape(-1, 2) + 0.5) * CELL_SIZE_M
    a, b = (inside(middles, np.asarray(polygon, dtype=float)) for polygon in (found, true))
    either = int(np.sum(a | b))
    return float(np.sum(a & b)) / either if either else 0.0


def to_world(point: Floats, path: Floats) -> Floats:
    """Return the world positions (n, 2) of a point of the object (2,) along a path (n, 3)."""
    c, s = np.cos(path[:, 2]), np.sin(path[:, 2])
    x = path[:, 0] + c * point[0] - s * point[1]
    return np.column_stack([x, path[:, 1] + s * point[0] + c * point[1]])


def to_object(place: Floats, path: Floats) -> Floats:
    """Return the positions (n, 2) of a world point (2,) in the object's frame along a path (n, 3)."""
    c, s = np.cos(path[:, 2]), np.sin(path[:, 2])
    dx, dy = place[0] - path[:, 0], place[1] - path[:, 1]
    return np.column_stack([c * dx + s * dy, c * dy - s * dx])


def distance_to_outline(points: Floats, outline: Floats) -> Floats:
    """Return the signed distance of points (n, 2) from a polygon (m, 2), negative inside."""
    ends = np.roll(outline, -1, axis=0) - outline
    off = points[:, None, :] - outline[None, :, :]
    along = np.clip(np.sum(off * ends, axis=2) / np.sum(ends**2, axis=1), 0.0, 1.0)
    nearest = np.hypot(*np.moveaxis(off - along[:, :, None] * ends, 2, 0)).min(axis=1)
    return np.asarray(np.where(inside(points, outline), -nearest, nearest))
