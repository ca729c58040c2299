"""Depth of single points inside an outline, for inner loops."""

from __future__ import annotations

import math

import numpy as np

from trundle.experiments.blind.shapes import Shape

__all__ = ["OutlineDistance"]


class OutlineDistance:
    """Depth of points inside an outline, in the object's frame."""

    def __init__(self, shape: Shape) -> None:
        self.disc = shape.disc
        ring = shape.outline
        edges = np.roll(ring, -1, axis=0) - ring
        lengths = np.hypot(*edges.T)
        self.edges = [
            (float(x), float(y), float(u), float(v), float(length))
            for (x, y), (u, v), length in zip(ring, edges / lengths[:, None], lengths, strict=True)
        ]

    def depth(self, x: float, y: float) -> tuple[float, float, float]:
        """Return the depth of a point (negative outside), and the outward normal of the nearest edge."""
        if self.disc is not None:
            dx, dy = x - self.disc[0], y - self.disc[1]
            far = math.hypot(dx, dy) or 1e-12
            return self.disc[2] - far, dx / far, dy / far
        best, off_x, off_y, odd = math.inf, 0.0, 0.0, False
        nx, ny = 1.0, 0.0
        for ex, ey, u, v, length in self.edges:
            dx, dy = x - ex, y - ey
            along = min(max(u * dx + v * dy, 0.0), length)
            px, py = dx - along * u, dy - along * v
            square = px * px + py * py
            if square < best:
                best, off_x, off_y, nx, ny = square, px, py, v, -u
            end = ey + v * length
            if (ey > y) != (end > y) and x < ex + (y - ey) * u / v:
                odd = not odd
        far = math.sqrt(best)
        if odd:
            return far, nx, ny
        return (-far, off_x / far, off_y / far) if far > 1e-9 else (0.0, nx, ny)
