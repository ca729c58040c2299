"""Pictures of a pushed table: a small anti-aliased rasteriser over signed distances."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from trundle._native import LockedWheel as NativeLockedWheel

__all__ = ["SIZE", "View", "picture"]

SIZE = 480
"""Pixels along each side."""
EXTENT = 2.75
"""Half the side of what is shown, m."""
PIXEL = 2 * EXTENT / SIZE

FLOOR, TILE, EDGE = (246, 244, 239), (226, 222, 213), (150, 144, 132)
GOAL, TRAIL = (62, 142, 88), (120, 120, 130)
TABLE, RIM, TYRE = (196, 154, 104), (112, 80, 46), (52, 52, 58)
GRIPPER, FORCE = (46, 92, 160), (200, 48, 48)

FORCE_LENGTH = 0.8 / NativeLockedWheel.FULL[0]
"""Length of the arrow, m/N."""

Point = NDArray[np.float64]
Colour = tuple[int, int, int]


@dataclass(frozen=True)
class View:
    """What there is to see; nothing of it is hidden.

    Parameters
    ----------
    object, goal, gripper : sequence of float
        Poses in the world, m and rad.
    wrench : sequence of float
        At the grasp, gripper axes, N and N m.
    trail : sequence of pairs of float
        Where the object's middle has been, m.
    """

    object: tuple[float, float, float]
    goal: tuple[float, float, float]
    gripper: tuple[float, float, float]
    wrench: tuple[float, float, float]
    trail: tuple[tuple[float, float], ...] = ()


def picture(view: View) -> NDArray[np.uint8]:
    """Draw a view.

    Parameters
    ----------
    view : View
        What there is to see.

    Returns
    -------
    ndarray of uint8, shape (480, 480, 3)
        x to the right, y up, 5.5 m across; a fresh array.
    """
    canvas = Canvas(_floor().copy())
    goal, table = Frame(view.goal), Frame(view.object)
    canvas.polygon(goal(_corners()), GOAL, 0.18)
    canvas.outline(goal(_corners()), 0.03, GOAL)
    canvas.line(goal([(0.0, 0.0), (0.35, 0.0)]), 0.03, GOAL)
    canvas.line(np.array(view.trail[:: max(1, len(view.trail) // 60)]), 0.02, TRAIL, 0.6)
    for x, y in NativeLockedWheel.WHEELS:
        canvas.line(table([(x - 0.07, y), (x + 0.07, y)]), 0.08, TYRE)
    canvas.polygon(table(_corners()), TABLE, 0.8)
    canvas.outline(table(_corners()), 0.03, RIM)
    canvas.line(table([(0.0, 0.0), (0.35, 0.0)]), 0.03, RIM)
    _draw_push(canvas, view)
    return canvas.pixels.astype(np.uint8)


def _draw_push(canvas: Canvas, view: View) -> None:
    gripper = Frame(view.gripper)
    tip = FORCE_LENGTH * np.array(view.wrench[:2])
    length = float(np.hypot(*tip))
    if length > 0.02:
        along, across = tip / length, np.array([-tip[1], tip[0]]) / length
        neck = tip - 0.08 * along
        canvas.line(gripper(np.array([(0.0, 0.0), neck])), 0.03, FORCE)
        canvas.polygon(
            gripper(np.array([tip + 0.04 * along, neck + 0.07 * across, neck - 0.07 * across])), FORCE
        )
    canvas.line(gripper([(0.0, 0.0)]), 0.14, GRIPPER)


class Frame:
    """A pose that takes points of its own frame to the world."""

    def __init__(self, pose: tuple[float, float, float]) -> None:
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        self._rotation = np.array([[cos, sin], [-sin, cos]])
        self._origin = np.array(pose[:2])

    def __call__(self, points: Point | list[tuple[float, float]]) -> Point:
        """Return points of shape (n, 2) in the world."""
        moved: Point = np.asarray(points, dtype=np.float64) @ self._rotation + self._origin
        return moved


class Canvas:
    """Float pixels that shapes are blended onto, edges one pixel soft."""

    def __init__(self, pixels: NDArray[np.float32]) -> None:
        self.pixels = pixels

    def polygon(self, corners: Point, colour: Colour, opacity: float = 1.0) -> None:
        """Fill a convex polygon."""
        x, y, window = _window(corners, PIXEL)
        self._blend(window, _polygon_distance(x, y, corners), colour, opacity)

    def outline(self, corners: Point, width: float, colour: Colour) -> None:
        """Draw the rim of a convex polygon, `width` in m, inside it."""
        x, y, window = _window(corners, PIXEL)
        distance = _polygon_distance(x, y, corners)
        self._blend(window, np.maximum(distance, -distance - width), colour, 1.0)

    def line(self, points: Point, width: float, colour: Colour, opacity: float = 1.0) -> None:
        """Draw a polyline with round ends, `width` in m; one point is a disc."""
        if len(points) == 0:
            return
        x, y, window = _window(points, width)
        starts = points[:-1] if len(points) > 1 else points
        ends = points[1:] if len(points) > 1 else points
        distance = np.full(np.broadcast_shapes(x.shape, y.shape), np.inf)
        for start, end in zip(starts, ends, strict=True):
            np.minimum(distance, _segment_distance(x, y, start, end), out=distance)
        self._blend(window, distance - width / 2, colour, opacity)

    def _blend(self, window: tuple[slice, slice], distance: Point, colour: Colour, opacity: float) -> None:
        cover = np.clip(0.5 - distance / PIXEL, 0.0, 1.0)[..., None] * opacity
        part = self.pixels[window]
        part += cover * (np.array(colour) - part)


def _corners() -> list[tuple[float, float]]:
    x, y = NativeLockedWheel.HALF
    return [(-x, -y), (x, -y), (x, y), (-x, y)]


def _window(points: Point, margin: float) -> tuple[Point, Point, tuple[slice, slice]]:
    """Return x (1, m), y (n, 1) of the pixels around points, and where they are."""
    low = np.floor((points.min(axis=0) - margin + EXTENT) / PIXEL).astype(int).clip(0, SIZE)
    high = np.ceil((points.max(axis=0) + margin + EXTENT) / PIXEL).astype(int).clip(0, SIZE)
    x = (np.arange(low[0], high[0]) + 0.5) * PIXEL - EXTENT
    rows = slice(SIZE - high[1], SIZE - low[1])
    y = EXTENT - (np.arange(rows.start, rows.stop) + 0.5) * PIXEL
    return x[None, :], y[:, None], (rows, slice(low[0], high[0]))


def _polygon_distance(x: Point, y: Point, corners: Point) -> Point:
    """Distance to a convex polygon given counter-clockwise or clockwise, negative inside."""
    after = np.roll(corners, -1, axis=0)
    edges = after - corners
    turn = np.sign(np.sum(corners[:, 0] * after[:, 1] - after[:, 0] * corners[:, 1]))
    normals = turn * np.column_stack([edges[:, 1], -edges[:, 0]]) / np.hypot(*edges.T)[:, None]
    sides = [(x - p[0]) * n[0] + (y - p[1]) * n[1] for p, n in zip(corners, normals, strict=True)]
    return np.asarray(np.max(sides, axis=0))


def _segment_distance(x: Point, y: Point, start: Point, end: Point) -> Point:
    way = end - start
    square = float(way @ way)
    along = ((x - start[0]) * way[0] + (y - start[1]) * way[1]) / square if square > 0 else 0.0
    share = np.clip(along, 0.0, 1.0)
    return np.asarray(np.hypot(x - start[0] - share * way[0], y - start[1] - share * way[1]))


@cache
def _floor() -> NDArray[np.float32]:
    """Tiles of half a metre, and the arena's edge."""
    canvas = Canvas(np.full((SIZE, SIZE, 3), FLOOR, dtype=np.float32))
    for k in np.arange(-2.5, 2.51, 0.5):
        canvas.line(np.array([(k, -EXTENT), (k, EXTENT)]), 0.01, TILE)
        canvas.line(np.array([(-EXTENT, k), (EXTENT, k)]), 0.01, TILE)
    a = NativeLockedWheel.ARENA
    canvas.line(np.array([(-a, -a), (a, -a), (a, a), (-a, a), (-a, -a)]), 0.02, EDGE)
    return canvas.pixels
