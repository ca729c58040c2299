"""Outlines of an object and its wheels, and points in three dimensions."""

from __future__ import annotations

import numpy as np

from trundle.picture import place_outline
from trundle.viewing.scene import RAIL_SIZE_M, Floats, Shape, Wheel

__all__ = ["lift", "object_outlines", "wheel_outline"]

WHEEL_LENGTH, WHEEL_WIDTH = 0.12, 0.045
"""Size of a wheel, in sizes of the object."""
SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5]])


def lift(points: Floats, height: float = 0.0) -> Floats:
    """Return points (n, 2) at a height: (n, 3), m."""
    return np.column_stack([points, np.full(len(points), height)])


def object_outlines(shape: Shape) -> list[Floats]:
    """Return the closed outlines of an object; a square for an object on a rail."""
    return list(shape.outline) or [RAIL_SIZE_M * SQUARE]


def wheel_outline(wheel: Wheel, size: float) -> Floats:
    """Return the closed outline (5, 2) of a wheel, m, object frame; the long side is its x axis.

    `size` is that of the object, m.
    """
    corners = size * SQUARE * np.array([WHEEL_LENGTH, WHEEL_WIDTH])
    return place_outline(corners, np.array([*wheel.position, wheel.angle]))
