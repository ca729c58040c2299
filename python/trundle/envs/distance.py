"""Distances to polygons, sampling of polylines, and text coverage, in pixels with rows downwards."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from trundle._optional import require

__all__ = ["Plane", "Points", "polygon_distance", "sample_polyline", "text_coverage"]

Points = NDArray[np.float64]
Plane = NDArray[np.float32]

DOT_SPACING_PX = 0.5
"""Spacing of the dots of a line, pixels, small enough for a straight edge."""


def polygon_distance(x: Plane, y: Plane, rings: Sequence[Points]) -> Plane:
    """Return the signed distance of pixels to a polygon, negative inside.

    Parameters
    ----------
    x, y : ndarray of float32, shapes (1, m) and (n, 1)
        Columns and rows.
    rings : sequence of ndarrays, shape (k, 2)
        Corners in either orientation. A ring inside another is a hole.

    Returns
    -------
    ndarray of float32, shape (n, m)
    """
    square = np.full((y.size, x.size), np.inf, dtype=np.float32)
    inside = np.zeros(square.shape, dtype=bool)
    for ring in rings:
        for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            np.minimum(square, _segment_square(x, y, start, end), out=square)
            inside ^= _crosses(x, y, start, end)
    distance: Plane = np.sqrt(square)
    np.negative(distance, out=distance, where=inside)
    return distance


def sample_polyline(points: Points, dash: float = 0.0) -> Points:
    """Return dots along a polyline; if `dash` > 0, a gap of 0.8 `dash` follows each dash."""
    if len(points) < 2:
        return points
    ends = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    along = np.linspace(0.0, ends[-1], int(ends[-1] / DOT_SPACING_PX) + 2)
    if dash > 0.0:
        along = along[along % (1.8 * dash) < dash]
    return np.column_stack([np.interp(along, ends, column) for column in points.T])


@lru_cache(maxsize=64)
def text_coverage(words: str, height: float) -> Plane:
    """Return the coverage of each pixel by a text, with a margin; capitals are about 0.75 `height` high."""
    textpath = require("matplotlib.textpath", "plots", "labels in pictures")
    outline = textpath.TextPath((0.0, 0.0), words, size=height)
    rings = [np.array(ring) * (1.0, -1.0) for ring in outline.to_polygons()]
    width = max((ring[:, 0].max() for ring in rings), default=0.0)
    x = np.arange(-3.0, width + 3.0, dtype=np.float32)[None, :]
    y = np.arange(-height, 0.4 * height, dtype=np.float32)[:, None]
    cover: Plane = np.clip(0.5 - polygon_distance(x, y, rings), 0.0, 1.0)
    return cover


def _segment_square(x: Plane, y: Plane, start: Points, end: Points) -> Plane:
    """Return the squared distance to a segment."""
    way_x, way_y = (end - start).tolist()
    x, y = x - np.float32(start[0]), y - np.float32(start[1])
    length = max(way_x**2 + way_y**2, 1e-12)
    share = np.clip(x * (way_x / length) + y * (way_y / length), 0.0, 1.0)
    across, down = x - share * way_x, y - share * way_y
    square: Plane = across * across + down * down
    return square


def _crosses(x: Plane, y: Plane, start: Points, end: Points) -> NDArray[np.bool_]:
    """Return whether a ray from a pixel to the right crosses a segment."""
    (x0, y0), (x1, y1) = start.tolist(), end.tolist()
    if y0 == y1:
        return np.zeros((1, 1), dtype=bool)
    at = x0 + (y - y0) * ((x1 - x0) / (y1 - y0))
    crossed: NDArray[np.bool_] = ((y0 > y) != (y1 > y)) & (x < at)
    return crossed
