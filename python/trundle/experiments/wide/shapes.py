"""Random outlines: rectangles, L, T, triangles, discs and polygons, with off-centre frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from trundle.experiments.blind.shapes import Shape
from trundle.experiments.sampling import Floats, log_uniform

__all__ = ["Outline", "draw_outline"]


KINDS = ("rectangle", "ell", "tee", "triangle", "disc", "polygon")
KIND_PROBABILITIES = (0.25, 0.15, 0.15, 0.15, 0.15, 0.15)
FEET_INSET = 0.08
"""Distance of the feet from the edges, as a share of the radius of gyration."""


@dataclass(frozen=True)
class Outline(Shape):
    """An outline with its convex parts.

    Attributes
    ----------
    parts : tuple of array (n, 2)
        Convex, counter-clockwise, without overlap; empty for a disc.
    """

    parts: tuple[Floats, ...] = ()

    @property
    def spin(self) -> float:
        """Polar second moment of the area about its centroid, per area, m²."""
        if self.disc is not None:
            return float(self.disc[2] ** 2 / 2)
        return float(self.gyration**2 - self.centroid @ self.centroid)


def draw_outline(rng: np.random.Generator) -> Outline:
    """Return an outline of random kind, size and frame."""
    kind = str(rng.choice(KINDS, p=KIND_PROBABILITIES))
    size = log_uniform(rng, 0.2, 0.7)
    parts, ring = OUTLINE_FACTORIES[kind](rng, size)
    corner = rng.random() < 0.15
    off = ring[int(rng.integers(len(ring)))] if corner else rng.uniform(-0.2, 0.2, 2) * size
    ring, parts = rounded(ring - off), [rounded(part - off) for part in parts]
    if kind != "disc":
        return Outline(kind, (), None, ring, inset_corners(ring, FEET_INSET * size), tuple(parts))
    x, y = np.round(-off, 3)
    radius = round(size, 3)
    turn = 2 * np.pi * np.arange(32) / 32
    legs = 2 * np.pi * np.arange(int(rng.integers(3, 6)))
    legs = legs / len(legs)
    circle = [
        np.array([x, y]) + r * np.column_stack([np.cos(a), np.sin(a)])
        for r, a in ((radius, turn), (0.9 * radius, legs))
    ]
    return Outline(kind, (), (float(x), float(y), radius), circle[0], np.round(circle[1], 4))


def rounded(points: Floats) -> Floats:
    """Return points to a millimetre."""
    return np.asarray(np.round(points, 3), dtype=np.float64)


def rectangle(rng: np.random.Generator, size: float) -> tuple[list[Floats], Floats]:
    """Return a rectangle."""
    ring = box(-size, -size * float(rng.uniform(0.4, 1.0)), *(2 * [np.nan]))
    return [ring], ring


def box(x: float, y: float, right: float, top: float) -> Floats:
    """Return the corners of an axis-aligned box; centred at the origin if `right` and `top` are NaN."""
    right, top = (-x if np.isnan(right) else right), (-y if np.isnan(top) else top)
    return np.array([[x, y], [right, y], [right, top], [x, top]])


def ell(rng: np.random.Generator, size: float) -> tuple[list[Floats], Floats]:
    """Return an L of two boxes."""
    w, d = size, size * float(rng.uniform(0.6, 1.0))
    a, b = rng.uniform(0.5, 0.9, 2) * d
    ring = np.array([[-w, -d], [w, -d], [w, a - d], [b - w, a - d], [b - w, d], [-w, d]])
    return [box(-w, -d, w, a - d), box(-w, a - d, b - w, d)], ring


def tee(rng: np.random.Generator, size: float) -> tuple[list[Floats], Floats]:
    """Return a T of two boxes."""
    w, d = size, size * float(rng.uniform(0.6, 1.0))
    stem, bar = float(rng.uniform(0.2, 0.5)) * w, float(rng.uniform(0.4, 0.9)) * d
    ring = np.array(
        [
            [-stem, -d],
            [stem, -d],
            [stem, d - bar],
            [w, d - bar],
            [w, d],
            [-w, d],
            [-w, d - bar],
            [-stem, d - bar],
        ]
    )
    return [box(-stem, -d, stem, d - bar), box(-w, d - bar, w, d)], ring


def triangle(rng: np.random.Generator, size: float) -> tuple[list[Floats], Floats]:
    """Return a triangle without acute corners."""
    turn = np.array([0.0, 2.0, 4.0]) * np.pi / 3 + rng.uniform(-0.35, 0.35, 3)
    ring = 1.2 * size * np.column_stack([np.cos(turn), np.sin(turn)])
    return [ring], ring


def polygon(rng: np.random.Generator, size: float) -> tuple[list[Floats], Floats]:
    """Return a convex polygon of five to eight corners on an ellipse."""
    n = int(rng.integers(5, 9))
    turn = 2 * np.pi * (np.arange(n) + rng.uniform(-0.25, 0.25, n)) / n
    ring = size * np.column_stack([np.cos(turn), float(rng.uniform(0.6, 1.0)) * np.sin(turn)])
    return [ring], ring


def disc(rng: np.random.Generator, size: float) -> tuple[list[Floats], Floats]:
    """Return the points from which the frame of a disc is drawn."""
    return [], size * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


OUTLINE_FACTORIES = {
    "rectangle": rectangle,
    "ell": ell,
    "tee": tee,
    "triangle": triangle,
    "disc": disc,
    "polygon": polygon,
}


def inset_corners(ring: Floats, by: float) -> Floats:
    """Return the corners moved inwards, `by` from both edges."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    m, n = left_normals(before), left_normals(after)
    return np.asarray(np.round(ring + by * (m + n) / (1.0 + np.sum(m * n, axis=1))[:, None], 4))


def left_normals(edges: Floats) -> Floats:
    """Return the unit normals (n, 2) to the left of edges."""
    return np.asarray(np.column_stack([-edges[:, 1], edges[:, 0]]) / np.hypot(*edges.T)[:, None])
