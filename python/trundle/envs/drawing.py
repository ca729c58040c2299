"""Pictures of a push: floor, obstacles, goal, path, object, gripper and wrench."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from trundle.envs.raster import Canvas, Colour, Frame, Points
from trundle.envs.scene import HiddenWheel, Point, Polygon, Pose, Shape, View

__all__ = ["EXTENT", "picture"]

EXTENT = 1.1
"""Half the width of the picture, relative to half the side of the arena."""
TILE_SIZE_M = 0.5

# Distinguishable with colour blindness: arrows have a white casing, and green elements are outlines.
FLOOR, GROUT, BEYOND, EDGE = (247, 245, 240), (227, 223, 214), (222, 218, 209), (150, 144, 132)
WALL, WALL_RIM, SHADOW = (158, 160, 166), (88, 90, 98), (60, 50, 40)
GOAL, TRAIL = (0, 138, 98), (116, 118, 132)
OBJECT, RIM, TYRE = (204, 160, 108), (112, 78, 44), (46, 46, 52)
GRIPPER, FORCE, CASING = (0, 96, 168), (208, 52, 28), (255, 255, 255)
HIDDEN = (122, 30, 122)

FULL_FORCE_ARROW_M, FULL_TORQUE_SWEEP_RAD = 0.8, 1.5 * np.pi
"""Arrow length (m) of the full force, and sweep (rad) of the full torque."""
FULL_TORQUE_LEVER_M = 0.4
"""The full torque is that of the full force at this lever, m."""
TORQUE_ARC_RADIUS_M, ARROW_HEAD_M = 0.24, 0.13
"""Radius of the arrow for the torque, and length of an arrow's head, m."""
WORLD = Frame((0.0, 0.0, 0.0))


def picture(view: View, size: int = 480) -> NDArray[np.uint8]:
    """Draw a view.

    Parameters
    ----------
    view : View
        The scene.
    size : int
        Pixels along each side.

    Returns
    -------
    ndarray of uint8, shape (size, size, 3)
        A new array. x points to the right, y up; the world's origin is in the middle.
    """
    ground = _draw_scene(size, view.arena, view.obstacles, view.shape, view.goal, view.path)
    canvas = Canvas(ground.copy(), EXTENT * view.arena)
    if view.trail:
        canvas.line(np.array(view.trail), 0.02, TRAIL, 0.7)
    _draw_object(canvas, view)
    if view.gripper is not None:
        _draw_wrench(canvas, Frame(view.gripper), view)
        _draw_gripper(canvas, Frame(view.gripper), view.holds)
    for wheel in view.revealed:
        _draw_hidden(canvas, view, wheel)
    return canvas.pixels


def _draw_goal(canvas: Canvas, goal: Pose, shape: Shape) -> None:
    region = canvas.region(shape.fixtures, Frame(goal))
    canvas.fill(region, GOAL, 0.16)
    canvas.rim(region, 0.03, GOAL)
    _draw_heading(canvas, Frame(goal), shape.reach, GOAL)


def _draw_object(canvas: Canvas, view: View) -> None:
    frame = Frame(view.object)
    region = canvas.region(view.shape.fixtures, frame, margin=0.1) if view.shape.fixtures else None
    if region is not None:
        canvas.shade(region, 0.1, SHADOW, 0.35)
        canvas.fill(region, OBJECT, 0.85)
        canvas.rim(region, 0.03, RIM)
    for x, y in view.shape.wheels:
        canvas.line(frame([(x - 0.05, y), (x + 0.05, y)]), 0.06, TYRE, 0.6)
    _draw_heading(canvas, frame, view.shape.reach, RIM)


def _draw_heading(canvas: Canvas, frame: Frame, reach: float, colour: Colour) -> None:
    """Draw an arrow from the middle along x, with a dot at its start."""
    tip = 0.65 * reach
    canvas.line(frame([(0.0, 0.0), (tip, 0.0)]), 0.03, colour)
    canvas.line(frame([(tip - 0.07, 0.07), (tip, 0.0), (tip - 0.07, -0.07)]), 0.03, colour)
    canvas.line(frame([(0.0, 0.0)]), 0.08, colour)


def _draw_hidden(canvas: Canvas, view: View, wheel: HiddenWheel) -> None:
    """Draw a hidden wheel along its rolling direction, with its label on the outer side."""
    x, y, angle, label = wheel
    place = Frame(view.object)([(x, y)])[0]
    axle = Frame((place[0], place[1], view.object[2] + angle))
    for width, colour in ((0.16, CASING), (0.1, HIDDEN)):
        canvas.line(axle([(-0.09, 0.0), (0.09, 0.0)]), width, colour)
    if label:
        side = 1 if place[0] >= view.object[0] else -1
        canvas.text((place[0] + 0.2 * side, place[1]), side, label, 0.16, HIDDEN, CASING)


def _draw_gripper(canvas: Canvas, frame: Frame, holds: bool) -> None:
    """Draw a clamp with two jaws, or a ring around a tip of 2 cm."""
    if not holds:
        canvas.line(frame([(0.0, 0.0)]), 0.16, GRIPPER, 0.3)
        canvas.line(frame([(0.0, 0.0)]), 0.04, GRIPPER)
        return
    for y in (-0.085, 0.085):
        canvas.line(frame([(-0.03, y), (0.08, y)]), 0.045, GRIPPER)
    canvas.line(frame([(-0.03, -0.085), (-0.03, 0.085)]), 0.045, GRIPPER)
    canvas.line(frame([(0.0, 0.0)]), 0.11, GRIPPER)


def _draw_wrench(canvas: Canvas, frame: Frame, view: View) -> None:
    """Draw a straight arrow for the force, clipped at twice the full one, and a curved one for the torque."""
    turn = FULL_TORQUE_SWEEP_RAD * view.wrench[2] / (FULL_TORQUE_LEVER_M * view.force_scale)
    turn = float(np.clip(turn, -1.8 * np.pi, 1.8 * np.pi))
    if abs(turn) > 0.1:
        neck = np.sign(turn) * max(abs(turn) / 2 - ARROW_HEAD_M / TORQUE_ARC_RADIUS_M, -abs(turn) / 2)
        angles = np.pi + np.append(np.linspace(-turn / 2, neck, 40), turn / 2)
        _draw_arrow(canvas, frame(TORQUE_ARC_RADIUS_M * np.column_stack([np.cos(angles), np.sin(angles)])))
    force = np.array(view.wrench[:2]) / view.force_scale
    share = float(np.hypot(*force))
    length = FULL_FORCE_ARROW_M * min(share, 2.0)
    if length > 0.02:
        along = np.array([0.0, max(length - ARROW_HEAD_M, 0.0), length])
        _draw_arrow(canvas, frame(np.outer(along, force / share)))


def _draw_arrow(canvas: Canvas, points: Points) -> None:
    """Draw a polyline whose last segment is the arrow head."""
    way = points[-1] - points[-2]
    side = 0.6 * np.array([-way[1], way[0]])
    head = canvas.region([np.array([points[-1], points[-2] + side, points[-2] - side])], WORLD, margin=0.02)
    canvas.line(points[:-1], 0.075, CASING)
    canvas.fill(head, CASING, grow=0.02)
    canvas.line(points[:-1], 0.035, FORCE)
    canvas.fill(head, FORCE)


@lru_cache(maxsize=16)
def _draw_scene(
    size: int,
    arena: float,
    obstacles: tuple[Polygon, ...],
    shape: Shape,
    goal: Pose | None,
    path: tuple[Point, ...],
) -> NDArray[np.uint8]:
    """Draw the static part of the scene: floor, obstacles, goal and path."""
    canvas = Canvas(_draw_floor(size, arena).copy(), EXTENT * arena)
    for obstacle in obstacles:
        region = canvas.region([obstacle], WORLD, margin=0.08)
        canvas.shade(region, 0.08, SHADOW, 0.25)
        canvas.fill(region, WALL)
        canvas.rim(region, 0.03, WALL_RIM)
    if goal is not None and shape.fixtures:
        _draw_goal(canvas, goal, shape)
    if path:
        canvas.line(np.array(path), 0.03, GOAL, 0.9, dash=0.11)
    return canvas.pixels


@lru_cache(maxsize=4)
def _draw_floor(size: int, arena: float) -> NDArray[np.uint8]:
    """Draw the tiles and the edge of the arena."""
    extent = EXTENT * arena
    canvas = Canvas(np.full((size, size, 3), BEYOND, dtype=np.uint8), extent)
    square = canvas.region([((-arena, -arena), (arena, -arena), (arena, arena), (-arena, arena))], WORLD)
    canvas.fill(square, FLOOR)
    for k in TILE_SIZE_M * np.arange(-(extent // TILE_SIZE_M), extent // TILE_SIZE_M + 1):
        canvas.line(np.array([(k, -extent), (k, extent)]), 0.012, GROUT)
        canvas.line(np.array([(-extent, k), (extent, k)]), 0.012, GROUT)
    canvas.rim(square, 0.025, EDGE)
    return canvas.pixels
