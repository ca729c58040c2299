"""Decimation of curves for display: extremes per time bin, and Douglas-Peucker in the plane."""

from __future__ import annotations

import numpy as np

from trundle.report.series import Array

__all__ = ["envelope", "representative_rows", "simplify"]


def envelope(t: Array, y: Array, bins: int) -> tuple[Array, Array]:
    """Return the curve through the minimum and maximum of each time bin, which preserves every peak.

    Parameters
    ----------
    t, y
        Increasing times and values, both (n,). NaN in `y` is a gap, which is preserved.
    bins
        Number of bins, about one per pixel. A curve of at most `2 * bins` points is returned unchanged.
    """
    if len(t) <= 2 * bins:
        return t, y
    edges = np.linspace(t[0], t[-1], bins + 1)[1:-1]
    keep: list[int] = []
    for part in np.split(np.arange(len(t)), np.searchsorted(t, edges)):
        keep.extend(_extremes(y, part))
    return t[keep], y[keep]


def representative_rows(t: Array, values: Array, most: int) -> np.ndarray:
    """Return indices of at most `most` rows, among them the extremes of every column in bins of time.

    Parameters
    ----------
    t, values
        Increasing times (n,), and columns (n, k), in which NaN is a gap.
    most
        Maximum number of rows; at least 4 (k + 1).
    """
    if len(t) <= most:
        return np.arange(len(t))
    bins = most // (2 * values.shape[1] + 2)
    edges = np.linspace(t[0], t[-1], bins + 1)[1:-1]
    parts = np.split(np.arange(len(t)), np.searchsorted(t, edges))
    keep = {index for column in values.T for part in parts for index in _extremes(column, part)}
    spread = np.linspace(0, len(t) - 1, max(2, most - len(keep))).astype(int)
    return np.array(sorted(keep | set(spread.tolist())))


def _extremes(y: Array, part: np.ndarray) -> list[int]:
    """Return the indices of the extremes among `part`, ascending; its first index if all values are NaN."""
    if not len(part):
        return []
    seen = part[np.isfinite(y[part])]
    if not len(seen):
        return [int(part[0])]
    low, high = int(seen[np.argmin(y[seen])]), int(seen[np.argmax(y[seen])])
    return sorted({low, high})


def simplify(points: Array, tolerance: float) -> Array:
    """Return a subset of the points (n, 2) whose polyline is within `tolerance` (Douglas & Peucker 1973)."""
    if len(points) < 3:
        return points
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1]] = True
    stack = [(0, len(points) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        distance = _distance_to_segment(points[first + 1 : last], points[first], points[last])
        farthest = int(np.argmax(distance))
        if distance[farthest] > tolerance:
            middle = first + 1 + farthest
            keep[middle] = True
            stack += [(first, middle), (middle, last)]
    return points[keep]


def _distance_to_segment(points: Array, start: Array, end: Array) -> Array:
    """Return the distances (m,) of points (m, 2) from the segment between `start` and `end`."""
    chord = end - start
    length = float(chord @ chord)
    offset = points - start
    share = np.clip(offset @ chord / length, 0.0, 1.0) if length > 0.0 else np.zeros(len(points))
    distance: Array = np.hypot(*(offset - share[:, None] * chord).T)
    return distance
