"""A small anti-aliased rasteriser over signed distances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trundle.envs.distance import Plane, Points, polygon_distance, sample_polyline, text_coverage
from trundle.envs.scene import Disc, Point, Polygon, Pose

__all__ = ["Canvas", "Colour", "Frame", "Points", "Region"]

Colour = tuple[int, int, int]
Where = tuple[slice, slice] | tuple[NDArray[np.intp], ...]

MIN_LINE_WIDTH_PX = 1.5
"""Minimum width of lines, pixels, so that they stay visible in small pictures."""


class Frame:
    """A coordinate frame; calling it transforms points to the world."""

    def __init__(self, pose: Pose) -> None:
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        self._rotation = np.array([[cos, sin], [-sin, cos]])
        self._origin = np.array(pose[:2])

    def __call__(self, points: Points | Sequence[Point]) -> Points:
        """Transform points (n, 2) to the world."""
        moved: Points = np.asarray(points, dtype=np.float64) @ self._rotation + self._origin
        return moved


@dataclass(frozen=True)
class Region:
    """Signed distance to a shape, pixels, negative inside, in the window of the picture around it."""

    distance: Plane
    window: tuple[slice, slice]


class Canvas:
    """A picture to draw on, with anti-aliased edges.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (n, n, 3)
        Modified in place.
    extent : float
        Half the width of the picture, m; the world's origin is in the middle.
    """

    def __init__(self, pixels: NDArray[np.uint8], extent: float) -> None:
        self.pixels = pixels
        self._size = len(pixels)
        self._extent = extent
        self._scale = self._size / (2 * extent)

    def region(self, parts: Sequence[Polygon | Disc | Points], frame: Frame, margin: float = 0.0) -> Region:
        """Return the signed distance to the union of `parts`, in a window with a `margin` (m)."""
        corners = [self._pixels(frame([p.centre] if isinstance(p, Disc) else p)) for p in parts]
        radii = [p.radius * self._scale if isinstance(p, Disc) else 0.0 for p in parts]
        reach = margin * self._scale + 1
        low = np.min([c.min(axis=0) - r - reach for c, r in zip(corners, radii, strict=True)], axis=0)
        high = np.max([c.max(axis=0) + r + reach for c, r in zip(corners, radii, strict=True)], axis=0)
        left, top = np.floor(low).clip(0, self._size).astype(int).tolist()
        right, bottom = np.ceil(high + 1).clip(0, self._size).astype(int).tolist()
        x = np.arange(left, right, dtype=np.float32)[None, :]
        y = np.arange(top, bottom, dtype=np.float32)[:, None]
        each = [polygon_distance(x, y, [c]) - np.float32(r) for c, r in zip(corners, radii, strict=True)]
        return Region(np.minimum.reduce(each), (slice(top, bottom), slice(left, right)))

    def fill(self, region: Region, colour: Colour, opacity: float = 1.0, grow: float = 0.0) -> None:
        """Fill a region that is enlarged by `grow`, m."""
        cover = np.clip(0.5 + grow * self._scale - region.distance, 0.0, 1.0)
        self._blend(region.window, cover, colour, opacity)

    def rim(self, region: Region, width: float, colour: Colour) -> None:
        """Draw the rim of a region, inside its edge; `width` in m."""
        inner = -region.distance - max(width * self._scale, MIN_LINE_WIDTH_PX)
        self._blend(region.window, np.clip(0.5 - np.maximum(region.distance, inner), 0.0, 1.0), colour)

    def shade(self, region: Region, width: float, colour: Colour, opacity: float) -> None:
        """Draw a soft shadow around a region; `width` in m."""
        cover = np.clip(1.0 - region.distance / (width * self._scale), 0.0, 1.0)
        self._blend(region.window, cover * cover, colour, opacity)

    def line(
        self, points: Points, width: float, colour: Colour, opacity: float = 1.0, dash: float = 0.0
    ) -> None:
        """Draw a polyline with round ends; `width` and `dash` in m. A single point gives a disc."""
        radius = max(width * self._scale, MIN_LINE_WIDTH_PX) / 2
        reach = int(radius + 1.5)
        dots = sample_polyline(self._pixels(points), dash * self._scale)
        dots = dots[np.all((dots > -reach) & (dots < self._size - 1 + reach), axis=1)]
        if len(dots) == 0:
            return
        x, y = np.rint(dots).astype(np.intp).T[..., None] + np.arange(-reach, reach + 1)
        square = ((x - dots[:, :1]) ** 2)[:, None, :] + ((y - dots[:, 1:]) ** 2)[:, :, None]
        near = np.clip(0.5 + radius - np.sqrt(square), 0.0, 1.0).astype(np.float32)
        left, top, wide = x.min(), y.min(), np.ptp(x) + 1
        cover = np.zeros((np.ptp(y) + 1) * wide, dtype=np.float32)
        np.maximum.at(cover, ((y[:, :, None] - top) * wide + x[:, None, :] - left).ravel(), near.ravel())
        self._stamp(left, top, cover.reshape(-1, wide), colour, opacity)

    def text(self, at: Point, side: int, words: str, height: float, ink: Colour, paper: Colour) -> None:
        """Write text of `height` (m) on a plate to the right (side 1) or left (-1) of a point."""
        cover = text_coverage(words, height * self._scale)
        left, middle = np.rint(self._pixels([at])[0]).astype(int).tolist()
        left -= cover.shape[1] if side < 0 else 0
        top = middle - len(cover) // 2
        self._stamp(left, top, np.ones_like(cover), paper, 0.8)
        self._stamp(left, top, cover, ink, 1.0)

    def _stamp(self, left: int, top: int, cover: Plane, colour: Colour, opacity: float) -> None:
        """Blend a colour with the coverage `cover`, placed at (left, top) and clipped to the picture."""
        cover = cover[max(-top, 0) : max(self._size - top, 0), max(-left, 0) : max(self._size - left, 0)]
        rows, columns = np.nonzero(cover > 0.0)
        self._blend((rows + max(top, 0), columns + max(left, 0)), cover[rows, columns], colour, opacity)

    def _pixels(self, points: Points | Sequence[Point]) -> Points:
        """Convert points to columns and rows (n, 2); integers are the centres of pixels."""
        flipped: Points = np.asarray(points, dtype=np.float64) * (1.0, -1.0)
        return (flipped + self._extent) * self._scale - 0.5

    def _blend(self, where: Where, cover: Plane, colour: Colour, opacity: float = 1.0) -> None:
        part = self.pixels[where].astype(np.float32)
        part += (cover * np.float32(opacity))[..., None] * (np.array(colour, dtype=np.float32) - part)
        self.pixels[where] = part + np.float32(0.5)
