"""Unit quaternions (w, x, y, z) as rows of an array, and their heading and tilt."""

from __future__ import annotations

import numpy as np

from trundle.importers.layout import Floats

__all__ = ["conjugate", "heading", "product", "rotate", "tilt"]


def product(a: Floats, b: Floats) -> Floats:
    """Return the product a⊗b, that is rotation b followed by a; (..., 4) each."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def conjugate(q: Floats) -> Floats:
    """Return the inverse rotation of (..., 4) unit quaternions."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]), dtype=np.float64)


def rotate(q: Floats, v: Floats) -> Floats:
    """Rotate vectors v (..., 3) by q (..., 4)."""
    w, u = q[..., :1], q[..., 1:]
    first = np.cross(u, v)
    return np.asarray(v + 2.0 * (w * first + np.cross(u, first)), dtype=np.float64)


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
    roll, pitch, yaw = (
        np.append(np.cos(a / 2.0), np.sin(a / 2.0) * axis) for a, axis in zip(rpy, np.eye(3), strict=True)
    )
    return product(yaw, product(pitch, roll))


def from_axes(x: Floats, y: Floats) -> Floats:
    """Return the rotation that maps the orthonormal vectors x and y (3,) to the axes x and y; (4,)."""
    from scipy.spatial.transform import Rotation

    xyzw = Rotation.from_matrix(np.vstack([x, y, np.cross(x, y)])).as_quat()
    return np.asarray(np.roll(xyzw, 1), dtype=np.float64)
