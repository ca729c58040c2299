"""Unit quaternions (w, x, y, z) as rows of an array, and their heading and tilt."""

from __future__ import annotations

import numpy as np

from trundle.importers.layout import Floats

__all__ = ["from_axes", "from_heading", "from_rpy", "heading", "product", "rotate", "tilt"]


def product(a: Floats, b: Floats) -> Floats:
    """Return the product a⊗b, that is rotation b followed by a; (4,) or (n, 4) each, normalised."""
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    u, v = a[..., 1:], b[..., 1:]
    real = a[..., :1] * b[..., :1] - np.sum(u * v, axis=-1, keepdims=True)
    imaginary = a[..., :1] * v + b[..., :1] * u + np.cross(u, v)
    return normalised(np.concatenate([real, imaginary], axis=-1))


def rotate(q: Floats, v: Floats) -> Floats:
    """Rotate vectors v (3,) or (n, 3) by q (4,) or (n, 4)."""
    q = normalised(q)
    v = np.asarray(v, dtype=np.float64)
    u = q[..., 1:]
    return np.asarray(v + 2.0 * np.cross(u, np.cross(u, v) + q[..., :1] * v), dtype=np.float64)


def normalised(q: Floats) -> Floats:
    """Return quaternions (4,) or (n, 4) scaled to unit length."""
    q = np.asarray(q, dtype=np.float64)
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True), dtype=np.float64)


def heading(q: Floats) -> Floats:
    """Return the angle about world z, rad in (-pi, pi], of approximately upright frames; (n,)."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.asarray(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)), dtype=np.float64)


def tilt(q: Floats) -> Floats:
    """Return the angle between the z axes of frame and world, rad in [0, pi]; (n,)."""
    _, x, y, _ = np.moveaxis(q, -1, 0)
    return np.asarray(np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0)), dtype=np.float64)


def from_heading(theta: Floats) -> Floats:
    """Return the rotations by theta (n,), rad, about z; (n, 4)."""
    zero = np.zeros_like(theta)
    return np.column_stack([np.cos(theta / 2.0), zero, zero, np.sin(theta / 2.0)])


def from_rpy(rpy: Floats) -> Floats:
    """Return the rotation by roll, pitch, yaw (3,), rad, about fixed x, then y, then z; (4,)."""
    half = np.asarray(rpy, dtype=np.float64)[:, None] / 2.0
    roll, pitch, yaw = np.cos(half) * [1.0, 0.0, 0.0, 0.0] + np.sin(half) * np.eye(3, 4, 1)
    return product(yaw, product(pitch, roll))


def from_axes(x: Floats, y: Floats) -> Floats:
    """Return the rotation that maps the orthonormal vectors x and y (3,) to the axes x and y; (4,)."""
    rows = np.vstack([x, y, np.cross(x, y)])
    # 4 q qᵀ, each row of which is a multiple of q; the longest row is the most accurate (Shepperd 1978).
    twist = np.array([rows[2, 1] - rows[1, 2], rows[0, 2] - rows[2, 0], rows[1, 0] - rows[0, 1]])
    outer = np.empty((4, 4))
    outer[0, 0] = 1.0 + np.trace(rows)
    outer[0, 1:] = outer[1:, 0] = twist
    outer[1:, 1:] = rows + rows.T + (1.0 - np.trace(rows)) * np.eye(3)
    return normalised(outer[np.argmax(np.diag(outer))])
