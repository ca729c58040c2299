"""Random furniture in top view: a rectangle, an L, or a round table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle.experiments.sampling import Floats

__all__ = ["Shape", "draw_shape", "inside"]


KINDS = ("rectangle", "ell", "round")
FOOT_INSET_M = 0.05
"""Distance of the feet from the edge."""


@dataclass(frozen=True)
class Shape:
    """Top view of an object, in the object's frame, m.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    boxes : tuple of (x, y, half width, half depth)
        Parts of equal density; empty for a disc.
    disc : (x, y, radius), optional
        The disc.
    outline : array (n, 2)
        Corners; 32 points on the circle for a disc.
    feet : array (m, 2)
        Positions of the feet.
    """

    kind: str
    boxes: tuple[tuple[float, float, float, float], ...]
    disc: tuple[float, float, float] | None
    outline: Floats
    feet: Floats

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

    def described(self, *, with_feet: bool) -> dict[str, Any]:
        """Return the shape as keys of `[object]` in a recording."""
        told: dict[str, Any] = {"support": rounded(self.feet)} if with_feet else {}
        if self.disc is not None:
            return {**told, "fixture": [{"disc": list(self.disc), "density": 1.0}]}
        return {"footprint": rounded(self.outline), **told}

    def corners(self) -> Floats:
        """Return the points with floor friction if no feet are stated: the corners.

        A disc has its feet in place of corners.
        """
        return self.feet if self.disc is not None else self.outline


def draw_shape(rng: np.random.Generator) -> Shape:
    """Return a shape of random kind and size with its frame near its middle."""
    kind = str(rng.choice(KINDS, p=(0.5, 0.25, 0.25)))
    at = np.round(rng.uniform(-0.1, 0.1, 2), 3)
    if kind == "rectangle":
        half = np.round((rng.uniform(0.35, 0.75), rng.uniform(0.25, 0.45)), 3)
        return shape_from_boxes(kind, rectangle(half), at, [(0.0, 0.0, *half)])
    if kind == "ell":
        return ell(rng, at)
    radius = round(float(rng.uniform(0.35, 0.6)), 3)
    turn = np.linspace(0.0, 2 * np.pi, 33)[:-1]
    count = int(rng.integers(3, 6))
    legs = 2 * np.pi * np.arange(count) / count
    ring = [np.column_stack([np.cos(a), np.sin(a)]) for a in (turn, legs)]
    feet = at + (radius - FOOT_INSET_M) * ring[1]
    return Shape(kind, (), (float(at[0]), float(at[1]), radius), at + radius * ring[0], feet)


def ell(rng: np.random.Generator, at: Floats) -> Shape:
    """Return an L-shaped desk: two boxes that share an edge."""
    width, depth = np.round(rng.uniform((1.0, 0.8), (1.6, 1.3)), 3)
    thick = round(float(rng.uniform(0.35, 0.5)), 3)
    w, d = width / 2, depth / 2
    corners = [[-w, -d], [w, -d], [w, thick - d], [thick - w, thick - d], [thick - w, d], [-w, d]]
    along = (0.0, thick / 2 - d, w, thick / 2)
    across = (thick / 2 - w, thick / 2, thick / 2, d - thick / 2)
    return shape_from_boxes("ell", np.array(corners), at, [along, across])


def rectangle(half: Floats) -> Floats:
    """Return the corners of a rectangle, counter-clockwise."""
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half


def shape_from_boxes(
    kind: str, outline: Floats, at: Floats, boxes: list[tuple[float, float, float, float]]
) -> Shape:
    """Return a shape of boxes, moved to `at`, with feet inside its corners."""
    moved = tuple((float(x + at[0]), float(y + at[1]), float(w), float(d)) for x, y, w, d in boxes)
    return Shape(kind, moved, None, outline + at, inset_corners(outline) + at)


def inset_corners(outline: Floats) -> Floats:
    """Return the corners moved inwards along both edges (right angles only), counter-clockwise."""
    before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
    inwards = [
        left_normal(corner - a) + left_normal(b - corner)
        for a, corner, b in zip(before, outline, after, strict=True)
    ]
    return np.asarray(np.round(outline + FOOT_INSET_M * np.array(inwards), 3))


def left_normal(edge: Floats) -> Floats:
    """Return the unit normal to the left of an edge: inwards if the outline is counter-clockwise."""
    return np.asarray(np.array([-edge[1], edge[0]]) / np.hypot(*edge))


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
