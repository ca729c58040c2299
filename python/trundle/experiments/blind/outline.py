"""Outlines of objects in top view, and geometry on the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trundle.experiments.sampling import Floats

__all__ = [
    "CELL_SIZE_M",
    "Outline",
    "OutlineDistance",
    "circle",
    "distance_to_outline",
    "inset_corners",
    "inside",
    "region_overlap",
    "to_object",
    "to_world",
]

CELL_SIZE_M = 0.05
"""Cell of the grid on which regions are compared."""


@dataclass(frozen=True)
class Outline:
    """Top view of an object of equal density, in the object's frame, m.

    Attributes
    ----------
    kind : str
        Name of the shape.
    disc : (x, y, radius), optional
        The disc.
    outline : array (n, 2)
        Corners, counter-clockwise; 32 points on the circle for a disc.
    feet : array (m, 2)
        Positions of the feet.
    boxes : tuple of (x, y, half width, half depth)
        Parts of furniture; empty for a disc.
    parts : tuple of array (n, 2)
        Convex parts of other outlines, counter-clockwise, without overlap; empty for a disc.
    """

    kind: str
    disc: tuple[float, float, float] | None
    outline: Floats
    feet: Floats
    boxes: tuple[tuple[float, float, float, float], ...] = ()
    parts: tuple[Floats, ...] = ()

    @property
    def area(self) -> float:
        """Area, m²."""
        return float(abs(np.sum(cross(self.outline, np.roll(self.outline, -1, axis=0))) / 2))

    @property
    def centroid(self) -> Floats:
        """Centre of the area, m."""
        a, b = self.outline, np.roll(self.outline, -1, axis=0)
        weights = cross(a, b)[:, None]
        return np.asarray(np.sum((a + b) * weights, axis=0) / (3 * np.sum(weights)))

    @property
    def gyration(self) -> float:
        """Radius of gyration about the object's origin, m."""
        a, b = self.outline, np.roll(self.outline, -1, axis=0)
        squares = np.sum(a * a + a * b + b * b, axis=1)
        return float(np.sqrt(abs(np.sum(cross(a, b) * squares) / 12) / self.area))

    @property
    def spin(self) -> float:
        """Polar second moment of the area about its centroid, per area, m²."""
        if self.disc is not None:
            return float(self.disc[2] ** 2 / 2)
        return float(self.gyration**2 - self.centroid @ self.centroid)

    def edges(self) -> tuple[Floats, Floats]:
        """Return the edges (n, 2) from each corner to the next, and their lengths."""
        edges = np.roll(self.outline, -1, axis=0) - self.outline
        return edges, np.hypot(*edges.T)

    def described(self, *, with_feet: bool) -> dict[str, Any]:
        """Return the shape as keys of `[object]` in a recording."""
        feet: dict[str, Any] = {"support": rounded(self.feet)} if with_feet else {}
        if self.disc is not None:
            return {**feet, "fixture": [{"disc": list(self.disc), "density": 1.0}]}
        return {"footprint": rounded(self.outline), **feet}

    def corners(self) -> Floats:
        """Return the points with floor friction if no feet are stated: the corners, or a disc's feet."""
        return self.feet if self.disc is not None else self.outline


def circle(count: int) -> Floats:
    """Return points (count, 2) at equal angles on the unit circle."""
    turn = 2 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(turn), np.sin(turn)])


def inset_corners(outline: Floats, by: float, decimals: int) -> Floats:
    """Return the corners moved inwards, `by` from both edges, rounded."""
    before, after = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    m, n = (np.column_stack([-e[:, 1], e[:, 0]]) / np.hypot(*e.T)[:, None] for e in (before, after))
    inward = (m + n) / (1.0 + np.sum(m * n, axis=1))[:, None]
    return np.asarray(np.round(outline + by * inward, decimals))


def cross(a: Floats, b: Floats) -> Floats:
    """Return the cross products of plane vectors (n, 2)."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def inside(points: Floats, polygon: Floats) -> NDArray[np.bool_]:
    """Return which points (n, 2) lie in a polygon (m, 2), by counting crossings."""
    x, y = points[:, 0], points[:, 1]
    found = np.zeros(len(points), dtype=bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        spans = (ay > y) != (by > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            found ^= spans & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    return found


def rounded(points: Floats) -> list[list[float]]:
    """Return points as plain numbers, rounded to 0.1 mm."""
    return [[round(float(x), 4), round(float(y), 4)] for x, y in points]


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


class OutlineDistance:
    """Depth of single points inside an outline in the object's frame, for inner loops."""

    def __init__(self, shape: Outline) -> None:
        self.disc = shape.disc
        edges, lengths = shape.edges()
        rows = np.column_stack([shape.outline, edges / lengths[:, None], lengths])
        self.edges: list[list[float]] = rows.tolist()

    def depth(self, x: float, y: float) -> tuple[float, float, float]:
        """Return the depth of a point (negative outside), and the outward normal of the nearest edge."""
        if self.disc is not None:
            dx, dy = x - self.disc[0], y - self.disc[1]
            far = math.hypot(dx, dy) or 1e-12
            return self.disc[2] - far, dx / far, dy / far
        best, off_x, off_y, odd = math.inf, 0.0, 0.0, False
        nx, ny = 1.0, 0.0
        for ex, ey, u, v, length in self.edges:
            dx, dy = x - ex, y - ey
            along = min(max(u * dx + v * dy, 0.0), length)
            px, py = dx - along * u, dy - along * v
            square = px * px + py * py
            if square < best:
                best, off_x, off_y, nx, ny = square, px, py, v, -u
            end = ey + v * length
            if (ey > y) != (end > y) and x < ex + (y - ey) * u / v:
                odd = not odd
        far = math.sqrt(best)
        if odd:
            return far, nx, ny
        return (-far, off_x / far, off_y / far) if far > 1e-9 else (0.0, nx, ny)
