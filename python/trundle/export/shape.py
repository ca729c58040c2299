"""Decomposition of footprints into convex polygons, for MuJoCo geoms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

__all__ = ["Point", "area", "convex_pieces", "is_convex"]

Point: TypeAlias = "tuple[float, float]"


def convex_pieces(polygon: Sequence[Point]) -> list[list[Point]]:
    """Return a convex polygon itself, or the triangles of a simple one (ear clipping, Meisters 1975)."""
    corners = list(polygon) if area(polygon) > 0 else list(reversed(polygon))
    if is_convex(corners):
        return [corners]
    triangles = []
    while len(corners) > 3:
        k = next((k for k in range(len(corners)) if is_ear(corners, k)), 0)
        triangle = [corners[k - 1], corners[k], corners[(k + 1) % len(corners)]]
        if area(triangle) > 0:
            triangles.append(triangle)
        del corners[k]
    return [*triangles, corners]


def is_convex(corners: Sequence[Point]) -> bool:
    """Return whether a counter-clockwise polygon is convex."""
    return all(turn(corners[k - 2], corners[k - 1], corners[k]) >= 0 for k in range(len(corners)))


def area(polygon: Sequence[Point]) -> float:
    """Return the signed area of a polygon, positive if counter-clockwise."""
    pairs = zip(polygon, [*polygon[1:], polygon[0]], strict=True)
    return 0.5 * sum(x * v - u * y for (x, y), (u, v) in pairs)


def turn(a: Point, b: Point, c: Point) -> float:
    """Return twice the signed area of a triangle, positive if counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def is_ear(corners: Sequence[Point], k: int) -> bool:
    """Return whether corner `k` and its neighbours form a triangle inside that contains no other corner."""
    a, b, c = corners[k - 1], corners[k], corners[(k + 1) % len(corners)]
    if turn(a, b, c) <= 0:
        return False
    others = [p for p in corners if p not in (a, b, c)]
    return not any(min(turn(a, b, p), turn(b, c, p), turn(c, a, p)) >= 0 for p in others)
