"""Unit quaternions (w, x, y, z) as rows of an array, and their heading and tilt; scipy does the algebra."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from trundle.importers.layout import Floats

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["from_axes", "from_heading", "from_rpy", "heading", "product", "rotate", "tilt"]


def rotation(q: Floats) -> Rotation:
    """Return quaternions (4,) or (n, 4) as rotations."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def quaternions(rotations: Rotation) -> Floats:
    """Return rotations as quaternions, (4,) or (n, 4)."""
    return np.asarray(np.roll(rotations.as_quat(), 1, axis=-1), dtype=np.float64)


def product(a: Floats, b: Floats) -> Floats:
    """Return the product a⊗b, that is rotation b followed by a; (4,) or (n, 4) each."""
    return quaternions(rotation(a) * rotation(b))


def rotate(q: Floats, v: Floats) -> Floats:
    """Rotate vectors v (3,) or (n, 3) by q (4,) or (n, 4)."""
    return np.asarray(rotation(q).apply(v), dtype=np.float64)


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
    from scipy.spatial.transform import Rotation

    return quaternions(Rotation.from_euler("xyz", rpy))


def from_axes(x: Floats, y: Floats) -> Floats:
    """Return the rotation that maps the orthonormal vectors x and y (3,) to the axes x and y; (4,)."""
    from scipy.spatial.transform import Rotation

    return quaternions(Rotation.from_matrix(np.vstack([x, y, np.cross(x, y)])))
