"""Random outlines: rectangles, L, T, triangles, discs and polygons, with off-centre frames."""

from __future__ import annotations

import numpy as np

from trundle.experiments.blind.outline import Outline, circle, inset_corners
from trundle.experiments.sampling import Floats, log_uniform

__all__ = ["draw_outline"]

PROBABILITIES = {
    "rectangle": 0.25,
    "ell": 0.15,
    "tee": 0.15,
    "triangle": 0.15,
    "disc": 0.15,
    "polygon": 0.15,
}
FEET_INSET = 0.08
"""Distance of the feet from the edges, as a share of the radius of gyration."""
DISC_FEET_RADIUS = 0.9
"""Radius of the circle of a disc's feet over that of the disc."""


def draw_outline(rng: np.random.Generator) -> Outline:
    """Return an outline of random kind, size and frame."""
    kind = str(rng.choice(tuple(PROBABILITIES), p=tuple(PROBABILITIES.values())))
    size = log_uniform(rng, 0.2, 0.7)
    parts = [size * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])]
    ring = parts[0]
    if kind in RINGS:
        parts = [ring := RINGS[kind](rng, size)]
    elif kind in CROSSES:
        ring, parts = CROSSES[kind](rng, size)
    corner = rng.random() < 0.15
    off = ring[int(rng.integers(len(ring)))] if corner else rng.uniform(-0.2, 0.2, 2) * size
    if kind == "disc":
        (x, y), radius = np.round(-off, 3), round(size, 3)
        feet = np.array([x, y]) + DISC_FEET_RADIUS * radius * circle(int(rng.integers(3, 6)))
        rim = np.array([x, y]) + radius * circle(32)
        return Outline(kind, (float(x), float(y), radius), rim, np.round(feet, 4))
    moved = [np.asarray(np.round(points - off, 3), dtype=np.float64) for points in (ring, *parts)]
    ring, *parts = moved
    return Outline(kind, None, ring, inset_corners(ring, FEET_INSET * size, 4), parts=tuple(parts))


def box(x: float, y: float, right: float, top: float) -> Floats:
    """Return the corners of an axis-aligned box."""
    return np.array([[x, y], [right, y], [right, top], [x, top]])


def rectangle(rng: np.random.Generator, size: float) -> Floats:
    """Return a rectangle about the origin."""
    depth = size * float(rng.uniform(0.4, 1.0))
    return box(-size, -depth, size, depth)


def triangle(rng: np.random.Generator, size: float) -> Floats:
    """Return a triangle without acute corners."""
    turn = np.array([0.0, 2.0, 4.0]) * np.pi / 3 + rng.uniform(-0.35, 0.35, 3)
    return 1.2 * size * np.column_stack([np.cos(turn), np.sin(turn)])


def polygon(rng: np.random.Generator, size: float) -> Floats:
    """Return a convex polygon of five to eight corners on an ellipse."""
    n = int(rng.integers(5, 9))
    turn = 2 * np.pi * (np.arange(n) + rng.uniform(-0.25, 0.25, n)) / n
    return size * np.column_stack([np.cos(turn), float(rng.uniform(0.6, 1.0)) * np.sin(turn)])


def ell(rng: np.random.Generator, size: float) -> tuple[Floats, list[Floats]]:
    """Return an L, and its two boxes."""
    w, d = size, size * float(rng.uniform(0.6, 1.0))
    a, b = rng.uniform(0.5, 0.9, 2) * d
    ring = np.array([[-w, -d], [w, -d], [w, a - d], [b - w, a - d], [b - w, d], [-w, d]])
    return ring, [box(-w, -d, w, a - d), box(-w, a - d, b - w, d)]


def tee(rng: np.random.Generator, size: float) -> tuple[Floats, list[Floats]]:
    """Return a T, and its two boxes."""
    w, d = size, size * float(rng.uniform(0.6, 1.0))
    stem, bar = float(rng.uniform(0.2, 0.5)) * w, float(rng.uniform(0.4, 0.9)) * d
    right = np.array([[stem, -d], [stem, d - bar], [w, d - bar], [w, d]])
    ring = np.vstack([[-stem, -d], right, (right * [-1.0, 1.0])[:0:-1]])
    return ring, [box(-stem, -d, stem, d - bar), box(-w, d - bar, w, d)]


RINGS = {"rectangle": rectangle, "triangle": triangle, "polygon": polygon}
"""Convex outlines."""
CROSSES = {"ell": ell, "tee": tee}
"""Outlines of several parts."""
