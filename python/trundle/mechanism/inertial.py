"""Efforts at joints that are linear in the inertial parameters of each body, for all samples at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trundle.mechanism.rigid_groups import SECOND_MOMENTS

__all__ = [
    "Frames",
    "body_columns",
    "body_mass_matrix",
    "gravity_columns",
    "inertia_columns",
    "projected_jacobian",
]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frames:
    """Poses of bodies and joints at T samples, in world axes.

    Attributes
    ----------
    position : (T, B, 3) array
        Origins of the bodies.
    rotation : (T, B, 3, 3) array
    anchor, axis : (T, N, 3) arrays
        Of the joints.
    hinge : (N,) array of bool
        Whether a joint is a hinge; a slide otherwise.
    """

    position: Floats
    rotation: Floats
    anchor: Floats
    axis: Floats
    hinge: NDArray[np.bool_]


@dataclass(frozen=True)
class BodyMotion:
    """Motion of one body in its own axes.

    Attributes
    ----------
    acceleration : (T, 3) array
        Of the origin, gravity not included.
    field : (T, 3, 3) array
        Acceleration of a fixed point by its place: the cross-product matrix of the angular acceleration, plus
        the square of that of the angular velocity.
    linear, angular : (T, N, 3) arrays
        Velocity of the origin and angular velocity by the velocity of each joint.
    """

    acceleration: Floats
    field: Floats
    linear: Floats
    angular: Floats


def body_columns(
    frames: Frames, body: int, chain: Sequence[int], v: Floats, a: Floats, gravity: Floats
) -> tuple[Floats, Floats]:
    """Return the efforts by the inertial parameters of a body, and the part of gravity in them.

    A particle of mass m at c in the body's axes needs the effort m·Jᵀ(p̈ − g), which is linear in m, m·c and
    m·c·cᵀ (Atkeson, An & Hollerbach 1986, equation 17, with second moments in place of the inertia).

    Returns
    -------
    total : (T, N, 10) array
        By mass, three first moments, and six second moments in the order of `SECOND_MOMENTS`; off-diagonal
        columns are by the moment that represents both symmetric entries.
    weight : (T, N, 10) array
        The part of it that is due to gravity; zero for second moments.
    """
    motion = _body_motion(frames, body, chain, v, a)
    rotation = frames.rotation[:, body]
    down = np.einsum("tij,i->tj", rotation, gravity)
    weight = -_moment_columns(motion, down)
    total = _moment_columns(motion, motion.acceleration)
    basis = np.eye(3)
    # Velocity of the point e_k by each joint, without that of the origin, against its acceleration.
    lever = np.cross(motion.angular[:, :, None, :], basis)
    total[:, :, 1:4] += np.einsum("tji,tik->tjk", motion.linear, motion.field)
    second = np.einsum("tjki,til->tjkl", lever, motion.field)
    for column, (k, m) in enumerate(SECOND_MOMENTS, 4):
        total[:, :, column] = second[:, :, k, m] + (second[:, :, m, k] if k != m else 0.0)
    return total + weight, weight


def gravity_columns(frames: Frames, body: int, chain: Sequence[int], parameters: Floats) -> Floats:
    """Return the derivative of the efforts by the components of gravity, (T, N, 3), for one body.

    Parameters
    ----------
    parameters : (10,) array
        Inertial parameters of the body, less the compensated ones.
    """
    linear, angular = _jacobian(frames, body, chain)
    moment = np.einsum("tij,j->ti", frames.rotation[:, body], parameters[1:4])
    gradient: Floats = parameters[0] * linear + np.cross(angular, moment[:, None])
    return -gradient


def projected_jacobian(
    frames: Frames, body: int, chain: Sequence[int], project: Callable[[Floats], Floats]
) -> tuple[Floats, Floats]:
    """Return the velocity of a body's origin and its angular velocity, by each joint's velocity, (T, n, 3).

    Both are in the body's axes.

    Parameters
    ----------
    project : callable
        Sums velocities by each joint of the model, (T, N, 3), to those by each recorded joint, (T, n, 3).
    """
    rotation = frames.rotation[:, body]
    linear, angular = _jacobian(frames, body, chain)
    linear, angular = (np.einsum("tki,tjk->tji", rotation, project(part)) for part in (linear, angular))
    return linear, angular


def body_mass_matrix(linear: Floats, angular: Floats, parameters: Floats) -> Floats:
    """Return the part of a body in the mass matrix, (T, n, n); velocities as by `projected_jacobian`.

    Parameters
    ----------
    parameters : (10,) array
        Inertial parameters of the body, in the order of `body_columns`.
    """
    moments = np.empty((3, 3))
    for value, (k, m) in zip(parameters[4:], SECOND_MOMENTS, strict=True):
        moments[k, m] = moments[m, k] = value
    lever = np.cross(angular[:, :, None, :], np.eye(3))
    first = np.cross(angular, parameters[1:4])
    crossed = np.einsum("tik,tjk->tij", linear, first)
    squared = np.einsum("tik,tjk->tij", linear, linear)
    weighted = np.einsum("tiks,km->tims", lever, moments)
    rotating = np.einsum("tims,tjms->tij", weighted, lever)
    found: Floats = parameters[0] * squared + crossed + crossed.transpose(0, 2, 1) + rotating
    return found


def inertia_columns(linear: Floats, angular: Floats) -> Floats:
    """Return the diagonal of the mass matrix by the inertial parameters of a body, (T, n, 10).

    The velocity of a particle by that of a joint is l + cross(w, c), whose square is its part of the inertia.
    The columns are those of `body_columns`; velocities as by `projected_jacobian`.
    """
    lever = np.cross(angular[:, :, None, :], np.eye(3))
    columns = np.zeros((*linear.shape[:2], 10))
    columns[:, :, 0] = np.einsum("tji,tji->tj", linear, linear)
    columns[:, :, 1:4] = 2.0 * np.einsum("tji,tjki->tjk", linear, lever)
    second = np.einsum("tjki,tjli->tjkl", lever, lever)
    for column, (k, m) in enumerate(SECOND_MOMENTS, 4):
        columns[:, :, column] = second[:, :, k, m] * (1.0 if k == m else 2.0)
    return columns


def _moment_columns(motion: BodyMotion, acceleration: Floats) -> Floats:
    """Return the columns of mass and first moments for an acceleration of all points, in the body's axes."""
    columns = np.zeros((*motion.linear.shape[:2], 10))
    columns[:, :, 0] = np.einsum("tji,ti->tj", motion.linear, acceleration)
    # cross(w, e_k) · a = cross(a, w)_k
    columns[:, :, 1:4] = np.cross(acceleration[:, None], motion.angular)
    return columns


def _jacobian(frames: Frames, body: int, chain: Sequence[int]) -> tuple[Floats, Floats]:
    """Return velocity of the origin and angular velocity by the velocity of each joint, in world axes."""
    linear, angular = np.zeros_like(frames.axis), np.zeros_like(frames.axis)
    for j in chain:
        axis = frames.axis[:, j]
        if frames.hinge[j]:
            angular[:, j] = axis
            linear[:, j] = np.cross(axis, frames.position[:, body] - frames.anchor[:, j])
        else:
            linear[:, j] = axis
    return linear, angular


def _body_motion(frames: Frames, body: int, chain: Sequence[int], v: Floats, a: Floats) -> BodyMotion:
    """Return the motion of a body, by the recursion of Newton and Euler along its joints."""
    rotation = frames.rotation[:, body]
    linear, angular = _jacobian(frames, body, chain)
    spin, spin_rate, acceleration = _accelerations(frames, body, chain, v, a)

    spin, spin_rate, acceleration = (
        np.einsum("tki,tk->ti", rotation, vectors) for vectors in (spin, spin_rate, acceleration)
    )
    field = _skew(spin_rate) + _skew(spin) @ _skew(spin)
    return BodyMotion(
        acceleration=acceleration,
        field=field,
        linear=np.einsum("tki,tjk->tji", rotation, linear),
        angular=np.einsum("tki,tjk->tji", rotation, angular),
    )


def _accelerations(
    frames: Frames, body: int, chain: Sequence[int], v: Floats, a: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return angular velocity, angular acceleration and acceleration of the origin, in world axes."""
    spin = np.zeros((len(v), 3))
    spin_rate, point_velocity, point_acceleration, point = (np.zeros_like(spin) for _ in range(4))

    def move(to: Floats) -> None:
        """Go to another point of the same body."""
        nonlocal point, point_velocity, point_acceleration
        arm = to - point
        turning = np.cross(spin, arm)
        point_velocity = point_velocity + turning
        point_acceleration = point_acceleration + np.cross(spin_rate, arm) + np.cross(spin, turning)
        point = to

    for j in chain:
        move(frames.anchor[:, j])
        rate, axis = v[:, j, None] * frames.axis[:, j], frames.axis[:, j]
        if frames.hinge[j]:
            spin_rate = spin_rate + a[:, j, None] * axis + np.cross(spin, rate)
            spin = spin + rate
        else:
            point_acceleration = point_acceleration + a[:, j, None] * axis + 2 * np.cross(spin, rate)
            point_velocity = point_velocity + rate
    move(frames.position[:, body])
    return spin, spin_rate, point_acceleration


def _skew(vectors: Floats) -> Floats:
    """Return the matrices of the cross product with vectors."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
