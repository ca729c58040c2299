"""The outline of an object as an agent observes it."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from trundle.envs.observation import Observation

__all__ = ["bounding_rectangle", "observed_shape", "outline_hull"]

Array: TypeAlias = NDArray[np.float64]

MIN_TURN_M2 = 1e-6
"""Cross product of two edges below which they are one edge, m². Rounded coordinates have smaller errors."""
EDGE_TOLERANCE_M = 1e-3
"""Distance from a side of the bounding box within which a point lies on it, m."""


def observed_shape(observation: Observation, source: object) -> Array:
    """Return the observed outline, or else the bounding box, object frame, m; shape (n, 2).

    Parameters
    ----------
    observation : Observation
        One observation with the size of the object.
    source : object
        The environment. Its attributes `has_outline` and `version`, if it has them, state what the
        observation contains.
    """
    if getattr(source, "has_outline", False):
        return outline_hull(observation)
    return bounding_rectangle(observation, has_middle=getattr(source, "version", 0) > 0)


def bounding_rectangle(observation: Observation, *, has_middle: bool) -> Array:
    """Return the corners of the bounding box, object frame, m; shape (4, 2).

    Parameters
    ----------
    observation : Observation
        One observation with the size of the object.
    has_middle : bool
        Whether it contains the middle of the box, as from version 1 on. Otherwise that is the origin.
    """
    middle = observation.middle if has_middle else np.zeros(2)
    return np.asarray(middle + observation.half_size * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]))


def outline_hull(observation: Observation) -> Array:
    """Return the convex hull of the observed outline, object frame, m; shape (n, 2), anticlockwise.

    A corner between two observed directions is added where the adjacent edges meet. Where they do not, an
    edge on a side of the bounding box may extend to the next direction. The hull covers notches, which the
    distances to the outermost points do not show completely.
    """
    radii, half = observation.outline_radii, observation.half_size
    angles = np.linspace(0.0, 2 * np.pi, radii.size, endpoint=False)
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    points = radii[:, None] * ways
    corners = list[Array]()
    for k, point in enumerate(points):
        before, after, beyond = points[k - 1], points[(k + 1) % len(points)], points[(k + 2) % len(points)]
        turns = [cross(point - before, after - point), cross(after - point, beyond - after)]
        corner = crossing(before, point, beyond, after) if min(turns) > -MIN_TURN_M2 else None
        if corner is not None and cross(point, corner) > 0.0 and cross(corner, after) > 0.0:
            corners.append(np.clip(corner, -half, half))
        else:
            corners += longest_sides(point, ways[(k + 1) % len(ways)], half)
            corners += longest_sides(after, ways[k], half)
    return convex_hull(np.array([*points, *corners])) + observation.middle


def longest_sides(point: Array, way: Array, half: Array) -> list[Array]:
    """Return the farthest ends of sides of the box through a point: where they meet another direction."""
    ends = list[Array]()
    for axis in (0, 1):
        is_on_side = half[axis] - abs(point[axis]) < EDGE_TOLERANCE_M
        if is_on_side and way[axis] * point[axis] > 1e-9:
            ends.append(np.clip(way * abs(half[axis] / way[axis]), -half, half))
    return ends


def cross(a: Array, b: Array) -> float:
    """Return the cross product of two vectors of the plane."""
    return float(a[0] * b[1] - a[1] * b[0])


def crossing(a: Array, b: Array, c: Array, d: Array) -> Array | None:
    """Return the intersection of the lines through a, b and through c, d; None if they are parallel."""
    along, other = b - a, d - c
    determinant = cross(along, other)
    if abs(determinant) <= 1e-3 * np.hypot(*along) * np.hypot(*other):
        return None
    return np.asarray(a + cross(c - a, other) / determinant * along)


def convex_hull(points: Array) -> Array:
    """Return the corners of the convex hull, anticlockwise (Andrew 1979); shape (n, 2)."""

    def chain(ordered: Array) -> list[Array]:
        kept = list[Array]()
        for point in ordered:
            while len(kept) > 1 and cross(kept[-1] - kept[-2], point - kept[-1]) <= MIN_TURN_M2:
                kept.pop()
            kept.append(point)
        return kept[:-1]

    # Unequal by rounding only, points on one side would be in the wrong order.
    ordered = np.unique(points.round(6), axis=0)
    return np.array(chain(ordered) + chain(ordered[::-1]))
