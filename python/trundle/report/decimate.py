"""Fewer points for the same picture: extremes in time, Douglas-Peucker in the plane."""

from __future__ import annotations

import numpy as np

from trundle.report.given import Array

__all__ = ["envelope", "simplify"]


def envelope(t: Array, y: Array, bins: int) -> tuple[Array, Array]:
    """Return a curve through the least and greatest value of each bin of time, so that no peak is lost.

    Parameters
    ----------
    t, y
        Time, increasing, and value, both (n,); NaN in `y` is a gap and stays one.
    bins
        Number of bins, about one a pixel; a curve of at most twice as many points is returned as it is.
    """
    if len(t) <= 2 * bins:
        return t, y
    edges = np.linspace(t[0], t[-1], bins + 1)[1:-1]
    keep: list[int] = []
    for part in np.split(np.arange(len(t)), np.searchsorted(t, edges)):
        keep.extend(_extremes(y, part))
    return t[keep], y[keep]


def _extremes(y: Array, part: np.ndarray) -> list[int]:
    """Return indices of the extremes among `part` in order; the first index where all is NaN (the gap)."""
    if not len(part):
        return []
    seen = part[np.isfinite(y[part])]
    if not len(seen):
        return [int(part[0])]
    low, high = int(seen[np.argmin(y[seen])]), int(seen[np.argmax(y[seen])])
    return sorted({low, high})


def simplify(points: Array, tolerance: float) -> Array:
    """Return a polyline (n, 2) within `tolerance` of the one given (Douglas & Peucker 1973), ends kept."""
    if len(points) < 3:
        return points
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1]] = True
    stack = [(0, len(points) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        distance = _distance(points[first + 1 : last], points[first], points[last])
        farthest = int(np.argmax(distance))
        if distance[farthest] > tolerance:
            middle = first + 1 + farthest
            keep[middle] = True
            stack += [(first, middle), (middle, last)]
    return points[keep]


def _distance(points: Array, start: Array, end: Array) -> Array:
    """Distance of points (n, 2) from the segment between two."""
    chord = end - start
    length = float(chord @ chord)
    offset = points - start
    share = np.clip(offset @ chord / length, 0.0, 1.0) if length > 0.0 else np.zeros(len(points))
    distance: Array = np.hypot(*(offset - share[:, None] * chord).T)
    return distance
